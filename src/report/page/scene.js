// Poses of the pads and their vertices, in mm.
const MM = 1e3;

// Vertices of a pad: smooth normals on the sensing face, flat sides, and a sharp edge between them.
class PadMesh {
  constructor({ rest, sensing, outside }) {
    this.rest = rest;
    const numbered = (triangles) => {
      const nodes = [...new Set(triangles)];
      const places = new Map(nodes.map((node, i) => [node, i]));
      return [nodes, Array.from(triangles, (node) => places.get(node))];
    };
    const [face, front] = numbered(sensing);
    const [side, back] = numbered(outside);
    this.front = front;
    this.face = face.length;
    this.nodes = Uint32Array.from([...face, ...side]);
    this.triangles = Uint32Array.from([...front, ...back.map((i) => i + face.length)]);
    const edges = new Map();
    for (let t = 0; t < front.length; t += 3)
      for (const [a, b] of [[0, 1], [1, 2], [2, 0]].map(([a, b]) => [front[t + a], front[t + b]]))
        edges.set(Math.min(a, b) * face.length + Math.max(a, b), [a, b]);
    this.edges = Uint32Array.from([...edges.values()].flat());
    this.vertices = new Float32Array(7 * this.nodes.length);
    const range = (axis) => {
      const all = face.map((node) => rest[3 * node + axis] * MM);
      return [Math.min(...all), Math.max(...all)];
    };
    this.extent = [range(0), range(1)];
  }

  // Fills position, normal and value (relative to the colour scale) of every vertex; displacement in m.
  fill(displacement, values, range, gain) {
    const out = this.vertices;
    this.nodes.forEach((node, i) => {
      for (let c = 0; c < 3; c++) {
        out[7 * i + c] = (this.rest[3 * node + c] + gain * displacement[3 * node + c]) * MM;
        out[7 * i + 3 + c] = 0;
      }
      out[7 * i + 6] = range > 0 ? values[node] / range : 0;
    });
    const corner = (i) => [out[7 * i], out[7 * i + 1], out[7 * i + 2]];
    for (let t = 0; t < this.front.length; t += 3) {
      const own = this.front.slice(t, t + 3);
      const [a, b, c] = own.map(corner);
      const normal = cross(add(b, a, -1), add(c, a, -1));
      for (const i of own) for (let k = 0; k < 3; k++) out[7 * i + 3 + k] += normal[k];
    }
    for (let i = 0; i < this.face; i++) {
      const n = unit([out[7 * i + 3], out[7 * i + 4], out[7 * i + 5]]);
      for (let k = 0; k < 3; k++) out[7 * i + 3 + k] = n[k];
    }
    return out;
  }
}

// Poses of the pads: closed around the object (open = 0), or unfolded like a book with the faces towards the viewer
// (open = 1).
class Stand {
  constructor(grasp, extents) {
    Object.assign(this, { grasp, extents });
    const last = grasp.states[0].origins[grasp.frames - 1].map((o) => scaled(o, MM));
    this.middle = scaled(last.reduce((a, b) => add(a, b)), 1 / last.length);
    // Unfolding is the smallest rotation that turns the face towards the viewer, whose view direction is -y.
    this.hinges = grasp.json.rotations.map((r) => {
      const normal = r.slice(6, 9);
      const axis = cross(normal, [0, 1, 0]);
      const angle = Math.acos(Math.max(-1, Math.min(1, normal[1])));
      return { axis: Math.hypot(...axis) > 1e-6 ? unit(axis) : [0, 0, 1], angle };
    });
    const sizes = this.spans();
    const gap = 5;
    const whole = sizes.reduce((sum, s) => sum + s.width, 0) + gap * (sizes.length - 1);
    let left = -whole / 2;
    const order = last.map((o, k) => [o[0], k]).sort((a, b) => a[0] - b[0]);
    this.slots = [];
    for (const [, k] of order) {
      this.slots[k] = add(this.middle, [left + sizes[k].width / 2 - sizes[k].center[0], 0, -sizes[k].center[1]]);
      left += sizes[k].width + gap;
    }
    this.openFit = { w: whole / 2, h: Math.max(...sizes.map((s) => s.height)) / 2 };
    const pads = Math.max(...last.map((o, k) => Math.hypot(...add(o, this.middle, -1)) + Math.hypot(sizes[k].width, sizes[k].height) / 2));
    let around = 0;
    const vertices = grasp.object.vertices;
    const object = this.object(0, grasp.frames - 1);
    for (let i = 0; i < vertices.length; i += 3) {
      const at = [0, 1, 2].map((c) => object[c] * vertices[i] + object[4 + c] * vertices[i + 1] + object[8 + c] * vertices[i + 2] + object[12 + c]);
      around = Math.max(around, Math.hypot(...add(at, this.middle, -1)));
    }
    // A large object may be cropped, but not the pads.
    this.radius = Math.max(pads, Math.min(around, 1.6 * pads));
  }

  // Width and height of each unfolded pad in the view, and its centre relative to the pad origin.
  spans() {
    return this.grasp.json.rotations.map((r, k) => {
      const rotation = this.rotation(k, 1);
      const corners = this.extents[k][0].flatMap((x) => this.extents[k][1].map((y) => turned(rotation, [x, y, 0])));
      const range = (axis) => [Math.min(...corners.map((c) => c[axis])), Math.max(...corners.map((c) => c[axis]))];
      const [[l, h], [b, t]] = [range(0), range(2)];
      return { width: h - l, height: t - b, center: [(l + h) / 2, (b + t) / 2] };
    });
  }

  rotation(k, open) {
    const { axis, angle } = this.hinges[k];
    return chained(about(axis, open * angle), this.grasp.json.rotations[k]);
  }

  pad(k, state, frame, open) {
    const origin = scaled(this.grasp.states[state].origins[frame][k], MM);
    return placed(this.rotation(k, open), mix(origin, this.slots[k], open));
  }

  object(state, frame) {
    const pose = this.grasp.states[state].object[frame];
    return placed(ofQuaternion(pose.slice(3)).map((v) => v * MM), scaled(pose.slice(0, 3), MM));
  }
}
