// Numbers and sentences beside the panels.

const PLAIN = new Intl.NumberFormat("en", { maximumSignificantDigits: 4, useGrouping: false });

// A number with four digits at most; with a power of ten where it is very large or small.
export function number(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) {
    const [digits, power] = value.toExponential(2).split("e");
    return `${Number(digits)} × 10${superscript(Number(power))}`;
  }
  return PLAIN.format(value);
}

const superscript = (power) => String(power).replace(/./g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻");

// A quantity in SI with the prefix that suits it.
export const si = (value, unit) => (value === null || value === undefined ? "–" : diptych.si(value, unit));

const percent = (share) => `${number(Number((100 * share).toPrecision(3)))} %`;

// [words, value] of the numbers beside a panel.
export function live(side, model) {
  const l = side.live;
  const list = [
    ["time", si(side.time, "s")],
    ["impacts", number(l.pairs + l.walls)],
    // none where spheres press on several others at once
    ...(l.restitution === null && l.pairs + l.walls > 0 ? [] : [["realised e", l.restitution === null ? "–" : l.restitution.toFixed(4)]]),
    ["cost", l.cost === null ? "–" : `${number(l.cost)} s per s`],
  ];
  if (model !== "hard" || l.missed > 0 || l.steps > 0) list.push(["deepest overlap", l.overlap === null ? "–" : `${percent(l.overlap)} of d`]);
  if (model !== "hard") list.push(["contact lasts", si(l.duration, "s")]);
  list.push(l.steps > 0 ? ["time steps", number(l.steps)] : ["impulses", number(l.events)]);
  if (l.missed > 0) list.push(["missed", number(l.missed)]);
  return list;
}

// Shares of all energy that there was: moving, in springs, lost; and these in a sentence.
export function energy(l, model) {
  const kept = l.kinetic + l.elastic;
  const all = Math.max(l.at_start + Math.max(l.work, 0), kept + Math.max(l.dissipated, 0));
  if (!(all > 0)) return { shares: [0, 0, 0], sentence: "no energy" };
  const shares = [l.kinetic, l.elastic, l.dissipated].map((part) => Math.max(part, 0) / all);
  const unexplained = l.residual / Math.max(l.at_start + Math.abs(l.work), 1e-300);
  const sentence =
    `Energy: ${percent(shares[0])} motion, ${percent(shares[1])} springs, ${percent(shares[2])} lost in impacts; ` +
    // of soft spheres, the books close but for what the time steps create or lose
    `${model === "hard" ? "not explained" : "error of the time steps"}: ${number(Number((100 * unexplained).toPrecision(2)))} %.`;
  return { shares, sentence };
}
