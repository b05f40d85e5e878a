"use strict";
// Charts over the stroke, and curves of fabrics.
weavesim.LINE_COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#8c6bb1", "#7f7f7f"];

weavesim.chart = (container, given, height = 250) => {
  const box = weavesim.make("div", { class: "chart" });
  container.append(box);
  const heading = weavesim.make("h3", {}, given.title);
  const body = weavesim.make("div", {});
  box.append(heading, body);
  if (given.note) box.append(weavesim.make("p", { class: "note" }, given.note));
  const { columns, series } = weavesim.columnsOf(given);
  const [trusted, end] = [given.trusted, given.measuredTo];
  const options = {
    width: Math.max(box.clientWidth, 200),
    height,
    scales: { x: { time: false }, y: weavesim.ordinate(given, columns) },
    axes: [
      { label: given.xLabel, labelSize: 20, size: 34, font: "11px system-ui", labelFont: "12px system-ui", grid: { stroke: "#e6e8ec", width: 1 }, ticks: { width: 1, size: 4 } },
      {
        label: given.yLabel, labelSize: 20, size: 58, font: "11px system-ui", labelFont: "12px system-ui", grid: { stroke: "#e6e8ec", width: 1 }, ticks: { width: 1, size: 4 },
        values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : weavesim.text(tick, 3))),
        ...(given.logarithmic ? weavesim.DECADES : {}),
      },
    ],
    series: [{ label: given.xLabel, value: (_, x) => weavesim.text(x) }, ...series],
    bands: given.band ? [{ series: [series.length - 1, series.length], fill: "rgb(0 114 178 / 13%)" }] : [],
    legend: { live: true },
    cursor: { drag: { x: true, y: false } },
    hooks: {
      drawClear: [(u) => {
        if (!trusted) return;
        const [a, b] = trusted.map((x) => u.valToPos(x, "x", true));
        u.ctx.fillStyle = "#eceef1";
        u.ctx.fillRect(Math.max(a, u.bbox.left), u.bbox.top, Math.min(b, u.bbox.left + u.bbox.width) - Math.max(a, u.bbox.left), u.bbox.height);
      }],
      draw: [(u) => {
        const mark = box.marked === undefined ? [] : [[box.marked, "#c2185b", []]];
        if (end !== null && end !== undefined) mark.push([end, "#8a919d", [5, 4]]);
        for (const [x, colour, dash] of mark) {
          const at = u.valToPos(x, "x", true);
          if (at < u.bbox.left || at > u.bbox.left + u.bbox.width) continue;
          u.ctx.save();
          u.ctx.strokeStyle = colour;
          u.ctx.setLineDash(dash);
          u.ctx.beginPath();
          u.ctx.moveTo(at, u.bbox.top);
          u.ctx.lineTo(at, u.bbox.top + u.bbox.height);
          u.ctx.stroke();
          u.ctx.restore();
        }
      }],
    },
  };
  box.plot = new uPlot(options, columns, body);
  // the two ends of a band are no curves of their own
  if (given.band) for (const row of [...body.querySelectorAll(".u-legend .u-series")].slice(-2)) row.hidden = true;
  new ResizeObserver(() => {
    const width = Math.max(box.clientWidth, 200);
    if (Math.abs(width - box.plot.width) > 1) box.plot.setSize({ width, height });
  }).observe(box);
  return box;
};

// Lines and numbers of a logarithmic axis: powers of ten alone, all written alike.
weavesim.DECADES = {
  splits: (_, __, low, high) => {
    const [first, last] = [low, high].map((value) => Math.round(Math.log10(value)));
    const step = Math.ceil((last - first) / 6) || 1;
    return Array.from({ length: Math.floor((last - first) / step) + 1 }, (_value, k) => 10 ** (first + k * step));
  },
  filter: (_, ticks) => ticks,
  values: (_, ticks) => {
    const exponents = ticks.map((tick) => Math.round(Math.log10(tick)));
    const plain = exponents.every((exponent) => Math.abs(exponent) <= 3);
    return exponents.map((exponent) => (plain ? weavesim.text(10 ** exponent) : `10${weavesim.raised(exponent)}`));
  },
};

// One abscissa for all lines, which uPlot needs, and how each line is drawn.
weavesim.columnsOf = (given) => {
  const lines = given.lines.map((line) => [line.x || given.x, line.y]);
  if (given.band) lines.push([given.band[0], given.band[2]], [given.band[0], given.band[1]]);
  const tables = lines.map(([x, y]) => {
    const order = x.map((_, k) => k).filter((k) => x[k] !== null).sort((a, b) => x[a] - x[b]);
    // strictly ascending: of equal places the last counts
    const kept = order.filter((k, place) => place + 1 === order.length || x[order[place + 1]] > x[k]);
    return [kept.map((k) => x[k]), kept.map((k) => y[k])];
  });
  const columns = uPlot.join(tables, tables.map(() => [null, 1]));
  const series = given.lines.map((line, k) => ({
    label: line.label,
    stroke: weavesim.LINE_COLOURS[k % weavesim.LINE_COLOURS.length],
    width: 1.6,
    dash: line.dashed || k >= weavesim.LINE_COLOURS.length ? [6, 4] : undefined,
    spanGaps: true,
    points: { show: false },
    value: (_, y) => weavesim.text(y),
  }));
  if (given.band) {
    for (const label of ["high", "low"]) series.push({ label, stroke: "transparent", width: 0, spanGaps: true, points: { show: false } });
  }
  return { columns, series };
};

weavesim.ordinate = (given, columns) => {
  if (given.yRange) return { range: given.yRange };
  if (given.logarithmic) {
    const positive = columns.slice(1).flat().filter((y) => y > 0);
    const most = positive.length ? Math.max(...positive) : 1;
    const least = Math.max(positive.length ? Math.min(...positive) : 0.1, 1e-8 * most);
    return { distr: 3, range: [10 ** Math.floor(Math.log10(least)), 10 ** Math.ceil(Math.log10(most) + 1e-9)] };
  }
  const side = { pad: 0.08, soft: 0, mode: 1 };
  // zero is in the picture, and its edge where nothing is beyond it
  const values = columns.slice(1).flat().filter((y) => y !== null && y !== undefined);
  const away = values.length && (Math.min(...values) > 0.5 * Math.max(...values));
  return away ? {} : { range: { min: side, max: side } };
};

weavesim.drawCharts = (data) => {
  weavesim.boxes = [];
  for (const container of document.querySelectorAll("[data-charts]")) {
    container.replaceChildren();
    for (const name of container.dataset.charts.split(" ")) {
      const chart = data.charts.find((one) => one.name === name);
      if (chart) weavesim.boxes.push(weavesim.chart(container, chart));
    }
  }
  for (const container of document.querySelectorAll("[data-fabric]")) {
    container.replaceChildren();
    for (const chart of data.fabrics[Number(container.dataset.fabric)] || []) weavesim.chart(container, chart, 220);
  }
};

// A line in every chart at the frame that the view shows, and its values below.
weavesim.markCharts = (x) => {
  for (const box of weavesim.boxes || []) {
    box.marked = x;
    box.plot.redraw(false);
    const place = box.plot.data[0].findIndex((value) => Math.abs(value - x) <= 1e-4 * Math.abs(x) + 1e-9);
    box.plot.setLegend({ idx: place < 0 ? null : place });
  }
};
