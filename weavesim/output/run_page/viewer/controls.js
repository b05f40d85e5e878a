"use strict";
// Everything that the reader can set, and what is written beside the picture.
weavesim.Controls = class {
  constructor(page) {
    this.page = page;
    this.panel = document.getElementById("controls");
    this.panel.replaceChildren(...[
      this.ofColours(), this.ofView(), this.ofSheets(), this.ofTools(), this.ofCut(),
    ].filter((part) => part !== null));
    this.panel.onscroll = () => this.hint();
    new ResizeObserver(() => this.hint()).observe(this.panel);
    this.timeline();
    page.onColour = () => this.write();
    page.onField = () => {
      this.menu.value = page.field.name;
    };
  }

  // Says that there is more below, where the panel is scrolled.
  hint() {
    const { scrollHeight, scrollTop, clientHeight } = this.panel;
    this.panel.classList.toggle("more", scrollHeight - scrollTop - clientHeight > 4);
  }

  group(title, ...children) {
    return weavesim.make("fieldset", {}, weavesim.make("legend", {}, title), ...children);
  }

  check(label, on, change, swatch = null) {
    const box = weavesim.make("input", { type: "checkbox", checked: on, onchange: () => change(box.checked) });
    const colour = swatch === null ? null : weavesim.make("span", { class: "swatch" });
    if (colour) colour.style.background = swatch;
    return weavesim.make("label", {}, box, colour, label);
  }

  select(id, options, change) {
    const made = weavesim.make("select", { id, "aria-label": id, onchange: () => change(made.value) });
    for (const [value, label] of options) made.append(weavesim.make("option", { value }, label));
    return made;
  }

  ofColours() {
    const { page } = this;
    const { make } = weavesim;
    this.menu = this.select("field", page.fields.map((field) => [
      field.name, field.label + (field.unit ? ` [${field.unit}]` : "")]),
    (name) => page.setField(name));
    this.about = make("p", { class: "note" });
    const map = this.select("colours", Object.keys(page.colours.tables).map((name) => [name, name]), (name) => {
      page.colours.name = name;
      page.recolour();
    });
    const bound = this.select("bound", [["98", "98 % of area"], ["90", "90 % of area"], ["100", "all values"]], (value) => {
      page.bound = value;
      page.manual = null;
      page.recolour();
    });
    const scope = this.select("scope", [["last", "last frame"], ["one", "this frame"], ["all", "all frames"]], (value) => {
      page.scope = value;
      page.manual = null;
      page.recolour();
    });
    const own = () => {
      const [low, high] = [this.low.value, this.high.value].map(Number);
      if (this.low.value !== "" && this.high.value !== "" && high > low) {
        page.manual = [low, high];
        page.recolour();
      }
    };
    [this.low, this.high] = ["smallest", "largest"].map((label) =>
      make("input", { type: "number", step: "any", "aria-label": `${label} shown value`, onchange: own }));
    return this.group("Colours", this.menu, this.about, make("div", { class: "pair" }, bound, scope),
      make("div", { class: "pair" }, this.low, this.high, map));
  }

  ofView() {
    const { page } = this;
    const { view } = page;
    const { make } = weavesim;
    const lines = (name) => (on) => {
      for (const sheet of page.sheets) {
        sheet[name].visible = on;
        sheet.moveLines();
        sheet.sync();
      }
      view.draw();
    };
    const looks = [["oblique", "oblique"], ["below", "from below"], ["top", "top"], ["front", "front"], ["side", "side"]];
    const buttons = looks.map(([name, label]) => make("button", { type: "button", onclick: () => view.look(name) }, label));
    const picture = make("button", { type: "button", onclick: () => {
      view.drawNow();
      view.canvas.toBlob((blob) => weavesim.save("view.png", blob));
    } }, "save PNG");
    return this.group("View", make("div", { class: "buttons" }, ...buttons, picture),
      this.check("yarn directions (warp black)", false, lines("yarnBars")),
      this.check("mesh", false, lines("meshLines")));
  }

  ofSheets() {
    const { page } = this;
    const parts = [];
    const cut = page.sheets.some((sheet) => sheet.given.copies.length > 1);
    if (cut) {
      parts.push(this.check("whole part, mirrored", true, (on) => {
        for (const sheet of page.sheets) sheet.copies.forEach((copy, k) => {
          copy.visible = on || k === 0;
        });
        page.section.update();
        page.view.look("oblique");
      }));
    }
    if (page.sheets.length > 1) {
      for (const sheet of page.sheets) {
        parts.push(this.check(sheet.name, true, (on) => {
          sheet.group.visible = on;
          page.section.update();
          page.view.draw();
        }, sheet.given.colour));
      }
      const apart = weavesim.make("input", { type: "range", min: 0, max: 1, step: 0.01, value: 0, "aria-label": "sheets apart",
        oninput: () => page.explode(Number(apart.value)) });
      parts.push(weavesim.make("label", {}, "apart", apart));
    }
    return parts.length ? this.group(page.sheets.length > 1 ? "Plies" : "Part", ...parts) : null;
  }

  ofTools() {
    const { page } = this;
    if (page.view.tools.length === 0) return null;
    const parts = page.view.tools.map((tool) => {
      const [red, green, blue] = tool.given.colour.map((x) => Math.round(255 * x));
      return this.check(tool.name, tool.wanted, (on) => {
        page.view.showTool(tool, on);
        page.section.update();
        page.view.draw();
      }, `rgb(${red} ${green} ${blue})`);
    });
    const opacity = weavesim.make("input", { type: "range", min: 0.1, max: 1, step: 0.05, value: weavesim.TOOL_OPACITY, "aria-label": "opacity of the tools",
      oninput: () => {
        for (const tool of page.view.tools) page.view.setOpacity(tool, Number(opacity.value));
        page.view.draw();
      } });
    return this.group("Tools", weavesim.make("div", { class: "row" }, ...parts), weavesim.make("label", {}, "opacity", opacity));
  }

  ofCut() {
    const { page } = this;
    const { section } = page;
    const { make } = weavesim;
    const offset = make("input", { type: "range", step: "any", "aria-label": "place of the cut", id: "cut-offset" });
    const typed = make("input", { type: "number", step: "any", "aria-label": "place of the cut [mm]" });
    const angle = make("input", { type: "number", step: 5, value: 45, "aria-label": "angle of the cut to x [degrees]" });
    const more = make("div", { hidden: true }, make("label", {}, "place [mm]", typed), offset,
      this.check("other side", false, (on) => {
        section.flipped = on;
        section.update();
      }));
    const turned = make("label", { hidden: true }, "angle to x [°]", angle);
    more.prepend(turned);
    const place = (value) => {
      section.offset = Number(value);
      [offset.value, typed.value] = [section.offset, Number(section.offset.toFixed(2))];
      section.update();
    };
    offset.addEventListener("input", () => place(offset.value));
    typed.addEventListener("change", () => place(typed.value));
    const aim = () => {
      more.hidden = !section.on;
      requestAnimationFrame(() => this.hint());
      turned.hidden = section.kind !== "any";
      if (!section.on) {
        section.update();
        return;
      }
      section.angle = Number(angle.value);
      const [least, most] = section.range;
      [offset.min, offset.max] = [least, most];
      // off the nodes on a plane of symmetry nothing changes; a level cut begins at half the height
      place(section.kind === "z" || least > 0 || most < 0 ? 0.5 * (least + most) : 0);
    };
    angle.addEventListener("change", aim);
    const kind = this.select("cut", [["none", "no cut"], ["y", "y = ... (along x)"], ["x", "x = ... (along y)"], ["any", "at an angle"], ["z", "z = ... (level)"]], (value) => {
      section.kind = value;
      aim();
    });
    return this.group("Cut and section", kind, more);
  }

  timeline() {
    const { page } = this;
    const { make } = weavesim;
    this.slider = make("input", { type: "range", id: "frame", min: 0, max: page.frameCount - 1, step: 1, "aria-label": "frame",
      oninput: () => page.setFrame(Number(this.slider.value)) });
    this.said = make("output", { id: "frame-text" });
    const play = make("button", { type: "button", id: "play", onclick: () => this.play(play) }, "Play");
    document.getElementById("timeline").replaceChildren(play, this.slider, this.said);
  }

  stop() {
    clearInterval(this.playing);
    this.playing = null;
  }

  play(button) {
    if (this.playing) {
      this.stop();
      button.textContent = "Play";
      return;
    }
    button.textContent = "Stop";
    this.playing = setInterval(async () => {
      if (this.busy) return;
      this.busy = true;
      const { stops, frame } = this.page;
      await this.page.setFrame(stops.find((k) => k > frame) ?? stops[0]);
      this.busy = false;
    }, Math.max(40, 4000 / this.page.frameCount));
  }

  // Everything that depends on frame, field and range.
  write() {
    const { page } = this;
    const { make, withUnit, text } = weavesim;
    const { index, time, stroke, stage } = page.scene.frames;
    const k = page.frame;
    const kept = page.scene.frameCount > page.frameCount ? ` (${page.frameCount} of ${page.scene.frameCount} frames are on this page)` : "";
    this.slider.value = k;
    this.said.textContent =
      `frame ${index[k]}${stage[k] ? `, ${stage[k]}` : ""}, time ${time[k] >= 1 ? withUnit(time[k], "s") : withUnit(1000 * time[k], "ms")}, stroke ${text(Number((1000 * stroke[k]).toFixed(2)))}\u202fmm${kept}`;
    const some = page.field.at ? `; in ${page.field.at.length} of the ${page.frameCount} frames of this page, at which the slider stops` : "";
    const coarse = page.field.steps ? `; rounded to ${text(page.field.steps, 5)} steps of its range` : "";
    this.about.textContent = page.field.description + (page.field.lastOnly ? "; at the last frame only" : some) + coarse;
    if (!page.manual) [this.low.value, this.high.value] = [page.colours.low, page.colours.high].map((x) => Number(x.toPrecision(4)));
    const note = page.manual ? "own range"
      : `${{ 98: "1st–99th percentile", 90: "5th–95th percentile", 100: "smallest–largest" }[page.bound]}, ${{ last: "last frame", one: "this frame", all: "all frames" }[page.rangeScope]}`;
    page.colours.legend(document.getElementById("legend"), page.field, note);
    const found = page.extremes();
    const box = document.getElementById("extremes");
    const unit = page.field.unit;
    const place = (what, at) => {
      const [x, y] = at.sheet.flatCentre(at.element).map((value) => text(Number(value.toFixed(1))));
      const name = page.sheets.length > 1 ? `${at.sheet.name}, ` : "";
      return make("p", {}, `${what} `, make("b", {}, withUnit(at.value, unit)), ` in `,
        make("button", { type: "button", onclick: () => page.chooseElement(page.sheets.indexOf(at.sheet), at.element) },
          `${name}element ${at.element}`), ` at (${x}, ${y}) mm on the flat blank`);
    };
    if (found.most === null) {
      box.replaceChildren(make("h3", {}, page.field.label),
        make("p", { class: "note" }, page.field.lastOnly ? "Only the last frame has it." : "No values."));
      return;
    }
    const heading = make("h3", {}, `${page.field.label} in this frame`);
    if (found.most.value === found.least.value) {
      box.replaceChildren(heading, make("p", {}, make("b", {}, withUnit(found.most.value, unit)), " in every element that has a value"));
      return;
    }
    box.replaceChildren(heading, place("largest", found.most), place("smallest", found.least),
      make("p", {}, `99th percentile ${withUnit(found.last, unit)}, 1st percentile ${withUnit(found.first, unit)} of the area`));
  }
};
