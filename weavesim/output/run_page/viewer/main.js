"use strict";
// Opens the page; `weavesim.ready` is kept when everything is drawn.
weavesim.open = async (keep = null) => {
  const data = JSON.parse(document.getElementById("data").textContent);
  weavesim.drawCharts(data);
  const none = document.getElementById("no-view");
  const refuse = (text) => {
    none.hidden = false;
    none.textContent = text;
  };
  if (typeof DecompressionStream === "undefined") {
    document.body.classList.add("no-view");
    return;
  }
  if (!data.scene.sheets.length || !data.scene.frames.index.length) {
    refuse("The run has no frame yet: there is nothing to see.");
    return;
  }
  none.hidden = true;
  const page = await weavesim.Page.of(data);
  const canvas = document.getElementById("picture");
  let view;
  try {
    weavesim.page?.controls.stop();
    weavesim.page?.view.dispose();
    const fresh = canvas.cloneNode(false);
    canvas.replaceWith(fresh);
    view = new weavesim.View(fresh);
  } catch (error) {
    // without WebGL the pictures of the run take the place of the view
    document.body.classList.add("no-view");
    return;
  }
  await page.attach(view);
  page.section = new weavesim.Section(view, document.getElementById("section"));
  page.probe = new weavesim.Probe(page, document.getElementById("probe"));
  page.controls = new weavesim.Controls(page);
  weavesim.page = page;
  if (keep) {
    page.field = page.fields.find((field) => field.name === keep.field) || page.field;
    page.onField();
  }
  await page.setFrame(keep && !keep.atEnd ? keep.frame : page.frameCount - 1);
  view.look("oblique");
  if (keep) {
    view.camera.position.copy(keep.position);
    view.controls.target.copy(keep.target);
    view.camera.zoom = keep.zoom;
    view.camera.updateProjectionMatrix();
    view.controls.update();
    window.scrollTo(0, keep.left);
  }
  weavesim.listen(page, view.canvas);
};

weavesim.listen = (page, canvas) => {
  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => {
    pressed = [event.clientX, event.clientY];
  });
  canvas.addEventListener("pointerup", (event) => {
    if (pressed === null) return;
    // a turn is no click
    const moved = Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]);
    pressed = null;
    if (moved > 4 || event.button !== 0) return;
    const hit = page.view.hit(event.clientX, event.clientY);
    if (hit !== null) page.probe.choose(hit);
  });
};

document.addEventListener("click", (event) => {
  const button = event.target.closest("[data-region], [data-element]");
  if (!button || !weavesim.page) return;
  if (button.dataset.region !== undefined) weavesim.page.chooseRegion(Number(button.dataset.region));
  else weavesim.page.chooseElement(Number(button.dataset.sheet), Number(button.dataset.element));
});

// Paper is narrower than the window: two charts side by side on A4.
const PAPER_WIDTH = 335;

window.addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details")) details.open = true;
  weavesim.page?.view.startPaper();
  for (const box of document.querySelectorAll(".chart")) box.plot?.setSize({ width: PAPER_WIDTH, height: box.plot.height });
});

window.addEventListener("afterprint", () => {
  weavesim.page?.view.endPaper();
  for (const box of document.querySelectorAll(".chart")) box.plot?.setSize({ width: box.clientWidth, height: box.plot.height });
});

weavesim.ready = weavesim.open();
if (weavesim.Live.wanted) weavesim.ready.then(() => new weavesim.Live().start());
