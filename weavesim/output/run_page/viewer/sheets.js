"use strict";
// One sheet of the run: its nodes in every frame, its fields, and what is drawn of it, with its mirrored copies.
weavesim.Sheet = class {
  static async of(given, frameCount) {
    const sheet = new weavesim.Sheet();
    Object.assign(sheet, { given, name: given.name, frameCount, series: new Map(), frame: -1 });
    [sheet.quads, sheet.flat, sheet.yarns] = await Promise.all([
      weavesim.array(given.quads, Uint32Array),
      weavesim.array(given.flat, Float32Array),
      weavesim.array(given.yarns, Float32Array),
    ]);
    sheet.positions = await weavesim.Series.of(given.position, frameCount, 3 * given.nodeCount);
    sheet.nodes = new Float32Array(3 * given.nodeCount);
    // which elements are there: a stage may trim some away
    sheet.kept = given.kept ? await weavesim.Series.of(given.kept, frameCount, given.elementCount) : null;
    sheet.there = sheet.nodesThere = null;
    return sheet;
  }

  has(element) {
    return this.there === null || this.there[element] > 0.5;
  }

  hasNode(node) {
    return this.nodesThere === null || this.nodesThere[node] === 1;
  }

  // What is there in a frame; the sides of the mesh are drawn anew where that has changed.
  trim(frame) {
    if (this.kept === null) return;
    const before = this.there;
    this.there = this.kept.frame(frame);
    if (before !== null && before.every((value, e) => value === this.there[e])) return;
    this.nodesThere = new Uint8Array(this.given.nodeCount);
    for (let i = 0; i < this.quads.length; i += 1) if (this.has(i >> 2)) this.nodesThere[this.quads[i]] = 1;
    this.meshLines.geometry.setIndex(new THREE.BufferAttribute(this.edges(), 1));
  }

  get elementCount() {
    return this.given.elementCount;
  }

  // Flat areas of the elements with their copies [mm²]: percentiles of the page are shares of the flat blank.
  areas() {
    const found = new Float32Array(this.elementCount);
    for (let e = 0; e < found.length; e += 1) {
      const [a, b, c, d] = [0, 1, 2, 3].map((k) => 2 * this.quads[4 * e + k]);
      const [px, py] = [this.flat[c] - this.flat[a], this.flat[c + 1] - this.flat[a + 1]];
      const [qx, qy] = [this.flat[d] - this.flat[b], this.flat[d + 1] - this.flat[b + 1]];
      found[e] = 0.5 * Math.abs(px * qy - py * qx) * this.given.copies.length;
    }
    return found;
  }

  field(name) {
    return this.given.fields.find((field) => field.name === name);
  }

  // The series of a field, unpacked at its first use; null if the sheet has no such field.
  async values(name) {
    const field = this.field(name);
    if (!field) return null;
    if (!this.series.has(name)) {
      const frames = field.at ? field.at.length : this.frameCount;
      this.series.set(name, weavesim.Series.of(field.values, frames, this.elementCount));
    }
    return this.series.get(name);
  }

  // Values of one frame, for colours: sizes of what has a sign that says little. Not a number where there are none.
  shown(series, field, frame) {
    const place = weavesim.placeOf(field, frame);
    if (series === null || place < 0) return new Float32Array(this.elementCount).fill(NaN);
    const values = series.frame(place);
    if (field.absolute) for (let i = 0; i < values.length; i += 1) values[i] = Math.abs(values[i]);
    return values;
  }

  build(clip) {
    const count = this.elementCount;
    const uv = new Float32Array(8 * count);
    const index = new Uint32Array(6 * count);
    for (let e = 0; e < count; e += 1) {
      for (let k = 0; k < 4; k += 1) {
        const node = this.quads[4 * e + k];
        uv[8 * e + 2 * k] = this.flat[2 * node];
        uv[8 * e + 2 * k + 1] = this.flat[2 * node + 1];
      }
      index.set([4 * e, 4 * e + 1, 4 * e + 2, 4 * e, 4 * e + 2, 4 * e + 3], 6 * e);
    }
    this.geometry = new THREE.BufferGeometry();
    const attribute = (name, array, size, normalised = false) =>
      this.geometry.setAttribute(name, new THREE.BufferAttribute(array, size, normalised));
    attribute("position", new Float32Array(12 * count), 3);
    attribute("normal", new Float32Array(12 * count), 3);
    attribute("color", new Uint8Array(12 * count).fill(190), 3, true);
    attribute("uv", uv, 2);
    this.geometry.setIndex(new THREE.BufferAttribute(index, 1));
    this.surface = new THREE.MeshLambertMaterial({
      vertexColors: true, side: THREE.DoubleSide, clippingPlanes: clip,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    this.meshLines = this.lines(this.edges(), 0.55, clip);
    this.meshLines.visible = false;
    this.yarnBars = new weavesim.Yarns(this, clip);
    this.group = new THREE.Group();
    this.copies = this.given.copies.map(([x, y]) => {
      const mesh = new THREE.Mesh(this.geometry, this.surface);
      const copy = new THREE.Group();
      copy.scale.set(x, y, 1);
      copy.add(mesh, ...[this.meshLines, ...this.yarnBars.parts].map((drawn) => {
        const own = new drawn.constructor(drawn.geometry, drawn.material);
        own.userData.of = drawn;
        return own;
      }));
      mesh.userData = { sheet: this, factors: [x, y] };
      this.group.add(copy);
      return copy;
    });
  }

  // Shows or hides lines in every copy.
  sync() {
    for (const copy of this.copies) {
      for (const child of copy.children) if (child.userData.of) child.visible = child.userData.of.visible;
    }
  }

  // Of everything that is drawn of it.
  get materials() {
    return [this.surface, this.meshLines.material, ...this.yarnBars.parts.map((part) => part.material)];
  }

  lines(index, opacity, clip) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(0), 3));
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    const material = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, opacity, clippingPlanes: clip });
    return new THREE.LineSegments(geometry, material);
  }

  // Every side of an element once, as pairs of nodes.
  edges() {
    const seen = new Set();
    const found = [];
    for (let e = 0; e < this.elementCount; e += 1) {
      if (!this.has(e)) continue;
      for (let k = 0; k < 4; k += 1) {
        const a = this.quads[4 * e + k];
        const b = this.quads[4 * e + ((k + 1) % 4)];
        const key = Math.min(a, b) * this.given.nodeCount + Math.max(a, b);
        if (!seen.has(key)) {
          seen.add(key);
          found.push(a, b);
        }
      }
    }
    return new Uint32Array(found);
  }

  // Moves all nodes to those of a frame.
  move(frame) {
    if (frame === this.frame) return;
    this.frame = frame;
    this.nodes = this.positions.frame(frame);
    this.trim(frame);
    const normal = this.normals();
    const position = this.geometry.attributes.position;
    const target = this.geometry.attributes.normal;
    for (let i = 0; i < this.quads.length; i += 1) {
      // an element that is not there is drawn as a point
      const node = 3 * this.quads[this.has(i >> 2) ? i : i & ~3];
      for (let c = 0; c < 3; c += 1) {
        position.array[3 * i + c] = this.nodes[node + c];
        target.array[3 * i + c] = normal[node + c];
      }
    }
    position.needsUpdate = target.needsUpdate = true;
    this.geometry.computeBoundingSphere();
    this.moveLines();
  }

  moveLines() {
    if (this.meshLines.visible) {
      this.meshLines.geometry.setAttribute("position", new THREE.BufferAttribute(this.nodes, 3));
      this.meshLines.geometry.computeBoundingSphere();
      this.colourLines();
    }
    if (this.yarnBars.visible) this.yarnBars.move();
  }

  // Normals of the nodes: the mean of the elements around each.
  normals() {
    const found = new Float32Array(this.nodes.length);
    const x = this.nodes;
    for (let e = 0; e < this.elementCount; e += 1) {
      if (!this.has(e)) continue;
      const [a, b, c, d] = [0, 1, 2, 3].map((k) => 3 * this.quads[4 * e + k]);
      const [px, py, pz] = [x[c] - x[a], x[c + 1] - x[a + 1], x[c + 2] - x[a + 2]];
      const [qx, qy, qz] = [x[d] - x[b], x[d + 1] - x[b + 1], x[d + 2] - x[b + 2]];
      const n = [py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx];
      for (const node of [a, b, c, d]) for (let k = 0; k < 3; k += 1) found[node + k] += n[k];
    }
    for (let i = 0; i < found.length; i += 3) {
      const length = Math.hypot(found[i], found[i + 1], found[i + 2]) || 1;
      for (let k = 0; k < 3; k += 1) found[i + k] /= length;
    }
    return found;
  }

  colour(values, colours) {
    const attribute = this.geometry.attributes.color;
    colours.fill(values, attribute.array, 4);
    attribute.needsUpdate = true;
    this.colourLines();
  }

  // Lines of the mesh are dark where the sheet is bright, and bright where it is dark.
  colourLines() {
    if (!this.meshLines.visible) return;
    const { array } = this.geometry.attributes.color;
    const [sum, count] = [new Float32Array(this.given.nodeCount), new Uint8Array(this.given.nodeCount)];
    for (let i = 0; i < this.quads.length; i += 1) {
      const node = this.quads[i];
      sum[node] += 0.3 * array[3 * i] + 0.59 * array[3 * i + 1] + 0.11 * array[3 * i + 2];
      count[node] += 1;
    }
    const colours = new Uint8Array(3 * sum.length);
    sum.forEach((value, node) => colours.fill(value > 115 * count[node] ? 0 : 255, 3 * node, 3 * node + 3));
    this.meshLines.geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3, true));
  }

  centre(element, source = this.nodes, width = 3) {
    return Array.from({ length: width }, (_, c) =>
      [0, 1, 2, 3].reduce((sum, k) => sum + 0.25 * source[width * this.quads[4 * element + k] + c], 0));
  }

  flatCentre(element) {
    return this.centre(element, this.flat, 2);
  }

  // Sides of a set of elements that only one of them has, as pairs of points.
  outline(elements) {
    const sides = new Map();
    for (const e of elements) {
      for (let k = 0; k < 4; k += 1) {
        const [a, b] = [this.quads[4 * e + k], this.quads[4 * e + ((k + 1) % 4)]];
        const key = `${Math.min(a, b)} ${Math.max(a, b)}`;
        if (sides.has(key)) sides.set(key, null);
        else sides.set(key, [a, b]);
      }
    }
    const found = [];
    for (const side of sides.values()) {
      if (side) for (const node of side) found.push(...this.nodes.slice(3 * node, 3 * node + 3));
    }
    return new Float32Array(found);
  }
};
