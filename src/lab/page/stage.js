// The two panels, each with spheres on a canvas, arrows for forces, numbers, and a bar for the energy.

import { energy, live } from "./words.js";

const AXES = ["x", "y", "z"];
const LOOKS = 15; // number of frames between two checks that the colour scale covers all values
const NUMBERS = 120; // [ms] between two changes of the numbers; faster changes could not be read

export class Stage {
  constructor(opened) {
    this.opened = opened;
    this.panels = [...document.querySelectorAll(".panel")];
    const { right, up, region } = opened.view;
    this.view = AXES[right] + AXES[up];
    const [wide, high] = region ? [region[1] - region[0], region[3] - region[2]] : [opened.size[right], opened.size[up]];
    const aspect = Math.min(Math.max(wide / high, 0.8), 4);
    const centre = opened.size.map((size) => size / 2);
    if (region) [centre[right], centre[up]] = [(region[0] + region[1]) / 2, (region[2] + region[3]) / 2];
    this.focus = region ? { centre, wide, high } : undefined;
    this.scenes = opened.sides.map(() => ({ size: opened.size, periodic: opened.periodic, radius: [], walls: opened.walls ?? [] }));
    this.panels.forEach((panel, k) => {
      const side = opened.sides[k];
      panel.querySelector("h2, h3").textContent = side.title;
      panel.querySelector(".method").textContent = side.method;
      panel.querySelector("canvas").style.aspectRatio = String(aspect);
      panel.querySelector(".failure").hidden = true;
    });
    this.range = null;
    this.forces = 0;
  }

  // Ends of the colour scale: those of the first frame, widened if later values lie outside.
  scale(frames, colour) {
    if (colour === "plain") return undefined;
    this.looks = (this.looks ?? 0) + 1;
    if (this.range?.colour === colour && this.range.ends[1] > 0 && this.looks % LOOKS) return this.range.ends;
    const fresh = diptych.range(this.scenes[0], frames, colour);
    const known = this.range;
    if (known?.colour === colour && known.ends[0] <= fresh[0] && known.ends[1] >= fresh[1] * 0.999) return known.ends;
    if (!(fresh[1] > 0) && colour !== "overlap") return [0, 1];
    // the scale begins at 0 or, if the smallest value is at least half of the largest, 10 % below the smallest
    const lowest = fresh[0] < 0.5 * fresh[1] ? Math.min(fresh[0], 0) : 0.9 * fresh[0];
    this.range = { colour, ends: [lowest, 1.1 * fresh[1]] };
    const legend = document.getElementById("legend");
    legend.replaceChildren(diptych.legend(this.scenes[0], colour, this.range.ends));
    return this.range.ends;
  }

  // Part of the box that a canvas shows. If the part is too high for the canvas, a wider part is shown; the style of
  // the page limits the height of the canvas.
  seen(canvas) {
    if (!this.focus) return undefined;
    const { centre, wide, high } = this.focus;
    return { centre, width: Math.max(wide, (high * canvas.clientWidth) / (canvas.clientHeight || 1)) * 1.03 };
  }

  draw(frame, colour) {
    const now = performance.now();
    const still = frame.head.sides.every((side) => side.state !== "running" || side.time === 0);
    const tell = still || now - (this.told ?? 0) > NUMBERS;
    if (tell) this.told = now;
    frame.panels.forEach((panel, k) => (this.scenes[k].radius = panel.radius));
    const range = this.scale(frame.panels, colour);
    if (colour === "plain") document.getElementById("legend").replaceChildren();
    this.panels.forEach((panel, k) => {
      const canvas = panel.querySelector("canvas");
      const options = { view: this.view, colour, range, focus: this.seen(canvas) };
      let shown = frame.panels[k];
      if (this.opened.view.magnify) [shown, options.arrows] = this.magnified(shown, frame.head.sides[k]);
      diptych.drawScene(canvas, this.scenes[k], shown, options);
      if (tell) this.numbers(panel, frame.head.sides[k], k);
    });
  }

  // Positions of two spheres with an enlarged gap, and arrows for the forces on them.
  magnified(frame, side) {
    const { magnify, right } = this.opened.view;
    const position = frame.position.slice();
    const radii = frame.radius;
    const touch = radii[0] + radii[1];
    const middle = (position[right] + position[3 + right]) / 2;
    const gap = position[3 + right] - position[right] - touch;
    const half = (touch + magnify * gap) / 2;
    [position[right], position[3 + right]] = [middle - half, middle + half];
    const row = side.rows.at(-1) ?? this.last?.[side.model] ?? [];
    const forces = [row[3] || 0, row[4] || 0];
    this.forces = Math.max(this.forces, ...forces.map(Math.abs));
    const arrows = [];
    forces.forEach((force, kind) => {
      if (!force) return;
      const length = (0.9 * radii[0] * force) / this.forces;
      for (const [sphere, sign] of [[0, -1], [1, 1]]) {
        const from = [...position.slice(3 * sphere, 3 * sphere + 3)];
        from[this.opened.view.up] += (kind ? -0.35 : 0.35) * radii[0];
        const to = [...from];
        to[right] += sign * length;
        arrows.push({ from, to, kind: kind ? 3 : 2, label: sphere ? (kind ? "dashpot" : "spring") : "" });
      }
    });
    return [{ ...frame, position }, arrows];
  }

  numbers(panel, side, k) {
    const list = live(side, this.opened.sides[k].model);
    const dl = panel.querySelector(".live");
    if (dl.children.length !== 2 * list.length) {
      dl.replaceChildren(...list.flatMap(() => [document.createElement("dt"), document.createElement("dd")]));
    }
    list.forEach(([words, value], place) => {
      dl.children[2 * place].textContent = words;
      dl.children[2 * place + 1].textContent = value;
    });
    const { shares, sentence } = energy(side.live, this.opened.sides[k].model);
    const bar = panel.querySelector(".energy");
    if (!bar.children.length) {
      bar.append(...["kinetic", "elastic", "lost"].map((name) => Object.assign(document.createElement("span"), { className: name })));
      bar.setAttribute("role", "img");
    }
    shares.forEach((share, place) => (bar.children[place].style.width = `${(100 * share).toFixed(2)}%`));
    bar.setAttribute("aria-label", sentence);
    bar.title = sentence;
    panel.querySelector(".ledger").textContent = sentence;
    const failure = panel.querySelector(".failure");
    const words = side.failure ? `Stopped (${side.failure[0].replaceAll("_", " ")}): ${side.failure[1]}.` : "";
    if (failure.textContent !== words) failure.textContent = words;
    failure.hidden = !words;
  }
}
