"use strict";
// The picture in three dimensions: camera, light, tools, the plane that cuts.
// Of all tools until the reader moves the slider: the part is seen through those above it.
weavesim.TOOL_OPACITY = 0.25;

// Where it stands on A4 [pixels of the page]: the width between the margins, the height of the style sheet.
const ON_PAPER = [703, 397];

weavesim.View = class {
  constructor(canvas) {
    THREE.ColorManagement.enabled = false;
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.localClippingEnabled = true;
    this.renderer.setClearColor(0xffffff);
    this.scene = new THREE.Scene();
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -1e4, 1e4);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    // the light of a lambertian surface is over pi
    this.scene.add(new THREE.AmbientLight(0xffffff, 0.66 * Math.PI));
    const light = new THREE.DirectionalLight(0xffffff, 0.42 * Math.PI);
    this.lamp = light;
    this.scene.add(light, light.target);
    this.plane = new THREE.Plane(new THREE.Vector3(0, 1, 0), 0);
    this.clip = [];
    this.cutLines = this.marks(0x000000);
    this.regionLines = this.marks(0xc2185b);
    this.pin = new THREE.Mesh(
      new THREE.SphereGeometry(1, 20, 12),
      new THREE.MeshBasicMaterial({ color: 0xc2185b, depthTest: false, transparent: true }),
    );
    this.pin.renderOrder = 10;
    this.pin.visible = false;
    this.scene.add(this.pin);
    this.sheets = [];
    this.tools = [];
    this.asked = false;
    this.paper = null;
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(canvas.parentElement);
  }

  // Lets go of the canvas and of what is drawn: a page in progress makes a new view whenever it is renewed.
  dispose() {
    this.observer.disconnect();
    this.paper?.remove();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  marks(colour) {
    const lines = new THREE.LineSegments(
      new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: colour, depthTest: false, transparent: true }));
    lines.renderOrder = 9;
    lines.visible = false;
    this.scene.add(lines);
    return lines;
  }

  setLines(lines, points) {
    lines.geometry.dispose();
    lines.geometry = new THREE.BufferGeometry();
    lines.geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    lines.visible = points.length > 0;
  }

  add(sheet) {
    sheet.build(this.clip);
    this.sheets.push(sheet);
    this.scene.add(sheet.group);
  }

  async addTool(given) {
    const geometry = new THREE.BufferGeometry();
    const vertices = await weavesim.array(given.vertices, Float32Array);
    const faces = await weavesim.array(given.faces, Uint32Array);
    geometry.setAttribute("position", new THREE.BufferAttribute(vertices, 3));
    geometry.setIndex(new THREE.BufferAttribute(faces, 1));
    // edges stay sharp: triangles with normals of their own
    const flat = geometry.toNonIndexed();
    flat.computeVertexNormals();
    const [red, green, blue] = given.colour;
    const material = new THREE.MeshLambertMaterial({
      color: new THREE.Color(red, green, blue), side: THREE.DoubleSide, clippingPlanes: this.clip,
      transparent: true,
    });
    const mesh = new THREE.Mesh(flat, material);
    const tool = { given, mesh, vertices, faces, name: given.name, displacement: 0, wanted: false, acts: true };
    mesh.visible = false;
    this.setOpacity(tool, weavesim.TOOL_OPACITY);
    this.scene.add(mesh);
    this.tools.push(tool);
  }

  setOpacity(tool, opacity) {
    tool.mesh.material.opacity = opacity;
    tool.mesh.material.depthWrite = opacity === 1;
    tool.mesh.renderOrder = opacity < 1 ? 5 : 0;
  }

  // Shows or hides a tool; one that does not act in this frame is not there.
  showTool(tool, wanted) {
    tool.wanted = wanted;
    tool.mesh.visible = wanted && tool.acts;
  }

  moveTools(frame) {
    for (const tool of this.tools) {
      tool.acts = !tool.given.acts || tool.given.acts[frame];
      this.showTool(tool, tool.wanted);
      const pose = tool.given.pose[frame];
      if (pose) {
        const [a, b, c, d, e, f, g, h, i, x, y, z] = pose;
        tool.mesh.matrixAutoUpdate = false;
        tool.mesh.matrix.set(a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1);
        tool.mesh.matrixWorldNeedsUpdate = true;
        continue;
      }
      tool.displacement = tool.given.displacement[frame] || 0;
      tool.mesh.position.set(...tool.given.axis.map((x) => x * tool.displacement));
      tool.mesh.updateMatrix();
    }
  }

  // Calls `use` with every node of all sheets that are shown, with their copies.
  eachNode(use) {
    for (const sheet of this.sheets) {
      if (!sheet.group.visible) continue;
      sheet.given.copies.forEach(([x, y], place) => {
        if (!sheet.copies[place].visible) return;
        for (let i = 0; i < sheet.nodes.length; i += 3) {
          if (!sheet.hasNode(i / 3)) continue;
          use([x * sheet.nodes[i], y * sheet.nodes[i + 1], sheet.nodes[i + 2] + sheet.group.position.z]);
        }
      });
    }
  }

  // Smallest and largest corner of them.
  box() {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    this.eachNode((point) => {
      for (let c = 0; c < 3; c += 1) {
        low[c] = Math.min(low[c], point[c]);
        high[c] = Math.max(high[c], point[c]);
      }
    });
    return Number.isFinite(low[0]) ? [low, high] : [[-1, -1, -1], [1, 1, 1]];
  }

  look(name) {
    const from = { oblique: [-1, -1.7, 1.25], below: [-1, -1.7, -1.25], top: [0, -0.001, 1], front: [0, -1, 0], side: [1, 0, 0] };
    const [low, high] = this.box();
    const middle = new THREE.Vector3(...low.map((x, c) => 0.5 * (x + high[c])));
    this.size = Math.hypot(...low.map((x, c) => high[c] - x));
    const way = new THREE.Vector3(...from[name]).normalize().multiplyScalar(2 * this.size);
    this.camera.position.copy(middle).add(way);
    this.camera.near = -10 * this.size;
    this.camera.far = 10 * this.size;
    this.camera.zoom = 1;
    this.camera.lookAt(middle);
    this.camera.updateMatrixWorld();
    // what is seen, in the axes of the camera, comes into the middle and fills the picture
    const seen = { low: [Infinity, Infinity], high: [-Infinity, -Infinity] };
    this.eachNode((point) => {
      const there = new THREE.Vector3(...point).applyMatrix4(this.camera.matrixWorldInverse);
      [there.x, there.y].forEach((x, c) => {
        seen.low[c] = Math.min(seen.low[c], x);
        seen.high[c] = Math.max(seen.high[c], x);
      });
    });
    const axes = [new THREE.Vector3(), new THREE.Vector3()];
    this.camera.matrixWorld.extractBasis(...axes, new THREE.Vector3());
    const shift = axes[0].multiplyScalar(0.5 * (seen.low[0] + seen.high[0]))
      .add(axes[1].multiplyScalar(0.5 * (seen.low[1] + seen.high[1])));
    this.controls.target.copy(middle).add(shift);
    this.camera.position.add(shift);
    this.reach = [0, 1].map((c) => 0.53 * (seen.high[c] - seen.low[c]) || 1);
    this.resize();
    this.controls.update();
    this.draw();
  }

  // Turns to a point of the part, near enough to see its surroundings.
  approach(point) {
    const way = this.camera.position.clone().sub(this.controls.target);
    this.controls.target.set(...point);
    this.camera.position.set(...point).add(way);
    this.camera.zoom = Math.max(this.camera.zoom, 2.5);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  setPin(point) {
    this.pin.visible = point !== null;
    if (point !== null) this.pin.position.set(...point);
    this.draw();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const [width, height] = this.paper === null ? [clientWidth, clientHeight] : ON_PAPER;
    if (width === 0 || height === 0 || !this.reach) return;
    this.renderer.setPixelRatio(this.paper === null ? Math.min(window.devicePixelRatio, 2) : 2);
    this.renderer.setSize(width, height, false);
    const [across, up] = this.reach;
    const half = Math.max(up, (across * height) / width);
    [this.camera.top, this.camera.bottom] = [half, -half];
    [this.camera.right, this.camera.left] = [(half * width) / height, (-half * width) / height];
    this.camera.updateProjectionMatrix();
    // at once: another size has emptied the picture, and paper waits for no refresh of the screen
    this.drawNow();
  }

  // Draws before the next refresh of the screen, however often it is asked.
  draw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => this.drawNow());
  }

  drawNow() {
    this.asked = false;
    const way = this.camera.position.clone().sub(this.controls.target).normalize();
    const side = new THREE.Vector3(0, 0, 1).cross(way).normalize();
    this.lamp.position.copy(way.add(side.multiplyScalar(0.35)).add(new THREE.Vector3(0, 0, 0.3)));
    const pixel = (this.camera.top - this.camera.bottom) / (this.camera.zoom * (this.canvas.clientHeight || 1));
    this.pin.scale.setScalar(5 * pixel);
    this.renderer.render(this.scene, this.camera);
    if (this.paper !== null) this.copyTo(this.paper);
  }

  // Paper takes what the screen showed last, which may be the picture before: it gets a copy that waits for nothing.
  startPaper() {
    this.paper?.remove();
    this.paper = document.createElement("canvas");
    this.paper.className = "paper";
    this.canvas.after(this.paper);
    this.resize();
  }

  endPaper() {
    if (this.paper === null) return;
    this.paper.remove();
    this.paper = null;
    this.resize();
  }

  copyTo(paper) {
    [paper.width, paper.height] = [this.canvas.width, this.canvas.height];
    paper.getContext("2d").drawImage(this.canvas, 0, 0);
  }

  // The plane of the cut: all materials share one list of planes.
  setCut(normal, offset) {
    this.clip.length = 0;
    if (normal !== null) {
      this.plane.normal.set(...normal);
      this.plane.constant = -offset;
      this.clip.push(this.plane);
    }
    for (const material of [...this.sheets.flatMap((sheet) => sheet.materials), ...this.tools.map((tool) => tool.mesh.material)]) {
      material.clippingPlanes = normal === null ? null : this.clip;
      material.needsUpdate = true;
    }
    this.draw();
  }

  // What is under a place of the screen: sheet, element, point, point on the flat blank; null for nothing.
  hit(clientX, clientY) {
    const area = this.canvas.getBoundingClientRect();
    const place = new THREE.Vector2(
      (2 * (clientX - area.left)) / area.width - 1, 1 - (2 * (clientY - area.top)) / area.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(place, this.camera);
    const meshes = this.sheets.filter((sheet) => sheet.group.visible)
      .flatMap((sheet) => sheet.copies.filter((copy) => copy.visible).map((copy) => copy.children[0]));
    for (const found of ray.intersectObjects(meshes, false)) {
      if (this.clip.some((plane) => plane.distanceToPoint(found.point) < 0)) continue;
      const { sheet, factors } = found.object.userData;
      return {
        sheet, element: Math.floor(found.faceIndex / 2), point: found.point.toArray(),
        flat: [found.uv.x, found.uv.y], factors,
      };
    }
    return null;
  }
};
