"use strict";
// A place of a sheet that the reader has chosen: where it is, every value, and the shown value over all frames.
weavesim.Probe = class {
  constructor(page, container) {
    Object.assign(this, { page, container, chosen: null, turn: 0 });
    this.show();
  }

  // `at`: sheet, element, and if they are known the point, the point on the flat blank and the mirror factors.
  async choose(at) {
    this.chosen = at;
    await this.show();
  }

  async show() {
    const { make, text, withUnit } = weavesim;
    const turn = (this.turn += 1);
    if (this.chosen === null) {
      this.container.replaceChildren(
        make("p", { class: "note" }, "Click the sheet to read its values there, over all frames."));
      this.page.view?.setPin(null);
      return null;
    }
    const { sheet, element } = this.chosen;
    const [x, y] = this.chosen.factors || [1, 1];
    const flat = (this.chosen.flat || sheet.flatCentre(element)).map((value, c) => value * [x, y][c]);
    const centre = sheet.centre(element);
    const point = [x * centre[0], y * centre[1], centre[2] + sheet.group.position.z];
    this.page.view.setPin(point);
    const values = {};
    const frame = this.page.frame;
    for (const field of sheet.given.fields) {
      const series = await sheet.values(field.name);
      const at = weavesim.placeOf(field, frame);
      values[field.name] = at < 0 ? NaN : series.value(at, element);
    }
    for (const field of this.page.derived(sheet)) {
      values[field.name] = (await this.page.valuesOf(sheet, field, frame))[element];
    }
    if (turn !== this.turn) return null;
    const list = make("dl");
    for (const field of this.page.fieldsOf(sheet)) {
      const kind = field.name === this.page.field.name ? "chosen" : "";
      list.append(make("div", { class: kind, "data-field": field.name },
        make("dt", {}, field.label), make("dd", {}, withUnit(values[field.name], field.unit, 5))));
    }
    const name = this.page.sheets.length > 1 ? `${sheet.name}, ` : "";
    const mirrored = x < 0 || y < 0 ? " (mirrored)" : "";
    const place = (point_) => point_.map((value) => text(Number(value.toFixed(2)))).join(", ");
    this.container.replaceChildren(
      make("h3", {}, `${name}element ${element}${mirrored}`),
      make("p", {}, `material point (${place(flat)}) mm on the flat blank; element now at (${place(point)}) mm `,
        make("button", { type: "button", onclick: () => this.choose(null) }, "Clear")),
      list,
      await this.history(sheet, element),
    );
    this.last = { sheet: sheet.name, element, flat, point, values };
    return this.last;
  }

  // The shown field of the element over all frames.
  async history(sheet, element) {
    const box = weavesim.make("div", { class: "charts small" });
    const { field } = this.page;
    const series = field.of ? null : await sheet.values(field.name);
    if (series === null || field.lastOnly || sheet.frameCount < 2) return box;
    const frames = field.at || this.page.progress.map((_, k) => k);
    const y = frames.map((_, place) => series.value(place, element)).map((value) => (Number.isNaN(value) ? null : value));
    const unit = field.unit ? ` [${field.unit}]` : "";
    const given = {
      title: "", xLabel: this.page.progressLabel, yLabel: field.label + unit, x: frames.map((k) => this.page.progress[k]),
      lines: [{ label: field.label, y }], logarithmic: false,
    };
    requestAnimationFrame(() => {
      if (!box.isConnected) return;
      const made = weavesim.chart(box, given, 150);
      made.marked = this.page.progress[this.page.frame];
      made.plot.redraw(false);
    });
    return box;
  }
};
