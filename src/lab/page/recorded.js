// Plays recorded runs in place of the connection to the program (src/lab/export.rs).

import { COLUMNS, panel } from "./frames.js";

const MOVING = 5; // columns that change during a run: all but the radius
const LONGEST = 100; // [ms] longest time between two drawings that moves the run on; the rest of a pause is left out

const { version, scenes, recordings, frames: FRAMES } = JSON.parse(document.getElementById("recording").textContent);

export const unpack = (frame) => frame;

// Numbers of all particles of a recording, as 16-bit fractions.
function fractions(recording) {
  const text = atob(recording.particles);
  const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  return new DataView(bytes.buffer);
}

class Run {
  constructor(recording, serial) {
    Object.assign(this, { recording, serial, at: 0, shown: -1, numbers: fractions(recording) });
  }

  get last() {
    return this.recording.frames.length - 1;
  }

  frame(number) {
    const { frames, scales, radii } = this.recording;
    let place = number * radii.reduce((sum, panel) => sum + panel.length, 0);
    const panels = radii.map((all) => {
      const values = new Float32Array(COLUMNS * all.length);
      all.forEach((radius, k) => {
        for (let column = 0; column < MOVING; column++) {
          const [least, range] = scales[column];
          values[COLUMNS * k + column] = least + (range * this.numbers.getUint16(2 * (MOVING * place + column), true)) / 65535;
        }
        values[COLUMNS * k + MOVING] = radius;
        place += 1;
      });
      return panel(values);
    });
    return { head: { serial: this.serial, ...frames[number] }, panels };
  }
}

const same = (a, b) => JSON.stringify(Object.entries(a).sort()) === JSON.stringify(Object.entries(b).sort());

// Recorded run for the present choice of the user; `before` is the previous choice. Recorded runs differ from the case
// by one setting, so the setting that the user has just changed determines the run.
function recorded(choice, before) {
  const find = (right, settings) => recordings.find((one) => one.right === right && same(one.settings, settings));
  if (choice.right !== before.right) return find(choice.right, {});
  const changed = Object.keys(choice.settings).find((name) => choice.settings[name] !== before.settings[name]);
  return (changed && find(0, { [changed]: choice.settings[changed] })) || find(choice.right, {}) || recordings[0];
}

// Values of a parameter (knob) for which there are recorded runs, in ascending order.
function stops(knob) {
  const others = recordings.map((one) => one.settings[knob.name]).filter((value) => value !== undefined);
  return [...others, knob.default].sort((a, b) => a - b);
}

function described({ opened, settings }, serial) {
  const knobs = opened.knobs.map((knob) => (knob.kind.words ? knob : { ...knob, kind: { stops: stops(knob) } }));
  return { ...opened, knobs, serial, tell: "opened", recorded: settings };
}

export function connect(on) {
  const wish = { playing: true, looking: true, factor: 1 };
  let run = null;
  let [before, then] = [{ right: 0, settings: {} }, performance.now()];

  function give(number) {
    while (run.shown < number) on.framed(run.frame(++run.shown));
    run.at = Math.max(run.at, run.shown);
  }

  const asked = {
    open(choice) {
      const found = recorded(choice, before);
      before = { right: found.right, settings: found.settings };
      run = new Run(found, choice.serial);
      on.told(described(found, choice.serial));
      give(0);
    },
    play: ({ on: playing }) => (wish.playing = playing),
    step: () => run && give(Math.min(run.shown + 1, run.last)),
    pace: ({ factor }) => (wish.factor = factor),
    look: ({ on: looking }) => (wish.looking = looking),
    drawn() {},
  };

  function go(now) {
    const passed = Math.min(now - then, LONGEST) / 1000;
    then = now;
    if (run && wish.playing && wish.looking) {
      const { pace, duration } = run.recording.opened;
      // if the runs of both panels stopped early, the recording may have fewer frames than its duration needs
      run.at = Math.min(run.at + (passed * pace * wish.factor * FRAMES) / duration, run.last);
      give(Math.floor(run.at));
    }
    requestAnimationFrame(go);
  }

  setTimeout(() => {
    on.told({ tell: "scenes", scenes, version, recorded: true });
    requestAnimationFrame(go);
  });
  return (ask) => asked[ask.ask](ask);
}
