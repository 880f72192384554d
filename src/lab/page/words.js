// Numbers and sentences beside the panels.

const PLAIN = new Intl.NumberFormat("en", { maximumSignificantDigits: 4, useGrouping: false });

// Number as text, with at most four digits, and with a power of ten if it is very large or small.
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

// Quantity in an SI unit as text, with a suitable prefix.
export const si = (value, unit) => (value === null || value === undefined ? "–" : diptych.si(value, unit));

// Share in per cent as text; a share too small to matter (below 5e-7) is 0.
const percent = (share) => `${Math.abs(share) < 5e-7 ? 0 : number(Number((100 * share).toPrecision(3)))} %`;

// Energy [J] as text; below 1e-15 J it is 0, since this is only rounding.
const joules = (value) => (Math.abs(value) < 1e-15 ? "0 J" : si(value, "J"));

// Numbers beside a panel: a list of pairs [words, value].
export function live(side, model) {
  const l = side.live;
  const list = [
    ["time", si(side.time, "s")],
    ["impacts", number(l.pairs + l.walls)],
    // no restitution in scenes in which spheres press on several others at once
    ...(l.restitution === null && l.pairs + l.walls > 0 ? [] : [["realised e", l.restitution === null ? "–" : l.restitution.toFixed(4)]]),
    // no cost if the run is too short to measure it
    ...(l.cost === null ? [] : [["cost", `${number(l.cost)} s per s`]]),
  ];
  if (model !== "hard" || l.missed > 0 || l.steps > 0) list.push(["deepest overlap", l.overlap === null ? "–" : `${percent(l.overlap)} of d`]);
  if (model !== "hard") list.push(["contact lasts", si(l.duration, "s")]);
  list.push(l.steps > 0 ? ["time steps", number(l.steps)] : ["impulses", number(l.events)]);
  if (l.missed > 0) list.push(["missed", `${number(l.missed)}, a share of ${percent(l.missed / (l.missed + l.pairs))}`]);
  return list;
}

const RESTING = 1e-3; // share of the energy of a fall by one diameter; below it, spheres only sink into one another
const ROUNDING = 1e-11; // largest share of the energy that rounding alone can change

// Shares of the total energy so far: kinetic, elastic and lost. Also returns a sentence with these shares.
export function energy(l, model) {
  const kept = l.kinetic + l.elastic;
  const given = l.at_start + Math.max(l.work, 0);
  const all = Math.max(given, kept + Math.max(l.dissipated, 0));
  if (!(all > 0)) return { shares: [0, 0, 0], sentence: "no energy" };
  const shares = [l.kinetic, l.elastic, l.dissipated].map((part) => Math.max(part, 0) / all);
  // for soft spheres, only errors of the time steps remain unexplained in the energy balance
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
