// Positions that the player of reports draws between two recorded frames, of a sphere that leaves through the upper side of a periodic box
// and flies freely: with and without shear. Needs no browser.
//
//     node tests/browser/flight.mjs
import { readFileSync } from "node:fs";

const text = readFileSync(new URL("../../src/output/page/player.js", import.meta.url), "utf8");
const [from, to] = [text.indexOf("  // In a sheared box"), text.indexOf("  // All particles of a variant at the time")];
const fly = new Function(`${text.slice(from, to)}; return fly;`)();
const size = [1, 2, 3];
const [start, velocity] = [[0.5, 1.9, 0.2], [0.3, 0.4, 0.5]];
const [unit, steps] = [1e-4, 65535];
let worst = 0;
for (const slide of [{ start: 0.4, speed: 1.4 }, undefined]) {
  // position in the box and velocity after a free flight from t = 2
  const exact = (t) => {
    const x = start.map((one, axis) => one + velocity[axis] * (t - 2));
    const v = [...velocity];
    const heights = Math.floor(x[1] / size[1]);
    if (slide) {
      x[2] -= heights * (slide.start + slide.speed * t);
      v[2] -= heights * slide.speed;
    }
    return [x.map((one, axis) => one - size[axis] * Math.floor(one / size[axis])), v];
  };
  const stored = (t) => exact(t)[0].map((one, axis) => Math.round((one / size[axis]) * steps));
  const velocities = [2, 3].flatMap((t) => exact(t)[1]).map((one) => Math.round(one / unit));
  const variant = { count: 1, unit, times: [2, 3], position: [...stored(2), ...stored(3)], velocity: velocities };
  const scene = { size, periodic: [true, true, true], gravity: [0, 0, 0], slide };
  // the sphere crosses the side at t = 2.25
  for (const t of [2, 2.1, 2.24, 2.26, 2.6, 3]) {
    const out = { position: [], velocity: [] };
    fly(scene, variant, 0, 0, t, out);
    const [x, v] = exact(t);
    for (let axis = 0; axis < 3; axis++) {
      worst = Math.max(worst, Math.abs(x[axis] - out.position[axis]) / size[axis], Math.abs(v[axis] - out.velocity[axis]) * (unit / 2));
    }
  }
}
// positions of both frames are rounded to half a step
const allowed = 1 / steps;
console.log(`flight between frames: largest error ${worst.toExponential(1)} of the box, allowed ${allowed.toExponential(1)}`);
process.exit(worst <= allowed ? 0 : 1);
