// Profiles of a channel over its height, with their standard errors.

const NS = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT] = [440, 240];
const EDGE = { left: 56, right: 26, top: 8, bottom: 38 };

function make(name, attributes, parent) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

// Velocity and temperature of both panels. A row is y [mm], velocity and its error [m/s], temperature [m²/s²].
export class Profiles {
  constructor(parent) {
    this.pictures = [["Profile of the velocity", "velocity [m/s]", 1, 2], ["Profile of the temperature", "T [m²/s²]", 3, null]].map(
      ([title, words, column, error]) => {
        const figure = document.createElement("figure");
        figure.className = "graph";
        figure.append(Object.assign(document.createElement("figcaption"), { textContent: title }));
        const svg = make("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", class: "themed", "aria-label": `${title}: nothing averaged yet` }, figure);
        parent.append(figure);
        return { svg, title, words, column, error };
      },
    );
  }

  draw(profiles) {
    this.pictures.forEach((picture) => this.picture(picture, profiles));
  }

  picture({ svg, title, words, column, error }, profiles) {
    const known = profiles.map((rows) => rows.filter((row) => row[column] !== null));
    const values = known.flat().flatMap((row) => [row[column] - 2 * (row[error] ?? 0), row[column] + 2 * (row[error] ?? 0)]);
    if (!values.length) return;
    const heights = known.flat().map((row) => row[0]);
    const [high, low] = [Math.max(...values), Math.min(...values)];
    const room = 0.08 * (high - low) || 1;
    const [y0, y1, top] = [low - room, high + room, Math.max(...heights) + Math.min(...heights)];
    const right = (x) => EDGE.left + (x / top) * (WIDTH - EDGE.left - EDGE.right);
    const up = (y) => HEIGHT - EDGE.bottom - ((y - y0) / (y1 - y0)) * (HEIGHT - EDGE.top - EDGE.bottom);
    svg.replaceChildren();
    for (let k = 0; k <= 4; k++) {
      const [x, y] = [(top * k) / 4, y0 + ((y1 - y0) * k) / 4];
      make("path", { class: "grid", d: `M${right(x)} ${EDGE.top}V${HEIGHT - EDGE.bottom}M${EDGE.left} ${up(y)}H${WIDTH - EDGE.right}` }, svg);
      make("text", { x: right(x), y: HEIGHT - EDGE.bottom + 14, "text-anchor": "middle" }, svg).textContent = Number(x.toPrecision(3));
      make("text", { x: EDGE.left - 5, y: up(y) + 4, "text-anchor": "end" }, svg).textContent = Number(y.toPrecision(3));
    }
    make("path", { class: "axis", d: `M${EDGE.left} ${EDGE.top}V${HEIGHT - EDGE.bottom}H${WIDTH - EDGE.right}` }, svg);
    known.forEach((rows, side) => {
      const shift = side ? 1.5 : -1.5; // [px] so that both bars are seen
      const at = (row) => `${(right(row[0]) + shift).toFixed(1)} ${up(row[column]).toFixed(1)}`;
      make("path", { class: `line s${side + 1} ${side ? "right" : "left"}`, d: rows.map((row, k) => `${k ? "L" : "M"}${at(row)}`).join("") }, svg);
      const bars = rows.filter((row) => error !== null && row[error]).map((row) => {
        const [low, high] = [row[column] - row[error], row[column] + row[error]];
        return `M${(right(row[0]) + shift).toFixed(1)} ${up(low).toFixed(1)}V${up(high).toFixed(1)}`;
      });
      make("path", { class: `error s${side + 1}`, fill: "none", d: bars.join("") }, svg);
    });
    make("text", { x: (EDGE.left + WIDTH - EDGE.right) / 2, y: HEIGHT - 5, "text-anchor": "middle" }, svg).textContent = "distance from the lower wall [mm]";
    const turn = `rotate(-90) translate(${-(EDGE.top + HEIGHT - EDGE.bottom) / 2} 12)`;
    make("text", { transform: turn, "text-anchor": "middle" }, svg).textContent = words;
    svg.setAttribute("aria-label", `${title} of both panels, in ${known[0].length} slices from the lower to the upper wall.`);
  }
}
