// Charts, drawn as SVG at the current width of their elements.
const SVG = "http://www.w3.org/2000/svg";
const LINES = ["one", "two", "three"];

function put(parent, name, attributes, text) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

const short = (v) => (v === 0 ? "0" : Math.abs(v) >= 1e4 || Math.abs(v) < 1e-3 ? v.toExponential(1) : String(+v.toPrecision(3)));

// Round tick values from 0 to at least `most`.
function ticks(most, wanted = 5) {
  if (!(most > 0)) return [0, 1];
  const power = 10 ** Math.floor(Math.log10(most / wanted));
  const step = [1, 2, 2.5, 5, 10].map((f) => f * power).find((s) => s * wanted >= most * 0.999);
  return [...Array(Math.ceil(most / step - 1e-9) + 1).keys()].map((k) => +(k * step).toPrecision(6));
}

const numbers = (list) => list.filter((v) => v !== null);

function canvasOf(figure, height) {
  figure.querySelector("svg")?.remove();
  const width = Math.max(280, figure.clientWidth);
  return [put(figure, "svg", { viewBox: `0 0 ${width} ${height}`, height, role: "img", "aria-label": figure.dataset.title || "" }), width];
}

// Bar chart: bar at the median, line to the 90th percentile, dot at the worst value.
function drawBars(figure, names, quantity) {
  const [row, left, top] = [30, 130, 6];
  const height = top + row * names.length + 40;
  const [svg, width] = canvasOf(figure, height);
  // Outliers must not determine the scale: values beyond the axis are drawn at its end with their number.
  const [usual, extreme] = [1, 2].map((k) => Math.max(...numbers(quantity.series[k].values), 0));
  const marks = ticks(extreme > 4 * usual && usual > 0 ? 2 * usual : extreme, 6);
  const most = marks[marks.length - 1];
  const x = (v) => left + ((width - left - 20) * v) / most;
  const bottom = top + row * names.length;
  for (const v of marks) {
    put(svg, "line", { class: "grid", x1: x(v), x2: x(v), y1: top, y2: bottom });
    put(svg, "text", { class: "muted", x: x(v), y: bottom + 16, "text-anchor": "middle" }, short(v));
  }
  put(svg, "text", { class: "muted", x: width - 20, y: bottom + 32, "text-anchor": "end" }, `error of the ${quantity.name}, ${quantity.unit}`);
  names.forEach((name, i) => {
    const y = top + row * (i + 0.5);
    const [median, p90, worst] = quantity.series.map((s) => s.values[i]);
    const group = put(svg, "g", {});
    put(group, "title", {}, `${name}: median ${short(median)}, 90 % below ${short(p90)}, worst ${short(worst)} ${quantity.unit}`);
    put(group, "text", { x: left - 10, y: y + 4, "text-anchor": "end" }, name);
    put(group, "rect", { class: "value", x: left, y: y - 8, width: Math.max(1, x(median) - left), height: 16, rx: 2 });
    put(group, "line", { class: "whisker", x1: x(median), x2: x(p90), y1: y, y2: y });
    put(group, "line", { class: "whisker", x1: x(p90), x2: x(p90), y1: y - 5, y2: y + 5 });
    put(group, "circle", { class: "extreme", cx: x(Math.min(worst, most)), cy: y, r: 3.5 });
    if (worst > most) put(group, "text", { class: "muted", x: x(most) - 9, y: y + 4, "text-anchor": "end" }, `${short(worst)} →`);
  });
}

// Line chart; `now` is the index of the marked abscissa, `pick` is called with the index under the pointer.
function drawLines(figure, { label, at }, series, unit, now, pick) {
  const [height, left, bottom, right] = [240, 52, 40, 16];
  const [svg, width] = canvasOf(figure, height);
  // The axis of values is logarithmic if they differ by more than a factor of 30.
  const all = series.flatMap((s) => numbers(s.values)).filter((v) => v > 0);
  const [least, largest] = [Math.min(...all), Math.max(...all, 0)];
  const decades = largest > 30 * least;
  const bounds = decades ? [Math.floor(Math.log10(least)), Math.ceil(Math.log10(largest))] : [];
  const marks = decades ? [...Array(bounds[1] - bounds[0] + 1).keys()].map((k) => +(10 ** (bounds[0] + k)).toPrecision(6)) : ticks(largest);
  const part = (v) => decades ? (Math.log10(Math.max(v, 10 ** bounds[0])) - bounds[0]) / (bounds[1] - bounds[0]) : v / marks[marks.length - 1];
  // Integer abscissae, e.g. epochs, have integer ticks only.
  const whole = at.every(Number.isInteger);
  const room = width < 420 ? 4 : 6;
  const stops = ticks(Math.max(...at), room).filter((v) => v <= Math.max(...at) * 1.001 && (!whole || Number.isInteger(v)));
  const y = (v) => height - bottom - (height - bottom - 22) * part(v);
  const x = (v) => left + ((width - left - right) * v) / Math.max(...at);
  for (const v of marks) {
    put(svg, "line", { class: "grid", x1: left, x2: width - right, y1: y(v), y2: y(v) });
    put(svg, "text", { class: "muted", x: left - 8, y: y(v) + 4, "text-anchor": "end" }, short(v));
  }
  for (const v of stops) put(svg, "text", { class: "muted", x: x(v), y: height - bottom + 18, "text-anchor": "middle" }, short(v));
  put(svg, "line", { class: "axis", x1: left, x2: width - right, y1: height - bottom, y2: height - bottom });
  put(svg, "text", { class: "muted", x: width - right, y: height - 4, "text-anchor": "end" }, label);
  put(svg, "text", { class: "muted", x: 4, y: 12 }, unit);
  series.forEach((s, i) => {
    const points = at.map((v, k) => [v, s.values[k]]).filter((p) => p[1] !== null);
    put(svg, "polyline", { class: `series ${LINES[i]}`, points: points.map((p) => `${x(p[0])},${y(p[1])}`).join(" ") });
    for (const [v, e] of points) put(put(svg, "circle", { class: LINES[i], cx: x(v), cy: y(e), r: points.length > 30 ? 1.8 : 2.6 }), "title", {}, `${s.name}: ${short(e)} ${unit} at ${short(v)}`);
  });
  if (now !== undefined) put(svg, "line", { class: "now", x1: x(at[now]), x2: x(at[now]), y1: 16, y2: height - bottom });
  if (pick) {
    svg.style.cursor = "pointer";
    svg.addEventListener("click", (event) => {
      const box = svg.getBoundingClientRect();
      const wanted = ((event.clientX - box.left) / box.width) * width;
      pick(at.reduce((best, v, k) => (Math.abs(x(v) - wanted) < Math.abs(x(at[best]) - wanted) ? k : best), 0));
    });
  }
}

// Calls `draw` now and whenever the width of `element` changes, outside of the observer callback to avoid a resize
// loop.
function atWidth(element, draw) {
  let width = element.clientWidth;
  draw();
  new ResizeObserver(() => requestAnimationFrame(() => {
    if (element.clientWidth === width || !element.isConnected) return;
    width = element.clientWidth;
    draw();
  })).observe(element);
}

function keys(line, names) {
  line.querySelectorAll(".key").forEach((key) => key.remove());
  names.forEach((name, i) => {
    const item = document.createElement("span");
    item.className = `key ${LINES[i]}`;
    item.append(document.createElement("i"), name);
    line.append(item);
  });
}

function head(figure, title, names) {
  figure.dataset.title = title;
  const line = document.createElement("div");
  line.className = "head";
  const name = document.createElement("strong");
  name.textContent = title;
  line.append(name);
  keys(line, names);
  figure.replaceChildren(line);
  return line;
}

// Chart of the page with a selection of its quantity.
function chart(figure, { title, over, quantities }) {
  const line = head(figure, title, []);
  const choice = document.createElement("select");
  choice.setAttribute("aria-label", "quantity");
  quantities.forEach((q, i) => choice.add(new Option(q.name, i)));
  line.append(choice);
  if (over.names) {
    const key = document.createElement("span");
    key.className = "key";
    key.textContent = "bar: median, line: 90 % below, dot: worst";
    line.append(key);
  }
  const draw = () => {
    const q = quantities[choice.value];
    if (over.names) return drawBars(figure, over.names, q);
    keys(line, q.series.map((s) => s.name));
    drawLines(figure, over.axis, q.series, q.unit === "1" ? "" : q.unit);
  };
  choice.addEventListener("change", draw);
  atWidth(figure, draw);
}

function drawCharts() {
  document.querySelectorAll("[data-chart]").forEach((figure) => chart(figure, data.charts[figure.dataset.chart]));
  document.querySelectorAll("time[data-at]").forEach((time) => {
    const date = new Date(1000 * time.dataset.at);
    time.dateTime = date.toISOString();
    time.textContent = date.toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });
  });
}
drawCharts();
