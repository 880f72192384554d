// Profiles of a channel over its height, and their difference, with standard errors.

import { labels, ticks } from "./graph.js";

const NS = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT] = [440, 240];
const EDGE = { left: 56, right: 26, top: 8, bottom: 38 };

function make(name, attributes, parent) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

// Title, label of the axis, columns of the value and of its standard error, and true if the difference of the two
// panels is drawn.
const PICTURES = [
  ["Profile of the velocity", "velocity [m/s]", 1, 2, false],
  ["Profile of the temperature", "T [m²/s²]", 3, 4, false],
  ["Difference of the velocities, right less left", "difference [m/s]", 1, 2, true],
  ["Difference of the temperatures, right less left", "difference [m²/s²]", 3, 4, true],
];
const BARS = 2; // length of an error bar above and below the value, in standard errors
const CAP = 3; // [px] half the width of the end of a bar

// Lines of a picture: lists of [height, value, standard error or null].
function lines(profiles, value, error, subtract) {
  const known = profiles.map((rows) => rows.map((row) => [row[0], row[value], row[error]]));
  if (subtract) {
    const less = ([y, left, one], [, right, other]) => [y, left === null || right === null ? null : right - left, one && other && Math.hypot(one, other)];
    known.splice(0, 2, known[0].map((row, k) => less(row, known[1][k])));
  }
  return known.map((rows) => rows.filter((row) => row[1] !== null));
}

// Velocity and temperature of both panels. A row is y [mm], velocity and its error [m/s], temperature and its error [m²/s²].
export class Profiles {
  constructor(parent) {
    this.pictures = PICTURES.map(([title, words, value, error, subtract]) => {
      const figure = document.createElement("figure");
      figure.className = "graph";
      const caption = document.createElement("figcaption");
      caption.textContent = title;
      figure.append(caption);
      const svg = make("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", class: "themed", "aria-label": `${title}: nothing averaged yet` }, figure);
      parent.append(figure);
      return { svg, caption, title, words, value, error, subtract };
    });
  }

  draw(profiles) {
    this.pictures.forEach((picture) => this.picture(picture, lines(profiles, picture.value, picture.error, picture.subtract)));
  }

  picture({ svg, caption, title, words, subtract }, known) {
    const ends = known.flat().flatMap(([, value, error]) => [value - BARS * (error ?? 0), value + BARS * (error ?? 0)]);
    if (!ends.length) return;
    const heights = known.flat().map((row) => row[0]);
    const [high, low] = subtract ? [Math.max(...ends, 0), Math.min(...ends, 0)] : [Math.max(...ends), Math.min(...ends)];
    const room = 0.08 * (high - low) || 1;
    const [y0, y1, top] = [low - room, high + room, Math.max(...heights) + Math.min(...heights)];
    const right = (x) => EDGE.left + (x / top) * (WIDTH - EDGE.left - EDGE.right);
    const up = (y) => HEIGHT - EDGE.bottom - ((y - y0) / (y1 - y0)) * (HEIGHT - EDGE.top - EDGE.bottom);
    svg.replaceChildren();
    this.axes(svg, [ticks(0, top, 5), right], [ticks(y0, y1, 5), up], words);
    if (subtract) make("path", { class: "axis", d: `M${EDGE.left} ${up(0)}H${WIDTH - EDGE.right}` }, svg);
    known.forEach((rows, side) => {
      const series = subtract ? "ink" : `s${side + 1}`;
      const shift = subtract ? 0 : side ? 2 : -2; // [px] so that both bars are seen
      const x = (row) => Number((right(row[0]) + shift).toFixed(1));
      const path = rows.map((row, k) => `${k ? "L" : "M"}${x(row)} ${up(row[1]).toFixed(1)}`).join("");
      make("path", { class: `line ${series} ${side ? "right" : "left"}`, d: path }, svg);
      const bar = (row) => {
        const [from, to] = [row[1] - BARS * row[2], row[1] + BARS * row[2]].map((end) => up(end).toFixed(1));
        return `M${x(row)} ${from}V${to}` + [from, to].map((end) => `M${x(row) - CAP} ${end}h${2 * CAP}`).join("");
      };
      make("path", { class: `error ${series}`, fill: "none", d: rows.filter((row) => row[2]).map(bar).join("") }, svg);
    });
    const barred = known.flat().some((row) => row[2]);
    caption.textContent = `${title}; ${barred ? "bars: two standard errors up and down" : "no errors before eight blocks of time"}`;
    svg.setAttribute("aria-label", `${title}, in ${known[0].length} slices from the lower to the upper wall.`);
  }

  axes(svg, [xs, right], [ys, up], words) {
    const [across, upwards] = [labels(xs), labels(ys)];
    xs.forEach((x, k) => {
      make("path", { class: "grid", d: `M${right(x)} ${EDGE.top}V${HEIGHT - EDGE.bottom}` }, svg);
      make("text", { x: right(x), y: HEIGHT - EDGE.bottom + 14, "text-anchor": "middle" }, svg).textContent = across[k];
    });
    ys.forEach((y, k) => {
      make("path", { class: "grid", d: `M${EDGE.left} ${up(y)}H${WIDTH - EDGE.right}` }, svg);
      make("text", { x: EDGE.left - 5, y: up(y) + 4, "text-anchor": "end" }, svg).textContent = upwards[k];
    });
    make("path", { class: "axis", d: `M${EDGE.left} ${EDGE.top}V${HEIGHT - EDGE.bottom}H${WIDTH - EDGE.right}` }, svg);
    make("text", { x: (EDGE.left + WIDTH - EDGE.right) / 2, y: HEIGHT - 5, "text-anchor": "middle" }, svg).textContent = "distance from the lower wall [mm]";
    const turn = `rotate(-90) translate(${-(EDGE.top + HEIGHT - EDGE.bottom) / 2} 12)`;
    make("text", { transform: turn, "text-anchor": "middle" }, svg).textContent = words;
  }
}
