// Graphs with curves of both panels, as SVG pictures in the colours of the page.

const NS = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT] = [440, 240];
const EDGE = { left: 56, right: 26, top: 8, bottom: 38 };
const MOST = 1500; // largest number of points of a curve

function make(name, attributes, parent) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent?.append(element);
  return element;
}

// Round numbers from `low` to `high` at equal distances, for about `count` intervals.
export function ticks(low, high, count) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= raw * 0.999);
  const list = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) list.push(k * step);
  return list;
}

// Labels of ticks. All labels have the same number of decimal places, enough to distinguish neighbouring ticks.
export function labels(values) {
  const size = Math.max(...values.map(Math.abs));
  const step = values.length > 1 ? Math.abs(values[1] - values[0]) : size;
  const power = (value) => Math.floor(Math.log10(value) + 1e-9);
  const tiny = (value) => Math.abs(value) <= 1e-9 * size;
  const large = size < 1e-3 || size >= 1e5;
  const digits = Math.min(Math.max(large ? power(size) - power(step) : -power(step), 0), 12);
  return values.map((value) => (tiny(value) ? "0" : large ? value.toExponential(digits) : value.toFixed(digits)));
}

const SMALLEST = 5e-6; // smallest range of an axis over its largest magnitude; a smaller range needs too many digits
const GAPS = 0.08; // largest gap that is drawn, divided by the largest overlap

const label = (value) => (value === 0 ? "0" : Math.abs(value) < 1e-3 || Math.abs(value) >= 1e5 ? value.toExponential(0) : String(Number(value.toPrecision(4))));

// One graph. `until` is the right end of the horizontal axis; it is used only if this axis is the time.
export class Graph {
  constructor(spec, until, parent) {
    this.spec = spec;
    this.rows = [[], []];
    this.until = spec.x[0] === 0 ? until : null;
    const figure = document.createElement("figure");
    figure.className = "graph";
    const caption = document.createElement("figcaption");
    caption.textContent = spec.title;
    this.svg = make("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", class: "themed", "aria-label": spec.title });
    figure.append(caption, this.svg);
    parent.append(figure);
    this.axes = make("g", {}, this.svg);
    this.theory = make("path", { class: "theory" }, this.svg);
    const many = spec.columns.length > 1;
    this.lines = [0, 1].map((side) =>
      spec.columns.map((_, k) => {
        const series = many ? (k % 8) + 1 : side + 1;
        return make("path", { class: `line s${series} ${side ? "right" : "left"}` }, this.svg);
      }),
    );
    make("text", { x: (EDGE.left + WIDTH - EDGE.right) / 2, y: HEIGHT - 5, "text-anchor": "middle" }, this.svg).textContent = spec.x[1];
    const up = `rotate(-90) translate(${-(EDGE.top + HEIGHT - EDGE.bottom) / 2} 12)`;
    make("text", { transform: up, "text-anchor": "middle" }, this.svg).textContent = spec.y;
    this.drawn = "";
  }

  add(side, rows) {
    const kept = this.rows[side];
    for (const row of rows) kept.push(row);
    if (kept.length > MOST) this.rows[side] = kept.filter((_, k) => k % 2 === 0 || k === kept.length - 1);
  }

  // Smallest and largest value drawn along the axis `of` ("x" or "y"). `theory` has the points of the theoretical
  // curve.
  range(of, theory) {
    let [low, high] = [Infinity, -Infinity];
    const take = (value) => {
      if (value === null || !Number.isFinite(value) || (this.spec.logarithmic && of !== "x" && value <= 0)) return;
      [low, high] = [Math.min(low, value), Math.max(high, value)];
    };
    for (const rows of this.rows) {
      for (const row of rows) (of === "x" ? [this.spec.x[0]] : this.spec.columns).forEach((column) => take(row[column]));
    }
    theory.forEach((point) => take(point[of === "x" ? 0 : 1]));
    return low <= high ? [low, high] : [0, 1];
  }

  draw() {
    const theory = this.spec.theory?.[1] ?? [];
    const window = this.spec.window;
    let [x0, x1] = window ?? (this.until === null ? this.range("x", []) : [0, this.until]);
    let [y0, y1] = this.range("y", theory);
    const log = this.spec.logarithmic;
    // axis of the overlap, "x" or "y", on which only small gaps are shown; null for other graphs
    const gaps = this.spec.short_gaps ? (this.until === null ? "x" : "y") : null;
    const short = (low, high) => [high > -1e-3 * low ? Math.max(low, -GAPS * high) : low, high];
    if (gaps === "x") [x0, x1] = short(x0, x1);
    if (gaps === "y") [y0, y1] = short(y0, y1);
    if (log) {
      [y0, y1] = [Math.floor(Math.log10(y0) - 0.1), Math.ceil(Math.log10(y1) + 0.1)];
    } else {
      if (y0 > 0 && y0 < 0.5 * y1) y0 = 0;
      const least = SMALLEST * Math.max(Math.abs(y0), Math.abs(y1));
      const room = y1 > y0 ? Math.max(0.06 * (y1 - y0), 0.5 * (least - (y1 - y0))) : 0.5 * Math.abs(y1) || 0.5;
      [y0, y1] = [y0 === 0 ? 0 : y0 - room, y1 + room];
    }
    if (!(x1 > x0)) [x0, x1] = [x0 - 1, x0 + 1];
    const right = (x) => EDGE.left + ((x - x0) / (x1 - x0)) * (WIDTH - EDGE.left - EDGE.right);
    const up = (y) => HEIGHT - EDGE.bottom - (((log ? Math.log10(y) : y) - y0) / (y1 - y0)) * (HEIGHT - EDGE.top - EDGE.bottom);
    this.frame([x0, x1, y0, y1], right, up, log);
    const path = (points) => {
      let d = "";
      let pen = "M";
      for (const [x, y] of points) {
        const outside = (window && (x < x0 || x > x1)) || (gaps && (x < x0 || y < y0));
        if (outside || y === null || y === undefined || !Number.isFinite(y) || (log && y <= 0)) pen = "M";
        else [d, pen] = [`${d}${pen}${right(x).toFixed(1)} ${up(y).toFixed(1)}`, "L"];
      }
      return d;
    };
    this.theory.setAttribute("d", path(theory));
    this.lines.forEach((lines, side) =>
      lines.forEach((line, k) => line.setAttribute("d", path(this.rows[side].map((row) => [row[this.spec.x[0]], row[this.spec.columns[k]]])))),
    );
    this.tell();
  }

  // Axes, drawn anew only when they change.
  frame(ends, right, up, log) {
    const key = ends.map((end) => end.toPrecision(6)).join();
    if (key === this.drawn) return;
    this.drawn = key;
    const [x0, x1, y0, y1] = ends;
    this.axes.replaceChildren();
    const [bottom, left] = [HEIGHT - EDGE.bottom, EDGE.left];
    const along = ticks(x0, x1, 6);
    const words = labels(along);
    along.forEach((x, k) => {
      make("path", { class: "grid", d: `M${right(x)} ${EDGE.top}V${bottom}` }, this.axes);
      make("text", { x: right(x), y: bottom + 14, "text-anchor": "middle" }, this.axes).textContent = words[k];
    });
    const powers = log ? ticks(y0, y1, Math.min(6, y1 - y0)).filter(Number.isInteger).map((k) => 10 ** k) : ticks(y0, y1, 5);
    const heights = log ? powers.map(label) : labels(powers);
    powers.forEach((y, k) => {
      make("path", { class: "grid", d: `M${left} ${up(y)}H${WIDTH - EDGE.right}` }, this.axes);
      make("text", { x: left - 5, y: up(y) + 4, "text-anchor": "end" }, this.axes).textContent = heights[k];
    });
    make("path", { class: "axis", d: `M${left} ${EDGE.top}V${bottom}H${WIDTH - EDGE.right}` }, this.axes);
  }

  // Gives the latest values as text, for users of screen readers.
  tell() {
    const last = this.rows.map((rows) => rows.at(-1));
    const value = (row) => (row ? this.spec.columns.slice(0, 8).map((column) => Number(row[column])?.toPrecision(3)).join(", ") : "nothing yet");
    this.svg.setAttribute("aria-label", `${this.spec.title}. ${this.spec.y}, now: left ${value(last[0])}; right ${value(last[1])}.`);
  }
}
