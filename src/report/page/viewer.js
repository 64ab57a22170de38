// Draws the pads, one pane per displayed state.
const LENS = Math.tan((9 * Math.PI) / 180);
const VIEWS = { closed: { yaw: 0.33, pitch: 0.3, zoom: 1 }, open: { yaw: 0, pitch: 0.12, zoom: 1 } };

// Colour map of errors: pale to dark red, distinct from that of the fields, with monotonically decreasing luminance.
const ERROR_RAMP = [[0.96, 0.955, 0.94], [0.985, 0.80, 0.50], [0.93, 0.47, 0.23], [0.70, 0.13, 0.20], [0.30, 0.02, 0.16]];
function errorColors() {
  const out = new Uint8Array(3 * 256);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * (ERROR_RAMP.length - 1);
    const k = Math.min(Math.floor(at), ERROR_RAMP.length - 2);
    out.set(mix(ERROR_RAMP[k], ERROR_RAMP[k + 1], at - k).map((c) => Math.round(255 * c)), 3 * i);
  }
  return out;
}
const COLORS = { field: bytesOf(data.colors), error: errorColors() };

class Viewer {
  constructor(canvas) {
    this.canvas = canvas;
    this.view = { ...VIEWS.closed };
    this.start();
    canvas.addEventListener("webglcontextlost", (e) => e.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.start(); this.grasp && this.show(this.grasp); });
  }

  start() {
    const gl = (this.gl = this.canvas.getContext("webgl2", { antialias: true }));
    if (!gl) throw new Error("no WebGL 2");
    this.surface = program(gl, SURFACE);
    this.glass = program(gl, GLASS);
    this.textures = Object.fromEntries(Object.entries(COLORS).map(([name, colors]) => {
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, colors);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
      return [name, texture];
    }));
    this.buffers = [];
  }

  // Creates buffers of vertices (position, normal, value) and of index lists.
  buffer(vertices, ...lists) {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const of = (target, content) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(target, buffer);
      gl.bufferData(target, content, gl.DYNAMIC_DRAW);
      this.buffers.push(buffer);
      return buffer;
    };
    const corners = of(gl.ARRAY_BUFFER, vertices);
    [3, 3, 1].forEach((size, place) => {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 28, 12 * place);
    });
    return { array, corners, lists: lists.map((list) => ({ buffer: of(gl.ELEMENT_ARRAY_BUFFER, list), count: list.length })) };
  }

  show(grasp) {
    this.buffers.splice(0).forEach((buffer) => this.gl.deleteBuffer(buffer));
    this.grasp = grasp;
    this.meshes = grasp.pads.map((pad) => new PadMesh(pad));
    this.stand = new Stand(grasp, this.meshes.map((mesh) => mesh.extent));
    this.pads = this.meshes.map((mesh) => this.buffer(mesh.vertices, mesh.triangles, mesh.edges));
    this.object = this.buffer(withNormals(grasp.object), grasp.object.triangles instanceof Uint32Array ? grasp.object.triangles : Uint32Array.from(grasp.object.triangles));
  }

  // Camera of a pane of this aspect and height (pixels); leaves room for the labels above unfolded pads.
  camera(aspect, open, height) {
    const { yaw, pitch, zoom } = this.view;
    const { radius, openFit, middle } = this.stand;
    const towards = [Math.sin(yaw) * Math.cos(pitch), Math.cos(yaw) * Math.cos(pitch), -Math.sin(pitch)];
    const right = unit(cross([0, 0, -1], towards));
    const up = cross(towards, right);
    const room = Math.max(1.25, 1 / Math.max(0.4, 1 - 108 / height));
    const [w, h] = [radius, 0.95 * radius].map((r, i) => r + ((i ? openFit.h * room : openFit.w * 1.1) - r) * open);
    const far = Math.max(w / aspect, h) / LENS + radius * 0.3 * (1 - open);
    const distance = far / zoom;
    const eye = add(middle, towards, distance);
    const look = [right[0], up[0], towards[0], 0, right[1], up[1], towards[1], 0, right[2], up[2], towards[2], 0, -dot(right, eye), -dot(up, eye), -dot(towards, eye), 1];
    const near = Math.max(distance - 4 * radius, distance * 0.05);
    const light = unit(add(add(scaled(towards, 0.75), up, 0.6), right, -0.35));
    return { matrix: times(perspective(LENS, aspect, near, distance + 6 * radius), look), towards, light };
  }

  // Sets the canvas resolution to the size of its element.
  fit() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight].map((v) => Math.max(1, Math.round(v * ratio)));
    if (this.canvas.width !== w || this.canvas.height !== h) Object.assign(this.canvas, { width: w, height: h });
  }

  // Draws; `options`: frame, shows, quantity, open, gain, object, mesh, ranges. Returns the panes, for their labels.
  draw(options) {
    this.fit();
    const { gl, canvas } = this;
    const { shows } = options;
    const across = canvas.width >= canvas.height * 0.9;
    const [w, h] = across ? [canvas.width / shows.length, canvas.height] : [canvas.width, canvas.height / shows.length];
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.panes = shows.map((show, i) => {
      const [x, y] = across ? [i * w, 0] : [0, i * h];
      gl.viewport(Math.round(x), Math.round(canvas.height - y - h), Math.round(w), Math.round(h));
      const camera = this.camera(w / h, options.open, (canvas.clientHeight * h) / canvas.height);
      const pads = this.drawPane(show, options, camera);
      return { show, camera, pads, x: x / canvas.width, y: y / canvas.height, w: w / canvas.width, h: h / canvas.height };
    });
    return this.panes;
  }

  use({ out, places }, camera, ink) {
    this.gl.useProgram(out);
    this.gl.uniformMatrix4fv(places.camera, false, camera.matrix);
    this.gl.uniform3fv(places.light, camera.light);
    this.gl.uniform3fv(places.towards, camera.towards);
    this.gl.uniform4fv(places.ink, ink);
    return places;
  }

  drawPane(show, options, camera) {
    const { gl, grasp, stand } = this;
    const state = show === "prediction" ? 1 : 0;
    const { frame, open } = options;
    const values = grasp.values(options.quantity, show, frame);
    gl.bindTexture(gl.TEXTURE_2D, this.textures[show === "difference" ? "error" : "field"]);
    const pads = this.pads.map((pad, k) => {
      const [from, to] = [grasp.first[k], grasp.first[k + 1]];
      const own = values.subarray(from, to);
      const displacement = grasp.states[state].displacement.subarray(3 * (frame * grasp.nodes + from), 3 * (frame * grasp.nodes + to));
      const vertices = this.meshes[k].fill(displacement, own, options.ranges[show], options.gain);
      const model = stand.pad(k, state, frame, open);
      gl.bindVertexArray(pad.array);
      gl.bindBuffer(gl.ARRAY_BUFFER, pad.corners);
      gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.DYNAMIC_DRAW);
      const drawList = (list, kind, ink, lift) => {
        const places = this.use(this.surface, camera, ink);
        gl.uniformMatrix4fv(places.model, false, model);
        gl.uniform1f(places.lift, lift);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, list.buffer);
        gl.drawElements(kind, list.count, gl.UNSIGNED_INT, 0);
      };
      drawList(pad.lists[0], gl.TRIANGLES, [0, 0, 0, 0], 0);
      if (options.mesh) drawList(pad.lists[1], gl.LINES, [0.05, 0.06, 0.08, 0.45], 4e-4);
      return { model, vertices: vertices.slice(), values: own };
    });
    if (options.object && open < 0.98) this.drawObject(stand.object(state, frame), camera, 1 - open);
    return pads;
  }

  drawObject(model, camera, strength) {
    const { gl } = this;
    const places = this.use(this.glass, camera, [0.78, 0.72, 0.63, strength]);
    gl.uniformMatrix4fv(places.model, false, model);
    // The depth offset puts the pads in front where they touch the object.
    gl.uniform1f(places.lift, -1.5e-3);
    gl.bindVertexArray(this.object.array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.object.lists[0].buffer);
    gl.depthMask(false);
    gl.enable(gl.CULL_FACE);
    for (const side of [gl.FRONT, gl.BACK]) {
      gl.cullFace(side);
      gl.drawElements(gl.TRIANGLES, this.object.lists[0].count, gl.UNSIGNED_INT, 0);
    }
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
  }

  // Returns the node of a sensing face nearest to a point of the canvas (0 to 1) within a few pixels, with its value
  // and position.
  pick(x, y) {
    const pane = (this.panes || []).find((p) => x >= p.x && x < p.x + p.w && y >= p.y && y < p.y + p.h);
    if (!pane) return null;
    const size = [this.canvas.clientWidth, this.canvas.clientHeight];
    let best = { far: 12 };
    pane.pads.forEach(({ model, vertices, values }, pad) => {
      const all = times(pane.camera.matrix, model);
      for (let i = 0; i < this.meshes[pad].face; i++) {
        const normal = turned([0, 1, 2].flatMap((c) => model.slice(4 * c, 4 * c + 3)), [3, 4, 5].map((k) => vertices[7 * i + k]));
        if (dot(normal, pane.camera.towards) < 0) continue;
        const p = project(all, vertices.subarray(7 * i, 7 * i + 3));
        const at = [pane.x + (pane.w * (p[0] + 1)) / 2, pane.y + (pane.h * (1 - p[1])) / 2];
        const far = Math.hypot((at[0] - x) * size[0], (at[1] - y) * size[1]);
        if (far < best.far) best = { far, pad, show: pane.show, value: values[this.meshes[pad].nodes[i]] };
      }
    });
    return best.show ? best : null;
  }

  turn(dx, dy) {
    this.view.yaw -= dx;
    this.view.pitch = Math.max(-1.5, Math.min(1.5, this.view.pitch + dy));
  }

  zoom(factor) {
    this.view.zoom = Math.max(0.3, Math.min(12, this.view.zoom * factor));
  }
}

// Vertices of the object with area-weighted normals.
function withNormals({ vertices, triangles }) {
  const out = new Float32Array((7 * vertices.length) / 3);
  const corner = (i) => [vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]];
  for (let i = 0; i < vertices.length / 3; i++) out.set(corner(i), 7 * i);
  for (let t = 0; t < triangles.length; t += 3) {
    const own = [triangles[t], triangles[t + 1], triangles[t + 2]];
    const [a, b, c] = own.map(corner);
    const normal = cross(add(b, a, -1), add(c, a, -1));
    for (const i of own) for (let k = 0; k < 3; k++) out[7 * i + 3 + k] += 1e6 * normal[k];
  }
  return out;
}
