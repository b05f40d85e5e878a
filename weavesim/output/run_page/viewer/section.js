"use strict";
// Sections through sheets and tools at any place, drawn to scale in millimetres.
weavesim.Section = class {
  constructor(view, container) {
    Object.assign(this, { view, container, kind: "none", offset: 0, angle: 0, flipped: false });
  }

  get on() {
    return this.kind !== "none";
  }

  // Normal of the plane, and the two axes within it, the second one upwards where there is one.
  get frame() {
    const turn = (Math.PI / 180) * this.angle;
    const frames = {
      x: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
      y: [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
      z: [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
      any: [[-Math.sin(turn), Math.cos(turn), 0], [Math.cos(turn), Math.sin(turn), 0], [0, 0, 1]],
    };
    return frames[this.kind];
  }

  get names() {
    return { x: ["y", "z"], y: ["x", "z"], z: ["x", "y"], any: ["along", "z"] }[this.kind];
  }

  // Smallest and largest offset that meets a sheet.
  get range() {
    const [low, high] = this.view.box();
    const normal = this.frame[0];
    let [least, most] = [Infinity, -Infinity];
    for (let corner = 0; corner < 8; corner += 1) {
      const at = normal.reduce((sum, n, c) => sum + n * ((corner >> c) & 1 ? high[c] : low[c]), 0);
      [least, most] = [Math.min(least, at), Math.max(most, at)];
    }
    return [least, most];
  }

  update() {
    this.container.hidden = !this.on;
    if (!this.on) {
      this.view.setCut(null, 0);
      this.view.setLines(this.view.cutLines, new Float32Array(0));
      this.view.draw();
      return;
    }
    const [normal] = this.frame;
    const sign = this.flipped ? -1 : 1;
    this.view.setCut(normal.map((n) => sign * n), sign * this.offset);
    this.pieces = this.cut();
    const points = this.pieces.filter((piece) => piece.sheet).flatMap((piece) => piece.segments.flat(2));
    this.view.setLines(this.view.cutLines, new Float32Array(points));
    this.drawPanel();
    this.view.draw();
  }

  // Segments in space of every sheet and tool that is shown.
  cut() {
    const [normal] = this.frame;
    const found = [];
    for (const sheet of this.view.sheets) {
      if (!sheet.group.visible) continue;
      const lift = sheet.group.position.z;
      const segments = [];
      sheet.given.copies.forEach(([x, y], place) => {
        if (!sheet.copies[place].visible) return;
        const point = (node) => [x * sheet.nodes[3 * node], y * sheet.nodes[3 * node + 1], sheet.nodes[3 * node + 2] + lift];
        for (let e = 0; e < sheet.elementCount; e += 1) {
          if (!sheet.has(e)) continue;
          const corner = [0, 1, 2, 3].map((k) => point(sheet.quads[4 * e + k]));
          segments.push(...this.through([corner[0], corner[1], corner[2]], normal),
            ...this.through([corner[0], corner[2], corner[3]], normal));
        }
      });
      found.push({ name: sheet.name, sheet: true, thickness: sheet.given.thickness, colour: sheet.given.colour, segments });
    }
    for (const tool of this.view.tools) {
      if (!tool.mesh.visible) continue;
      const at = tool.mesh.matrix.elements; // column by column
      const point = (node) => [0, 1, 2].map((c) => at[12 + c]
        + [0, 1, 2].reduce((sum, k) => sum + at[4 * k + c] * tool.vertices[3 * node + k], 0));
      const segments = [];
      for (let i = 0; i < tool.faces.length; i += 3) {
        segments.push(...this.through([point(tool.faces[i]), point(tool.faces[i + 1]), point(tool.faces[i + 2])], normal));
      }
      const [red, green, blue] = tool.given.colour.map((x) => Math.round(200 * x));
      found.push({ name: tool.name, sheet: false, colour: `rgb(${red} ${green} ${blue})`, segments });
    }
    return found;
  }

  // None or one segment of a triangle in the plane.
  through(corner, normal) {
    // off the nodes that lie on the plane
    const at = corner.map((x) => x[0] * normal[0] + x[1] * normal[1] + x[2] * normal[2] - this.offset - 1e-5);
    if (at[0] > 0 === at[1] > 0 && at[1] > 0 === at[2] > 0) return [];
    const ends = [];
    for (let k = 0; k < 3; k += 1) {
      const [a, b] = [k, (k + 1) % 3];
      if (at[a] > 0 === at[b] > 0) continue;
      const share = at[a] / (at[a] - at[b]);
      ends.push(corner[a].map((x, c) => x + share * (corner[b][c] - x)));
    }
    return [ends];
  }

  plane(point) {
    const [, along, up] = this.frame;
    return [along, up].map((axis) => axis.reduce((sum, x, c) => sum + x * point[c], 0));
  }

  drawPanel() {
    const { make, text } = weavesim;
    const drawn = this.pieces.map((piece) => ({
      ...piece, flat: piece.segments.map((ends) => ends.map((end) => this.plane(end))),
    }));
    const own = drawn.filter((piece) => piece.sheet).flatMap((piece) => piece.flat.flat());
    const what = this.kind === "any"
      ? `plane at ${text(this.angle)}° to x, ${text(this.offset)} mm from the middle`
      : `${this.kind} = ${text(this.offset)} mm`;
    const heading = make("h3", {}, `Section at ${what}`);
    const save = make("button", { type: "button", onclick: () => this.save(drawn) }, "Save as CSV");
    if (own.length === 0) {
      this.container.replaceChildren(heading, make("p", { class: "note" }, "No sheet is cut here."));
      return;
    }
    const low = [0, 1].map((c) => own.reduce((least, point) => Math.min(least, point[c]), Infinity));
    const high = [0, 1].map((c) => own.reduce((most, point) => Math.max(most, point[c]), -Infinity));
    const margin = 0.05 * Math.max(high[0] - low[0], 1) + 3;
    const [width, height] = [0, 1].map((c) => high[c] - low[c] + 2 * margin);
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    const font = width / 95;
    svg.setAttribute("viewBox", `${low[0] - margin} ${-high[1] - margin} ${width} ${height + 3 * font}`);
    const draw = (name, attributes, content) => {
      const made = document.createElementNS("http://www.w3.org/2000/svg", name);
      for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
      if (content) made.textContent = content;
      svg.append(made);
    };
    const step = weavesim.niceStep(width / 10);
    for (let x = Math.ceil((low[0] - margin) / step) * step; x <= high[0] + margin; x += step) {
      draw("line", { x1: x, x2: x, y1: -high[1] - margin, y2: -low[1] + margin, stroke: "#e6e8ec", "stroke-width": 0.12 * font });
      draw("text", { x, y: -low[1] + margin + 1.2 * font, "text-anchor": "middle", style: `font-size:${font}px` }, text(x));
    }
    for (let y = Math.ceil((low[1] - margin) / step) * step; y <= high[1] + margin; y += step) {
      draw("line", { x1: low[0] - margin, x2: high[0] + margin, y1: -y, y2: -y, stroke: "#e6e8ec", "stroke-width": 0.12 * font });
      draw("text", { x: low[0] - margin + 0.3 * font, y: -y - 0.25 * font, style: `font-size:${font}px` }, text(y));
    }
    draw("text", { x: high[0] + margin, y: -low[1] + margin + 2.5 * font, "text-anchor": "end", style: `font-size:${font}px` },
      `${this.names[0]} [mm] across, ${this.names[1]} [mm] up, equal scales, sheets in their initial thickness`);
    const round = (x) => x.toFixed(3);
    for (const piece of drawn) {
      const path = piece.flat.map(([a, b]) => `M${round(a[0])} ${round(-a[1])}L${round(b[0])} ${round(-b[1])}`).join("");
      if (path === "") continue;
      draw("path", {
        d: path, fill: "none", stroke: piece.colour, "stroke-linecap": "round",
        "stroke-width": piece.sheet ? Math.max(piece.thickness, 0.15 * font) : 0.14 * font,
      });
    }
    const names = drawn.filter((piece) => piece.flat.length > 0).map((piece) => {
      const swatch = make("span", { class: "swatch" });
      swatch.style.background = piece.colour;
      return make("span", {}, swatch, ` ${piece.name}  `);
    });
    this.container.replaceChildren(heading, make("p", {}, ...names, save), svg);
  }

  save(drawn) {
    const rows = drawn.flatMap((piece) => piece.flat.map((ends, k) => {
      const quoted = `"${piece.name.replaceAll('"', '""')}"`;
      return [quoted, k, ...ends.flat().map((x) => x.toFixed(4))].join(",");
    }));
    const [a, b] = this.names;
    weavesim.save("section.csv", `part,segment,${a}_1_mm,${b}_1_mm,${a}_2_mm,${b}_2_mm\n${rows.join("\n")}\n`, "text/csv");
  }
};

// 1, 2 or 5 times a power of ten, at least `least`.
weavesim.niceStep = (least) => {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((x) => x * power).find((x) => x >= least);
};
