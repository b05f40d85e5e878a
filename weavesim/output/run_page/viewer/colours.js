"use strict";
// Colours of values. Tables come with the page; all of them read without telling red from green.
weavesim.Colours = class {
  constructor(tables) {
    this.tables = {};
    for (const [name, text] of Object.entries(tables)) {
      this.tables[name] = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    }
    this.name = Object.keys(tables)[0];
    this.low = 0;
    this.high = 1;
    this.logarithmic = false;
  }

  get table() {
    return this.tables[this.name];
  }

  // Place in the table, 0 to 255; -1 for what is not a number.
  place(value) {
    if (Number.isNaN(value)) return -1;
    let [low, high, at] = [this.low, this.high, value];
    if (this.logarithmic) [low, high, at] = [Math.log10(low), Math.log10(high), Math.log10(Math.max(value, 1e-300))];
    if (!(high > low)) return 128;
    return Math.round(255 * Math.min(Math.max((at - low) / (high - low), 0), 1));
  }

  // Writes red, green and blue of each value `repeat` times.
  fill(values, target, repeat) {
    const table = this.table;
    for (let i = 0, to = 0; i < values.length; i += 1) {
      const place = this.place(values[i]);
      for (let k = 0; k < repeat; k += 1, to += 3) {
        for (let c = 0; c < 3; c += 1) target[to + c] = place < 0 ? 190 : table[3 * place + c];
      }
    }
  }

  css(place) {
    const table = this.table;
    return `rgb(${table[3 * place]} ${table[3 * place + 1]} ${table[3 * place + 2]})`;
  }

  legend(container, field, note) {
    const { make, text } = weavesim;
    const stops = Array.from({ length: 17 }, (_, k) => this.css(Math.round((255 * k) / 16)));
    const bar = make("div", { class: "bar" });
    bar.style.background = `linear-gradient(to top, ${stops.join(", ")})`;
    const ticks = make("div", { class: "ticks" });
    const count = 5;
    for (let k = 0; k <= count; k += 1) {
      const share = k / count;
      const value = this.logarithmic
        ? 10 ** (Math.log10(this.low) + share * (Math.log10(this.high) - Math.log10(this.low)))
        : this.low + share * (this.high - this.low);
      const tick = make("span", {}, text(value, 3));
      tick.style.bottom = `${100 * share}%`;
      tick.style.top = "auto";
      tick.style.transform = "translateY(50%)";
      ticks.append(tick);
    }
    const unit = field.unit ? ` [${field.unit}]` : "";
    const size = field.absolute ? ", size" : "";
    container.replaceChildren(
      make("b", {}, `${field.label}${size}${unit}`),
      make("div", {}, note),
      make("div", { class: "scale" }, bar, ticks),
    );
  }
};

// Values at shares of an ascending order, of any number of arrays; what is not a number is left out.
weavesim.percentiles = (arrays, shares) => {
  const all = new Float32Array(arrays.reduce((count, values) => count + values.length, 0));
  let count = 0;
  for (const values of arrays) for (const value of values) if (!Number.isNaN(value)) all[count++] = value;
  if (count === 0) return shares.map(() => NaN);
  const sorted = all.subarray(0, count).sort();
  return shares.map((share) => {
    const place = share * (count - 1);
    const below = Math.floor(place);
    const above = Math.min(below + 1, count - 1);
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
  });
};
