"use strict";
// Yarn directions of a sheet: a short bar along warp and weft of elements that are evenly spread over the flat blank.
// A bar has a core and an edge of the opposite brightness, so that it reads on every colour of a map: lines of one colour
// vanish at one of its ends.
weavesim.YARNS = [
  { yarn: 0, core: 0x000000, edge: 0xffffff },
  { yarn: 1, core: 0xffffff, edge: 0x000000 },
];
// Bars of each kind on the whole part by the size of the picture [pixels]: more would be a texture.
weavesim.barCount = () => {
  const { clientWidth, clientHeight } = document.querySelector(".stage");
  return Math.min(Math.max((clientWidth * clientHeight) / 330, 200), 1600);
};

weavesim.Yarns = class {
  constructor(sheet, clip) {
    this.sheet = sheet;
    this.choose();
    this.parts = weavesim.YARNS.flatMap((kind) => ["edge", "core"].map((part) => this.bars(kind, part, clip)));
  }

  // Every k-th element of a regular mesh along both of its directions; of others the nearest to the middle of each cell.
  choose() {
    const { sheet } = this;
    const areas = sheet.areas();
    const whole = areas.reduce((sum, area) => sum + area, 0);
    const size = Math.sqrt(whole / sheet.given.copies.length / sheet.elementCount);
    const cell = size * Math.max(1, Math.ceil(Math.sqrt(whole / weavesim.barCount()) / size - 0.01));
    const centres = Array.from({ length: sheet.elementCount }, (_, e) => sheet.flatCentre(e));
    const low = [0, 1].map((c) => sheet.flat.reduce((least, x, i) => (i % 2 === c ? Math.min(least, x) : least), Infinity));
    const nearest = new Map();
    centres.forEach((centre, e) => {
      const at = centre.map((x, c) => (x - low[c]) / cell);
      const key = at.map(Math.floor).join(" ");
      const away = Math.hypot(...at.map((x) => x - Math.floor(x) - 0.5));
      if (!nearest.has(key) || away < nearest.get(key).away - 1e-3) nearest.set(key, { e, away });
    });
    this.elements = [...nearest.values()].map(({ e }) => e);
    [this.reach, this.width, this.rim] = [0.36 * cell, 0.045 * cell, 0.045 * cell];
  }

  bars(kind, part, clip) {
    const geometry = new THREE.BufferGeometry();
    const index = Uint32Array.from({ length: 6 * this.elements.length },
      (_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 0, 2, 3][i % 6]);
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(12 * this.elements.length), 3));
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    // the core lies on the edge, and both on the sheet
    const nearer = part === "core" ? -2 : -1;
    const material = new THREE.MeshBasicMaterial({
      color: kind[part], side: THREE.DoubleSide, clippingPlanes: clip,
      polygonOffset: true, polygonOffsetFactor: nearer, polygonOffsetUnits: nearer,
    });
    const mesh = new THREE.Mesh(geometry, material);
    Object.assign(mesh.userData, { yarn: kind.yarn, grow: part === "edge" ? this.rim : 0 });
    mesh.visible = false;
    return mesh;
  }

  set visible(on) {
    for (const part of this.parts) part.visible = on;
  }

  get visible() {
    return this.parts[0].visible;
  }

  move() {
    for (const part of this.parts) {
      const { yarn, grow } = part.userData;
      const target = part.geometry.attributes.position;
      this.elements.forEach((e, place) => target.array.set(this.corners(e, yarn, grow), 12 * place));
      target.needsUpdate = true;
      part.geometry.computeBoundingSphere();
    }
  }

  // Corners of a bar; of an element that is not there all in its middle.
  corners(e, yarn, grow) {
    const { sheet } = this;
    const x = sheet.nodes;
    const [a, b, c, d] = [0, 1, 2, 3].map((k) => 3 * sheet.quads[4 * e + k]);
    const [p, q] = [sheet.yarns[4 * e + 2 * yarn], sheet.yarns[4 * e + 2 * yarn + 1]];
    const [u, v] = [[a, c], [b, d]].map(([from, to]) => [0, 1, 2].map((k) => x[from + k] - x[to + k]));
    const along = u.map((value, k) => p * value + q * v[k]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const across = [
      normal[1] * along[2] - normal[2] * along[1], normal[2] * along[0] - normal[0] * along[2],
      normal[0] * along[1] - normal[1] * along[0],
    ];
    const there = sheet.has(e) ? 1 : 0;
    const long = (there * (this.reach + grow)) / (Math.hypot(...along) || 1);
    const wide = (there * (this.width + grow)) / (Math.hypot(...across) || 1);
    const centre = sheet.centre(e);
    return [[-1, -1], [1, -1], [1, 1], [-1, 1]].flatMap(([s, t]) =>
      centre.map((value, k) => value + s * long * along[k] + t * wide * across[k]));
  }
};
