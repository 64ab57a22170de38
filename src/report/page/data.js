// Decoded arrays of the page, and recordings of grasps.
const dataOf = (page) => JSON.parse(page.getElementById("data").textContent);
let data = dataOf(document);

const bytesOf = (base64) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

// Decodes a packed array: numbers in SI units, or integers.
function unpack(packed) {
  const raw = bytesOf(packed.base64).buffer;
  const kinds = { i16: Int16Array, u16: Uint16Array, u32: Uint32Array };
  const whole = new kinds[packed.type](raw);
  if (whole.length !== packed.shape.reduce((a, b) => a * b, 1)) throw new Error("the length of an array does not match its shape");
  return packed.type === "i16" ? Float32Array.from(whole, (v) => v * packed.scale) : whole;
}

const meshes = new Map();
function mesh(place) {
  if (!meshes.has(place)) {
    const arrays = Object.entries(data.meshes[place]).map(([name, packed]) => [name, unpack(packed)]);
    meshes.set(place, Object.fromEntries(arrays));
  }
  return meshes.get(place);
}

const QUANTITIES = {
  displacement: { name: "displacement", unit: "mm", scale: 1e3 },
  stress: { name: "von Mises stress", unit: "kPa", scale: 1e-3 },
  contact_force: { name: "contact force of a node", unit: "mN", scale: 1e3 },
};

class Grasp {
  constructor(json) {
    Object.assign(this, { json, pads: json.pads.map(mesh), object: mesh(json.object) });
    // Nodes of all pads are concatenated; those of pad k are first[k] to first[k + 1].
    this.first = this.pads.reduce((first, pad) => [...first, first.at(-1) + pad.rest.length / 3], [0]);
    this.nodes = this.first.at(-1);
    this.frames = json.at.length;
    this.states = json.states.map((state) => ({
      ...state,
      displacement: unpack(state.displacement),
      stress: state.stress && unpack(state.stress),
      contact_force: state.contact_force && this.spread(state.contact_force),
    }));
    this.kept = new Map();
  }

  // Restores nodes that are never in contact, which are not stored, as zeros.
  spread({ nodes, values }) {
    const [places, given, width] = [unpack(nodes), unpack(values), this.nodes];
    const all = new Float32Array(3 * this.frames * width);
    for (let k = 0; k < this.frames; k++)
      places.forEach((node, i) => all.set(given.subarray(3 * (k * places.length + i), 3 * (k * places.length + i) + 3), 3 * (k * width + node)));
    return all;
  }

  has(quantity) {
    return this.states.every((state) => state[quantity]);
  }

  // Values of all nodes, pads concatenated, in the unit of the quantity.
  values(quantity, show, frame) {
    const key = `${quantity} ${show} ${frame}`;
    if (!this.kept.has(key)) this.kept.set(key, this.compute(quantity, show, frame));
    return this.kept.get(key);
  }

  compute(quantity, show, frame) {
    const width = this.nodes;
    const [a, b] = show === "truth" ? [this.states[0]] : show === "prediction" ? [this.states[1]] : [this.states[1], this.states[0]];
    const at = (state, i) => (state ? state[quantity][frame * width * size + i] : 0);
    const size = quantity === "stress" ? 1 : 3;
    const out = new Float32Array(width);
    for (let n = 0; n < width; n++) {
      let sum = 0;
      for (let c = 0; c < size; c++) sum += (at(a, size * n + c) - at(b, size * n + c)) ** 2;
      out[n] = Math.sqrt(sum) * QUANTITIES[quantity].scale;
    }
    return out;
  }

  // Largest value of one frame or of all; truth and prediction have a common one.
  largest(quantity, show, frame) {
    const shows = show === "difference" || this.states.length < 2 ? [show] : ["truth", "prediction"];
    const frames = frame === undefined ? [...Array(this.frames).keys()] : [frame];
    const key = `${quantity} ${shows} ${frame} largest`;
    if (!this.kept.has(key)) {
      let most = 0;
      for (const s of shows) for (const k of frames) for (const v of this.values(quantity, s, k)) if (v > most) most = v;
      this.kept.set(key, most);
    }
    return this.kept.get(key);
  }
}
