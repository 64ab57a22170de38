// Controls of the viewer, and labels around the picture.
const byId = (id) => document.getElementById(id);
const chosen = (name) => document.querySelector(`input[name="${name}"]:checked`).value;
const errors = [];
window.addEventListener("error", (event) => { errors.push(event.message); document.body.dataset.errors = errors.join("; "); });

const SHOWS = { truth: ["truth"], prediction: ["prediction"], difference: ["difference"], all: ["truth", "prediction", "difference"] };

class Controls {
  constructor() {
    this.viewer = new Viewer(byId("canvas"));
    this.opened = new Map();
    this.list();
    const on = (id, kind, act) => byId(id).addEventListener(kind, act);
    on("grasp", "change", () => { byId("newest").checked = false; this.choose(+byId("grasp").value); });
    on("newest", "change", () => byId("newest").checked && this.refresh());
    byId("newest").parentElement.hidden = data.state === null;
    for (const id of ["show", "quantity", "object", "mesh", "own"]) on(id, "change", () => this.draw());
    for (const id of ["frame", "gain"]) on(id, "input", () => this.draw());
    on("open", "input", () => { this.follow(+byId("open").value); this.draw(); });
    on("layout", "change", () => this.glide(+chosen("layout")));
    on("play", "click", () => this.play());
    this.pointers();
    const typical = data.grasps.findIndex((g) => g.about.startsWith("median"));
    byId("grasp").value = Math.max(0, typical);
    this.choose(+byId("grasp").value);
    atWidth(byId("canvas"), () => this.draw());
  }

  list() {
    byId("grasp").replaceChildren(...data.grasps.map((g, i) => new Option(g.about ? `${g.name} (${g.about})` : g.name, i)));
  }

  // Replaces the data but keeps the current view: a selected grasp that is missing in the new data stays in the list.
  refresh() {
    const { grasp } = this;
    const frame = +byId("frame").value;
    this.opened.clear();
    const newest = byId("newest").checked;
    let place = newest ? data.grasps.length - 1 : data.grasps.findIndex((g) => g.name === grasp.json.name);
    if (place < 0) {
      place = data.grasps.push(grasp.json) - 1;
      this.opened.set(place, grasp);
    }
    this.list();
    byId("grasp").value = place;
    this.choose(place);
    if (newest || frame > +byId("frame").max) return;
    byId("frame").value = frame;
    this.draw();
  }

  choose(i) {
    if (!this.opened.has(i)) this.opened.set(i, new Grasp(data.grasps[i]));
    const grasp = (this.grasp = this.opened.get(i));
    this.viewer.show(grasp);
    const alone = grasp.states.length < 2;
    document.querySelectorAll('input[name="show"]').forEach((input) => {
      input.disabled = alone && input.value !== "truth";
      if (alone) input.checked = input.value === "truth";
    });
    document.querySelectorAll('input[name="quantity"]').forEach((input) => { input.disabled = !grasp.has(input.value); });
    if (!grasp.has(chosen("quantity"))) document.querySelector('input[name="quantity"]').checked = true;
    Object.assign(byId("frame"), { max: grasp.frames - 1, value: grasp.frames - 1 });
    byId("play").disabled = byId("frame").disabled = grasp.frames < 2;
    this.draw();
  }

  get options() {
    const { grasp } = this;
    const [frame, quantity, shows] = [+byId("frame").value, chosen("quantity"), SHOWS[chosen("show")]];
    const ranges = Object.fromEntries(shows.map((s) => [s, grasp.largest(quantity, s, byId("own").checked ? frame : undefined)]));
    return { frame, quantity, shows, ranges, open: +byId("open").value, gain: +byId("gain").value, object: byId("object").checked, mesh: byId("mesh").checked };
  }

  draw() {
    const options = this.options;
    // On narrow screens several states are stacked and need the space.
    byId("stage").classList.toggle("many", options.shows.length > 1);
    const panes = this.viewer.draw(options);
    this.write(options, panes);
  }

  who(show) {
    const [truth, other] = this.grasp.states;
    return { truth: truth.label, prediction: other?.label, difference: "difference" }[show];
  }

  write(options, panes) {
    const { grasp } = this;
    const { name, unit: units } = QUANTITIES[options.quantity];
    const { axis, at, force } = grasp.json;
    byId("at").textContent = axis.unit === "N" ? `${at[options.frame].toFixed(2)} N` : `${at[options.frame].toFixed(3)} s, ${force[options.frame].toFixed(2)} N`;
    byId("frame").setAttribute("aria-valuetext", byId("at").textContent);
    byId("gain-at").textContent = options.gain;
    const labels = panes.flatMap((pane) => {
      const title = { text: this.who(pane.show), x: pane.x, y: pane.y, pane: true };
      if (pane.pads.length < 2) return [title];
      const names = pane.pads.map(({ model, vertices }, k) => {
        const all = times(pane.camera.matrix, model);
        const points = Array.from(this.viewer.meshes[k].nodes, (_, i) => project(all, vertices.subarray(7 * i, 7 * i + 3)));
        const x = points.reduce((sum, p) => sum + p[0], 0) / points.length;
        const top = points.reduce((most, p) => Math.max(most, p[1]), -Infinity);
        return { text: ["left", "right"][k] || `pad ${k}`, x: pane.x + (pane.w * (x + 1)) / 2, y: pane.y + (pane.h * (1 - top)) / 2 };
      });
      return [title, ...names];
    });
    byId("labels").replaceChildren(...labels.map(({ text, x, y, pane }) => {
      const span = document.createElement("span");
      span.textContent = text;
      span.style.left = pane ? `calc(${100 * x}% + 16px)` : `${100 * x}%`;
      span.style.top = pane ? `calc(${100 * y}% + 10px)` : `calc(${100 * y}% - 4px)`;
      if (pane) span.className = "pane";
      return span;
    }));
    this.legend(options, name, units);
    this.facts(options);
  }

  // One colour scale for the fields, one for their difference.
  legend({ shows, ranges }, name, units) {
    const stops = (colors) => [...Array(17).keys()].map((i) => `rgb(${[...colors.slice(45 * i, 45 * i + 3)]})`).join(",");
    const scale = (show) => {
      const [legend, title, ramp, row] = [0, 0, 0, 0].map(() => document.createElement("div"));
      [legend.className, ramp.className, row.className] = ["legend", "ramp", "ticks"];
      title.textContent = show !== "difference" ? `${name}, ${units}` : shows.length > 1 ? `difference, ${units}` : `difference of the ${name}, ${units}`;
      ramp.style.background = `linear-gradient(90deg, ${stops(COLORS[show === "difference" ? "error" : "field"])})`;
      const most = ranges[show];
      const marks = ticks(most, 4).filter((v) => v < most);
      row.append(...[...marks, most].map((v, i) => {
        const mark = document.createElement("span");
        mark.textContent = short(v);
        mark.style.left = `${most > 0 ? (100 * v) / most : 100 * i}%`;
        if (i === marks.length) mark.className = "end";
        return mark;
      }));
      legend.append(title, ramp, row);
      return legend;
    };
    byId("legends").replaceChildren(...(shows.length > 1 ? ["truth", "difference"] : shows).map(scale));
    // The last number is aligned with the end; numbers that would overlap it are removed.
    document.querySelectorAll("#legends .ticks").forEach((row) => {
      const marks = [...row.children];
      const end = marks.pop().getBoundingClientRect();
      marks.filter((mark) => mark.getBoundingClientRect().right > end.left - 10).forEach((mark) => mark.remove());
    });
    byId("hint").hidden = shows.length > 1;
  }

  facts({ frame, quantity, shows, ranges }) {
    const { grasp } = this;
    const { unit: units, name } = QUANTITIES[quantity];
    const percent = (list) => (list && list[frame] !== null ? `${(100 * list[frame]).toFixed(1)} %` : "-");
    const rows = [["force, sum over the fingers", `${grasp.json.force[frame].toFixed(2)} N`]];
    grasp.states.forEach((state, k) => {
      rows.push([`travel, ${state.label}`, `${state.travel[frame].map((t) => (t * MM).toFixed(3)).join(" / ")} mm`]);
      rows.push([`largest ${name}, ${state.label}`, `${short(Math.max(...grasp.values(quantity, k ? "prediction" : "truth", frame)))} ${units}`]);
    });
    const wrong = grasp.json.errors;
    if (wrong) {
      rows.push([`largest error of the ${name}`, `${short(Math.max(...grasp.values(quantity, "difference", frame)))} ${units}`]);
      for (const key of Object.keys(QUANTITIES)) rows.push([`error of the ${key.replace("_", " ")}`, percent(wrong[key])]);
    }
    byId("facts").replaceChildren(...rows.flatMap((row) => row.map((text, i) => {
      const cell = document.createElement(i ? "dd" : "dt");
      cell.textContent = text;
      return cell;
    })));
    this.course(frame, wrong);
  }

  // Chart over force or time: errors of the prediction if given, otherwise the largest values.
  course(frame, wrong) {
    const { grasp } = this;
    const label = `${grasp.json.axis.name}, ${grasp.json.axis.unit}`;
    const axis = { label, at: grasp.json.at };
    const go = (k) => { byId("frame").value = k; this.draw(); };
    if (wrong) {
      const series = Object.keys(QUANTITIES).map((key) => ({ name: key.replace("_", " "), values: wrong[key].map((v) => v === null ? null : 100 * v) }));
      head(byId("course"), "Error of this grasp", series.map((s) => s.name));
      return drawLines(byId("course"), axis, series, "%", frame, go);
    }
    const quantity = chosen("quantity");
    const { name, unit: units } = QUANTITIES[quantity];
    const values = axis.at.map((_, k) => grasp.largest(quantity, "truth", k));
    head(byId("course"), `Largest ${name}`, []);
    drawLines(byId("course"), axis, [{ name, values }], units, frame, go);
  }

  // Animates the pads between closed and unfolded, together with the view.
  glide(to) {
    const [from, start] = [+byId("open").value, performance.now()];
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const first = { ...this.viewer.view };
    const last = to ? VIEWS.open : VIEWS.closed;
    const step = (now) => {
      const t = still ? 1 : Math.min(1, Math.max(0, (now - start) / 450));
      const s = t * t * (3 - 2 * t);
      byId("open").value = from + (to - from) * s;
      for (const key of Object.keys(last)) this.viewer.view[key] = first[key] + (last[key] - first[key]) * s;
      this.draw();
      if (t < 1) requestAnimationFrame(step);
    };
    step(still ? start : performance.now());
  }

  follow(open) {
    for (const input of document.querySelectorAll('input[name="layout"]')) input.checked = Math.abs(+input.value - open) < 0.02;
  }

  play() {
    const running = this.timer !== undefined;
    if (running) {
      clearInterval(this.timer);
      this.timer = undefined;
    } else {
      const slider = byId("frame");
      if (+slider.value >= +slider.max) slider.value = 0;
      this.timer = setInterval(() => {
        if (+slider.value >= +slider.max) return this.play();
        slider.value = +slider.value + 1;
        this.draw();
      }, 90);
    }
    byId("play").textContent = running ? "▶" : "❚❚";
    byId("play").setAttribute("aria-pressed", String(!running));
    byId("play").setAttribute("aria-label", running ? "play" : "pause");
  }

  reset() {
    Object.assign(this.viewer.view, +byId("open").value > 0.5 ? VIEWS.open : VIEWS.closed);
    this.draw();
  }

  pointers() {
    const canvas = byId("canvas");
    const down = new Map();
    const spread = () => { const [a, b] = [...down.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
    canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); down.set(e.pointerId, [e.clientX, e.clientY]); });
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (e) => down.delete(e.pointerId));
    canvas.addEventListener("pointerleave", () => { byId("tip").hidden = true; });
    canvas.addEventListener("pointermove", (e) => {
      const before = down.get(e.pointerId);
      if (!before) return this.tip(e);
      const apart = down.size === 2 && spread();
      down.set(e.pointerId, [e.clientX, e.clientY]);
      if (down.size === 1) this.viewer.turn((e.clientX - before[0]) * 0.009, (e.clientY - before[1]) * 0.009);
      else if (apart > 0) this.viewer.zoom(spread() / apart);
      this.draw();
    });
    canvas.addEventListener("wheel", (e) => { e.preventDefault(); this.viewer.zoom(Math.exp(-e.deltaY * 0.0012)); this.draw(); }, { passive: false });
    canvas.addEventListener("dblclick", () => this.reset());
    canvas.addEventListener("keydown", (e) => {
      const acts = {
        ArrowLeft: () => this.viewer.turn(-0.1, 0), ArrowRight: () => this.viewer.turn(0.1, 0),
        ArrowUp: () => this.viewer.turn(0, -0.1), ArrowDown: () => this.viewer.turn(0, 0.1),
        "+": () => this.viewer.zoom(1.15), "=": () => this.viewer.zoom(1.15), "-": () => this.viewer.zoom(1 / 1.15),
        0: () => this.reset(), " ": () => this.play(),
      };
      if (!acts[e.key] || e.ctrlKey || e.metaKey || e.altKey) return;
      e.preventDefault();
      acts[e.key]();
      this.draw();
    });
  }

  // Shows the value under the pointer.
  tip(event) {
    const box = byId("canvas").getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const found = this.viewer.pick(x / box.width, y / box.height);
    const tip = byId("tip");
    tip.hidden = !found;
    if (!found) return;
    const { unit: units } = QUANTITIES[chosen("quantity")];
    tip.textContent = `${found.show === "difference" ? "error " : ""}${short(found.value)} ${units}`;
    Object.assign(tip.style, { left: `${Math.min(x + 14, box.width - 110)}px`, top: `${Math.max(y - 30, 4)}px` });
  }
}

let controls;
function start() {
  try {
    controls = new Controls();
  } catch (error) {
    byId("no-webgl").hidden = !/WebGL/.test(error.message);
    errors.push(error.message);
    document.body.dataset.errors = errors.join("; ");
  }
}
if (byId("viewer")) start();
document.body.dataset.ready = "true";
