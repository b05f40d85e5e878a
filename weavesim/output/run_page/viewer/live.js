"use strict";
// A run in progress, shown by `weavesim view --live`: how far it is, and the page anew whenever the run writes it.
// Seconds as "1:05"; "1:02:05" from an hour on.
weavesim.clock = (time) => {
  const whole = Math.round(time);
  const [hours, minutes, seconds] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const two = (count) => String(count).padStart(2, "0");
  return hours > 0 ? `${hours}:${two(minutes)}:${two(seconds)}` : `${minutes}:${two(seconds)}`;
};

weavesim.Live = class {
  constructor() {
    this.bar = document.getElementById("live");
    // of the page that the server has sent, which may be another one by now
    this.seen = document.querySelector('meta[name="weavesim-page"]')?.content ?? null;
  }

  static get wanted() {
    return location.protocol.startsWith("http") && new URLSearchParams(location.search).has("live");
  }

  async start() {
    this.bar.hidden = false;
    for (;;) {
      try {
        await this.look();
      } catch (error) {
        this.bar.textContent = "weavesim view is no longer running; this is what it last showed";
        if (this.lost) return;
        this.lost = true;
      }
      await new Promise((done) => setTimeout(done, 1000));
    }
  }

  async look() {
    const state = await (await fetch("progress", { cache: "no-store" })).json();
    this.lost = false;
    this.say(state);
    if (state.page === null || state.page === this.seen) return;
    await this.renew();
    this.seen = state.page;
  }

  say(state) {
    const { make, withUnit, text } = weavesim;
    const parts = [];
    if (state.share !== undefined) parts.push(make("progress", { max: 1, value: state.share }));
    const words = [state.state];
    if (state.stage) words.push(`stage ${state.stage}`);
    if (state.share !== undefined) words.push(`${Math.round(100 * state.share)} %`);
    if (state.stroke_mm !== undefined) words.push(`stroke ${text(Number(state.stroke_mm.toFixed(1)))}\u202fmm`);
    for (const [tool, force] of Object.entries(state.tool_force_n || {})) words.push(`${tool} ${withUnit(force, "N", 3)}`);
    if (state.state === "running" && state.left_s !== null && state.left_s !== undefined) {
      words.push(`${weavesim.clock(state.left_s)} left`);
    }
    parts.push(words.join(" · "));
    this.bar.replaceChildren(...parts);
  }

  // The new page, in the view that the reader has chosen.
  async renew() {
    const answer = await (await fetch(location.pathname, { cache: "no-store" })).text();
    const fresh = new DOMParser().parseFromString(answer, "text/html");
    const data = fresh.getElementById("data");
    if (!data) return;
    const keep = weavesim.page ? {
      field: weavesim.page.field.name, frame: weavesim.page.frame, atEnd: weavesim.page.frame === weavesim.page.frameCount - 1,
      position: weavesim.page.view.camera.position.clone(), target: weavesim.page.view.controls.target.clone(),
      zoom: weavesim.page.view.camera.zoom, left: window.scrollY,
    } : null;
    document.getElementById("data").textContent = data.textContent;
    document.querySelector("header").replaceWith(fresh.querySelector("header"));
    // the canvas stays: it holds the view
    for (const part of fresh.querySelectorAll("main > section")) {
      const own = document.getElementById(part.id);
      if (part.id !== "part") {
        if (own) own.replaceWith(part);
        else document.getElementById("numbers").before(part);
      }
    }
    await weavesim.open(keep);
  }
};
