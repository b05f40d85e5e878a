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
    bar.style.setProperty("--stops", stops.join(", "));
    const ticks = make("div", { class: "ticks" });
    const count = 5;
    for (let k = 0; k <= count; k += 1) {
      const share = k / count;
      const value = this.logarithmic
        ? 10 ** (Math.log10(this.low) + share * (Math.log10(this.high) - Math.log10(this.low)))
        : this.low + share * (this.high - this.low);
      const tick = make("span", {}, text(value, 3));
      tick.style.setProperty("--at", `${100 * share}%`);
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

// Values that shares of the area stay below, of any number of arrays with the areas of their elements; what is not a
// number is left out. The same as `area_percentile` of the program.
weavesim.percentiles = (arrays, areas, shares) => {
  const total = arrays.reduce((count, values) => count + values.length, 0);
  let [all, weight, count] = [new Float32Array(total), new Float32Array(total), 0];
  arrays.forEach((values, k) => {
    for (let e = 0; e < values.length; e += 1) {
      if (Number.isNaN(values[e])) continue;
      [all[count], weight[count]] = [values[e], areas[k][e]];
      count += 1;
    }
  });
  if (count === 0) return shares.map(() => NaN);
  [all, weight] = [all.subarray(0, count), weight.subarray(0, count)];
  if (weight.every((area) => Math.abs(area - weight[0]) < 1e-4 * weight[0])) {
    all.sort();
    weight.fill(1);
  } else {
    const order = Uint32Array.from(all, (_, k) => k).sort((a, b) => all[a] - all[b]);
    [all, weight] = [all, weight].map((one) => one.slice().map((_, k) => one[order[k]]));
  }
  const middle = new Float64Array(count);
  let sum = 0;
  for (let k = 0; k < count; k += 1) {
    middle[k] = sum + 0.5 * weight[k];
    sum += weight[k];
  }
  return shares.map((share) => {
    const at = share * sum;
    let [low, high] = [0, count - 1];
    if (at <= middle[low]) return all[low];
    if (at >= middle[high]) return all[high];
    while (high - low > 1) {
      const half = (low + high) >> 1;
      if (middle[half] <= at) low = half;
      else high = half;
    }
    return all[low] + ((at - middle[low]) / (middle[high] - middle[low])) * (all[high] - all[low]);
  });
};
