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

// A share in per cent; what is smaller than any share that matters is 0.
const percent = (share) => `${Math.abs(share) < 5e-7 ? 0 : number(Number((100 * share).toPrecision(3)))} %`;

// An energy [J], 0 where only rounding is left.
const joules = (value) => (Math.abs(value) < 1e-15 ? "0 J" : si(value, "J"));

// [words, value] of the numbers beside a panel.
export function live(side, model) {
  const l = side.live;
  const list = [
    ["time", si(side.time, "s")],
    ["impacts", number(l.pairs + l.walls)],
    // none where spheres press on several others at once
    ...(l.restitution === null && l.pairs + l.walls > 0 ? [] : [["realised e", l.restitution === null ? "–" : l.restitution.toFixed(4)]]),
    // none where a run is too short to measure it
    ...(l.cost === null ? [] : [["cost", `${number(l.cost)} s per s`]]),
  ];
  if (model !== "hard" || l.missed > 0 || l.steps > 0) list.push(["deepest overlap", l.overlap === null ? "–" : `${percent(l.overlap)} of d`]);
  if (model !== "hard") list.push(["contact lasts", si(l.duration, "s")]);
  list.push(l.steps > 0 ? ["time steps", number(l.steps)] : ["impulses", number(l.events)]);
  if (l.missed > 0) list.push(["missed", `${number(l.missed)}, a share of ${percent(l.missed / (l.missed + l.pairs))}`]);
  return list;
}

const RESTING = 1e-3; // of the energy of a fall by one diameter: with less, spheres have only sunk into one another
const ROUNDING = 1e-11; // share of the energy that rounding alone can cost

// Shares of all energy that there was: moving, in springs, lost; and these in a sentence.
export function energy(l, model) {
  const kept = l.kinetic + l.elastic;
  const given = l.at_start + Math.max(l.work, 0);
  const all = Math.max(given, kept + Math.max(l.dissipated, 0));
  if (!(all > 0)) return { shares: [0, 0, 0], sentence: "no energy" };
  const shares = [l.kinetic, l.elastic, l.dissipated].map((part) => Math.max(part, 0) / all);
  // of soft spheres, the books close but for what the time steps create or lose
  const open = model === "hard" ? "not explained" : "error of the time steps";
  if (Math.max(given, kept) < RESTING * l.fall) {
    const fallen = `${percent(Math.abs(l.residual) / l.fall)} of what all spheres would gain in a fall by one diameter`;
    return { shares, sentence: `Energy, as nothing falls: ${joules(l.kinetic)} motion, ${joules(l.elastic)} springs; ${open}: ${joules(l.residual)}, ${fallen}.` };
  }
  const base = Math.max(l.at_start + Math.abs(l.work), l.dissipated);
  const unexplained = l.residual / Math.max(base, 1e-300);
  const books = Math.abs(unexplained) < ROUNDING ? "rounding only" : `${number(Number((100 * unexplained).toPrecision(2)))} %`;
  const lost = "lost in contacts and friction";
  return { shares, sentence: `Energy: ${percent(shares[0])} motion, ${percent(shares[1])} springs, ${percent(shares[2])} ${lost}; ${open}: ${books}.` };
}
