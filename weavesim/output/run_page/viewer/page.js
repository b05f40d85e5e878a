"use strict";
// What the reader has chosen, and everything that follows from it.
weavesim.DERIVED = [{
  name: "yarn_compression", label: "yarn compression", unit: "%", absolute: false, logarithmic: false, lastOnly: false,
  description: "shortening of the shorter of warp and weft; wrinkles need it",
  of: ["warp_stretch", "weft_stretch"],
  make: (warp, weft) => 100 * Math.max(1 - Math.min(warp, weft), 0),
}];

weavesim.Page = class {
  static async of(data) {
    const page = new weavesim.Page();
    Object.assign(page, { data, scene: data.scene, frame: 0, bound: "98", scope: "last", manual: null, ranges: new Map() });
    const frames = data.scene.frames;
    const byStroke = frames && Math.max(...frames.stroke) > Math.min(...frames.stroke);
    page.progress = frames ? (byStroke ? frames.stroke : frames.time).map((x) => 1000 * x) : [];
    page.progressLabel = byStroke ? "stroke [mm]" : "time [ms]";
    page.sheets = await Promise.all(data.scene.sheets.map((given) => weavesim.Sheet.of(given, frames.index.length)));
    page.areas = page.sheets.map((sheet) => sheet.areas());
    page.colours = new weavesim.Colours(data.colours);
    page.fields = page.menu();
    page.field = page.fields[0];
    return page;
  }

  get frameCount() {
    return this.scene.frames ? this.scene.frames.index.length : 0;
  }

  // Fields of all sheets, each once.
  menu() {
    const found = new Map();
    for (const sheet of this.sheets) for (const field of this.fieldsOf(sheet)) if (!found.has(field.name)) found.set(field.name, field);
    return [...found.values()];
  }

  derived(sheet) {
    return weavesim.DERIVED.filter((field) => field.of.every((name) => sheet.field(name)))
      .map((field) => ({ ...field, at: sheet.field(field.of[0]).at, steps: sheet.field(field.of[0]).steps }));
  }

  fieldsOf(sheet) {
    return [...sheet.given.fields, ...this.derived(sheet)];
  }

  // Shown values of a field, one per element.
  async valuesOf(sheet, field, frame) {
    if (!field.of) return sheet.shown(await sheet.values(field.name), sheet.field(field.name) || field, frame);
    const parts = await Promise.all(field.of.map((name) => sheet.values(name)));
    if (parts.includes(null)) return new Float32Array(sheet.elementCount).fill(NaN);
    const place = weavesim.placeOf(sheet.field(field.of[0]), frame);
    if (place < 0) return new Float32Array(sheet.elementCount).fill(NaN);
    const values = parts.map((series) => series.frame(place));
    return values[0].map((_, e) => field.make(...values.map((one) => one[e])));
  }

  async attach(view) {
    this.view = view;
    for (const sheet of this.sheets) view.add(sheet);
    await Promise.all(this.scene.tools.map((tool) => view.addTool(tool)));
    // in the order of the run, whichever was unpacked first
    view.tools.sort((a, b) => this.scene.tools.indexOf(a.given) - this.scene.tools.indexOf(b.given));
  }

  // Frames that have the shown field. All of them for what only the end has: the part moves all the same.
  get stops() {
    const { at, lastOnly } = this.field;
    return at && !lastOnly ? at : Array.from({ length: this.frameCount }, (_, k) => k);
  }

  // The stop nearest to a frame; a step towards another stop reaches it, however far it is.
  stopAt(frame) {
    const { stops } = this;
    const nearest = stops.reduce((best, k) => (Math.abs(k - frame) <= Math.abs(best - frame) ? k : best), stops[0]);
    if (nearest !== this.frame || frame === this.frame) return nearest;
    return stops[Math.min(Math.max(stops.indexOf(nearest) + Math.sign(frame - this.frame), 0), stops.length - 1)];
  }

  async setFrame(frame) {
    this.frame = this.stopAt(Math.min(Math.max(Math.round(frame), 0), this.frameCount - 1));
    for (const sheet of this.sheets) sheet.move(this.frame);
    this.view.moveTools(this.frame);
    if (this.section?.on) this.section.update();
    this.showRegion();
    weavesim.markCharts(this.progress[this.frame]);
    await this.recolour();
    await this.probe?.show();
    this.view.draw();
  }

  async setField(name) {
    this.field = this.fields.find((field) => field.name === name) || this.field;
    this.manual = null;
    if (!this.stops.includes(this.frame)) {
      await this.setFrame(this.frame);
      return;
    }
    await this.recolour();
    await this.probe?.show();
  }

  async recolour() {
    const { frame, field } = this;
    const shown = await Promise.all(this.sheets.map((sheet) => this.valuesOf(sheet, field, frame)));
    if (frame !== this.frame || field !== this.field) return;
    this.shown = shown;
    [this.colours.low, this.colours.high, this.rangeScope] = this.manual || await this.range();
    this.colours.logarithmic = field.logarithmic && this.colours.low > 0;
    this.sheets.forEach((sheet, k) => sheet.colour(shown[k], this.colours));
    this.onColour?.();
    this.view.draw();
  }

  // Range of the colours over all sheets, and whose it is: percentiles of the last frame, of this one, or the widest of
  // those of all.
  async range() {
    const { field, scope, bound, frame } = this;
    const key = `${field.name} ${bound} ${scope === "one" ? frame : scope}`;
    if (!this.ranges.has(key)) this.ranges.set(key, await this.rangeOf(field, bound, scope));
    return this.ranges.get(key);
  }

  async rangeOf(field, bound, scope) {
    const last = this.frameCount - 1;
    const every = field.at || Array.from({ length: this.frameCount }, (_, k) => k);
    const frames = field.lastOnly ? [last] : { last: [last], one: [this.frame], all: every }[scope];
    const cut = (1 - Number(bound) / 100) / 2;
    let [low, high] = [Infinity, -Infinity];
    for (const k of frames) {
      const arrays = await Promise.all(this.sheets.map((sheet) => this.valuesOf(sheet, field, k)));
      const [least, most] = weavesim.percentiles(arrays, this.areas, [cut, 1 - cut]);
      if (!Number.isNaN(least)) [low, high] = [Math.min(low, least), Math.max(high, most)];
    }
    // what is the same everywhere at the end, as a force that is gone, was not so before
    if (!(high > low) && scope === "last" && !field.lastOnly) return this.rangeOf(field, bound, "all");
    if (!(high >= low)) [low, high] = [0, 1];
    // sizes begin at zero
    if (field.absolute || ["yarn_compression", "wrinkle_amplitude", "wrinkle_height"].includes(field.name)) low = 0;
    // a part without wrinkles must not look like one: up to the height that the verdict allows by itself
    if (field.name === "wrinkle_height") high = Math.max(high, 2);
    if (!(high > low)) high = low + (Math.abs(low) * 1e-3 || 1);
    return [low, high, field.lastOnly ? "last" : scope];
  }

  // Smallest and largest shown value of this frame, with their elements, and percentiles.
  extremes() {
    const found = { least: null, most: null };
    (this.shown || []).forEach((values, k) => values.forEach((value, element) => {
      if (Number.isNaN(value)) return;
      if (found.least === null || value < found.least.value) found.least = { value, element, sheet: this.sheets[k] };
      if (found.most === null || value > found.most.value) found.most = { value, element, sheet: this.sheets[k] };
    }));
    const [first, last] = weavesim.percentiles(this.shown || [], this.areas, [0.01, 0.99]);
    return { ...found, first, last };
  }

  // A region of the verdict: its outline, its worst element, from near.
  async chooseRegion(place) {
    this.region = this.data.regions[place];
    await this.setFrame(this.frameCount - 1);
    await this.setField(this.region.field);
    this.onField?.();
    await this.chooseElement(this.region.sheet, this.region.worst);
  }

  async chooseElement(place, element) {
    const sheet = this.sheets[place];
    await this.probe.choose({ sheet, element });
    const point = sheet.centre(element);
    this.view.approach([point[0], point[1], point[2] + sheet.group.position.z]);
    document.getElementById("part").scrollIntoView({ block: "start" });
  }

  showRegion() {
    const here = this.region && this.frame === this.frameCount - 1;
    this.view.setLines(this.view.regionLines,
      here ? this.sheets[this.region.sheet].outline(this.region.elements) : new Float32Array(0));
    if (here) this.view.regionLines.position.copy(this.sheets[this.region.sheet].group.position);
  }

  // Sheets of a world moved apart along z by their level.
  explode(share) {
    // from the sheets as they are, not as they are apart already
    for (const sheet of this.sheets) sheet.group.position.z = 0;
    const [low, high] = this.view.box();
    const gap = share * 0.35 * Math.max(high[2] - low[2], 0.25 * (high[0] - low[0]));
    for (const sheet of this.sheets) sheet.group.position.z = gap * sheet.given.level;
    if (this.section?.on) this.section.update();
    this.showRegion();
    this.probe?.show();
    this.view.draw();
  }
};
