"use strict";
// Numbers of the page: see packing.py, which packs them.
const weavesim = {};

weavesim.bytes = async (text) => {
  const letters = atob(text);
  const raw = new Uint8Array(letters.length);
  for (let i = 0; i < raw.length; i += 1) raw[i] = letters.charCodeAt(i);
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

weavesim.array = async (text, Kind) => new Kind((await weavesim.bytes(text)).buffer);

// Values of all frames; `frame(k)` are those of one, in the unit of readers, not a number where there is none.
weavesim.Series = class {
  constructor(low, step, logarithmic, codes, frameCount, width) {
    Object.assign(this, { low, step, logarithmic, codes, frameCount, width });
  }

  static async of(packed, frameCount, width) {
    let codes = null;
    if (packed.data) {
      const bytes = await weavesim.bytes(packed.data);
      const count = bytes.length / 2;
      codes = new Uint16Array(count);
      for (let i = 0; i < count; i += 1) {
        // 0, 1, 2, 3, ... are 0, -1, 1, -2, ...: differences from the frame before, modulo 2^16
        const change = bytes[i] | (bytes[count + i] << 8);
        codes[i] = (change >> 1) ^ -(change & 1);
        if (i >= width) codes[i] += codes[i - width];
      }
    }
    return new weavesim.Series(packed.low, packed.step, packed.logarithmic, codes, frameCount, width);
  }

  value(frame, place) {
    const component = place % this.low.length;
    const code = this.codes === null ? 0 : this.codes[frame * this.width + place];
    if (code === 65535) return NaN;
    const value = this.low[component] + this.step[component] * code;
    return this.logarithmic ? 10 ** value : value;
  }

  frame(frame) {
    const found = new Float32Array(this.width);
    for (let place = 0; place < this.width; place += 1) found[place] = this.value(frame, place);
    return found;
  }
};

// Where a frame is in the series of a field, which some frames may lack; -1 if this one does.
weavesim.placeOf = (field, frame) => (field.at ? field.at.indexOf(frame) : frame);

weavesim.NOTHING = "–";

// An exponent.
weavesim.raised = (exponent) =>
  String(exponent).replace(/[-0-9]/g, (sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]);

weavesim.text = (value, digits = 4) => {
  if (value === null || value === undefined || Number.isNaN(value)) return weavesim.NOTHING;
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) {
    const [mantissa, exponent] = value.toExponential(Math.min(digits - 1, 2)).split("e");
    return `${Number(mantissa)}·10${weavesim.raised(Number(exponent))}`.replace(/^-/, "−");
  }
  return String(Number(value.toPrecision(digits))).replace(/^-/, "−");
};

// What is not there has no unit.
weavesim.withUnit = (value, unit, digits) => {
  const text = weavesim.text(value, digits);
  return text === weavesim.NOTHING ? text : text + (unit === "" || unit === "°" ? unit : `\u202f${unit}`);
};

// Builds an element; children are elements or texts, so that no text is ever taken for HTML.
weavesim.make = (name, attributes = {}, ...children) => {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, "");
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(key, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
};

weavesim.save = (name, content, kind) => {
  const address = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type: kind }));
  const link = weavesim.make("a", { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
};
