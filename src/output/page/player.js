// Shows recorded particles of several variants (experiments of a case) side by side, with one slider for the time. The script works on every
// <section class="player"> with a script element of the type application/json, which contains the recording (src/output/player/mod.rs
// describes its contents). It draws with scene.js. Nothing moves until the reader starts the animation.
"use strict";
(() => {
  const SHOWN = 3; // number of panels side by side
  const WHOLE = 12; // [s] in which the whole recording is played
  const CLOSE = 4; // [s] in which the interval around a contact is played
  const WIDE = 9; // [diameters] width of the part of the scene that is shown around a contact
  const LONG = 30; // largest number of frames over which a contact is followed
  const SAMPLES = 30; // number of frames from which the range of the colour scale is computed
  const STEPS = 24; // steps in which the recording is played if the reader prefers reduced motion

  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

  // Decodes the recorded numbers of a variant. Each array is ordered by frame, then by particle.
  function decode(variant) {
    const data = bytes(variant.data).buffer;
    const [frames, count] = [variant.times.length, variant.radius.length];
    const part = (Kind, offset, length) => new Kind(data, offset, length);
    const each = frames * count;
    const [overlaps, spins] = [variant.deepest, variant.swiftest].map((most) => (most > 0 ? 2 * each : 0));
    return {
      ...variant,
      count,
      position: part(Uint16Array, 0, 3 * each),
      velocity: part(Int16Array, 6 * each, 3 * each),
      overlap: overlaps ? part(Uint16Array, 12 * each, each) : null,
      spin: spins ? part(Uint16Array, 12 * each + overlaps, each) : null,
      solver: part(Uint8Array, 12 * each + overlaps + spins, each),
      last: variant.times[frames - 1],
    };
  }

  // Index of the last frame at or before a time.
  function interval(times, time) {
    let [low, high] = [0, times.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle;
    }
    return low;
  }

  // Position and velocity of a particle between two frames. It is assumed to collide at most once between them: the
  // collision is at the instant at which the flight from the first frame and the flight to the next frame are nearest.
  // In a sheared box, periodic images across the upper and the lower side slide along z: a particle that leaves through
  // one of these sides returns displaced, and with another velocity along z.
  const slid = (scene, time) => scene.slide.start + scene.slide.speed * time;
  const [way, apart, change, last] = [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]];
  function fly(scene, variant, k, particle, time, out) {
    const next = Math.min(k + 1, variant.times.length - 1);
    const long = variant.times[next] - variant.times[k];
    const s = Math.min(Math.max(time - variant.times[k], 0), long);
    const [a, b] = [3 * (k * variant.count + particle), 3 * (next * variant.count + particle)];
    let [product, square, heights] = [0, 0, 0];
    for (let axis = 0; axis < 3; axis++) {
      const size = scene.size[axis];
      const va = variant.velocity[a + axis] * variant.unit;
      last[axis] = variant.velocity[b + axis] * variant.unit;
      const g = scene.gravity[axis];
      way[axis] = ((variant.position[b + axis] - variant.position[a + axis]) * size) / 65535;
      if (axis === 2 && heights !== 0) {
        way[axis] -= heights * slid(scene, variant.times[next]);
        last[axis] -= heights * scene.slide.speed;
      }
      if (scene.periodic[axis]) {
        const periods = Math.round((way[axis] - 0.5 * (va + last[axis]) * long) / size);
        way[axis] -= size * periods;
        if (axis === 1 && scene.slide) heights = periods;
      }
      // flight from this frame minus flight back from the next frame: difference of the positions at the start, and its change per time
      apart[axis] = last[axis] * long - 0.5 * g * long * long - way[axis];
      change[axis] = va - last[axis] + g * long;
      product += apart[axis] * change[axis];
      square += change[axis] * change[axis];
    }
    const meet = square > 0 ? Math.min(Math.max(-product / square, 0), long) : 0.5 * long;
    const rest = long - s;
    let above = 0;
    for (let axis = 0; axis < 3; axis++) {
      const size = scene.size[axis];
      const from = (variant.position[a + axis] * size) / 65535;
      const va = variant.velocity[a + axis] * variant.unit;
      const g = scene.gravity[axis];
      // drag or further collisions leave a distance between both flights; half of it is added to each flight
      const left = 0.5 * (apart[axis] + meet * change[axis]);
      let x;
      if (scene.linear || long <= 0) x = from + (long > 0 ? (way[axis] * s) / long : 0);
      else if (s < meet) x = from + va * s + 0.5 * g * s * s - left * (s / meet);
      else x = from + way[axis] - last[axis] * rest + 0.5 * g * rest * rest + (rest > 0 ? left * (rest / (long - meet)) : 0);
      let v = s < meet ? va + g * s : last[axis] - g * rest;
      if (scene.along) x -= scene.drift[axis] * time;
      if (axis === 2 && above !== 0) {
        x -= above * slid(scene, time);
        v -= above * scene.slide.speed;
      }
      if (scene.periodic[axis]) {
        const periods = Math.floor(x / size);
        x -= size * periods;
        if (axis === 1 && scene.slide) above = periods;
      }
      out.position[3 * particle + axis] = x;
      out.velocity[3 * particle + axis] = v;
    }
  }

  // All particles of a variant at the time `time`. After the end of the recording, the particles stay as in the last frame.
  function frameAt(scene, variant, time, out) {
    const k = interval(variant.times, Math.min(time, variant.last));
    const next = Math.min(k + 1, variant.times.length - 1);
    const share = next > k ? (Math.min(time, variant.last) - variant.times[k]) / (variant.times[next] - variant.times[k]) : 0;
    for (let particle = 0; particle < variant.count; particle++) {
      fly(scene, variant, k, particle, Math.min(time, variant.last), out);
      const [a, b] = [k * variant.count + particle, next * variant.count + particle];
      const mixed = (of, most) => ((of[a] + (of[b] - of[a]) * share) * most) / 65535;
      if (variant.overlap) out.overlap[particle] = mixed(variant.overlap, variant.deepest);
      if (variant.spin) out.spin[particle] = mixed(variant.spin, variant.swiftest);
      out.solver[particle] = variant.solver[share < 0.5 ? a : b];
    }
    return out;
  }

  const blank = (variant) => ({
    position: new Float32Array(3 * variant.count),
    velocity: new Float32Array(3 * variant.count),
    overlap: new Float32Array(variant.count),
    spin: new Float32Array(variant.count),
    solver: new Uint8Array(variant.count),
  });

  const sceneOf = (scene, variant) => ({ ...scene, radius: variant.radius, species: variant.species });

  function make(name, attributes, ...children) {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.append(...children);
    return element;
  }

  const choice = (label, options, change) => {
    const select = make("select", {}, ...options.map(([value, words]) => make("option", { value }, words)));
    select.addEventListener("change", () => change(select.value));
    return make("label", {}, `${label} `, select);
  };

  // [m/s] change of the velocity of a particle between two frames, without the change by gravity.
  function turn(scene, variant, k, particle) {
    const long = variant.times[k + 1] - variant.times[k];
    const [a, b] = [3 * (k * variant.count + particle), 3 * ((k + 1) * variant.count + particle)];
    return Math.hypot(...[0, 1, 2].map((axis) => (variant.velocity[b + axis] - variant.velocity[a + axis]) * variant.unit - scene.gravity[axis] * long));
  }

  // First interval after the time `time` in which a particle of one of the variants collides: { particle, from, to }.
  function contact(scene, variants, time) {
    const found = [];
    for (const variant of variants) {
      let fastest = 0;
      const first = [0, 1, 2].map((axis) => scene.drift[axis]);
      for (let k = 0; k < 3 * variant.count; k++) {
        fastest = Math.max(fastest, Math.abs(variant.velocity[k] * variant.unit - first[k % 3]));
      }
      const begin = interval(variant.times, time);
      for (let k = begin + (variant.times[begin] < time ? 1 : 0); k + 1 < variant.times.length; k++) {
        let [most, struck] = [0.25 * fastest, -1];
        for (let particle = 0; particle < variant.count; particle++) {
          const size = turn(scene, variant, k, particle);
          if (size > most) [most, struck] = [size, particle];
        }
        if (struck >= 0) {
          // a contact may last over several frames
          let end = k + 1;
          while (end + 1 < variant.times.length && end - k < LONG && turn(scene, variant, end, struck) > 0.02 * fastest) end += 1;
          found.push({ particle: struck, from: variant.times[k], to: variant.times[end] });
          break;
        }
      }
    }
    const [first] = found.sort((a, b) => a.from - b.from);
    // contacts that overlap in time with the first one extend the interval, so that each of them is shown completely
    return first && { ...first, to: Math.max(...found.filter((one) => one.from <= first.to).map((one) => one.to)) };
  }

  function player(section) {
    const scene = JSON.parse(section.querySelector("script").textContent);
    const variants = scene.variants.map(decode);
    scene.along = scene.drift.some((part) => part !== 0);
    const end = Math.max(...variants.map((variant) => variant.last));
    const still = matchMedia("(prefers-reduced-motion: reduce)");
    const state = { time: 0, playing: false, view: scene.view, colour: "speed", focus: null, until: end, pace: end / WHOLE, before: 0 };
    const boxes = [...section.querySelectorAll(".panel")].slice(0, SHOWN);
    const panels = boxes.map((box, place) => {
      const canvas = make("canvas", { class: "scene-canvas", role: "img", tabindex: "0" });
      const words = make("p", { class: "note" });
      box.querySelector("svg").replaceWith(canvas);
      box.append(words);
      const panel = { variant: variants[place], canvas, words, frame: blank(variants[place]) };
      if (variants.length > boxes.length) {
        const options = variants.map((variant, k) => [String(k), variant.name]);
        const select = choice("", options, (k) => {
          [panel.variant, panel.frame] = [variants[k], blank(variants[k])];
          settle();
        });
        select.querySelector("select").value = String(place);
        select.querySelector("select").setAttribute("aria-label", `variant of panel ${place + 1}`);
        box.querySelector("figcaption").replaceChildren(select);
      }
      return panel;
    });

    const play = make("button", { type: "button" }, "Play");
    const slow = make("button", { type: "button" }, "Slow motion at the next contact");
    const whole = make("button", { type: "button", hidden: "" }, "Whole scene");
    const slider = make("input", { type: "range", min: "0", max: "1000", step: "1", value: "0", "aria-label": "time" });
    const clock = make("output", {});
    const said = make("p", { class: "unseen", role: "status" });
    const legend = make("div", {});
    const colours = [["speed", "speed"]];
    if (variants.some((variant) => variant.overlap)) colours.push(["overlap", "overlap"]);
    if (variants.some((variant) => variant.spin)) colours.push(["spin", "spin"]);
    if (variants.some((variant) => variant.solver.some((solver) => solver !== variant.solver[0]) || variant.solver[0] !== variants[0].solver[0])) colours.push(["solver", "solver"]);
    if (Math.max(...variants[0].species) > 0) colours.push(["species", "species"]);
    const views = [["zy", "z to the right, y up"], ["xy", "x to the right, y up"], ["xz", "x to the right, z up"], ["3d", "in three dimensions"]];
    const controls = make("div", { class: "controls" }, play, slow, whole);
    // a recording of one impact is completely in slow motion
    slow.hidden = scene.magnified;
    if (colours.length > 1) {
      controls.append(choice("colour by", colours, (colour) => {
        state.colour = colour;
        settle();
      }));
    }
    if (!scene.magnified) {
      const view = choice("view", views, (view) => {
        state.view = view;
        settle();
      });
      view.querySelector("select").value = state.view;
      controls.append(view);
    }
    if (scene.along) {
      const box = make("input", { type: "checkbox", checked: "" });
      box.addEventListener("change", () => {
        scene.along = box.checked;
        draw();
      });
      controls.append(make("label", {}, box, " move along with the flow"));
    }
    const time = make("div", { class: "controls" }, make("label", { class: "time" }, "time ", slider), clock);
    section.querySelector(".panels").before(controls);
    section.querySelector(".panels").after(time, legend, said);

    // Updates the range of the colours and the legend after the reader has chosen a view or a colour.
    function settle() {
      let [low, high] = [Infinity, -Infinity];
      for (const panel of panels) {
        const of = sceneOf(scene, panel.variant);
        const times = Array.from({ length: SAMPLES }, (_, k) => (k / (SAMPLES - 1)) * panel.variant.last);
        const frames = state.colour === "overlap" ? [] : times.map((time) => frameAt(scene, panel.variant, time, blank(panel.variant)));
        const range = state.colour === "overlap" ? [0, panel.variant.deepest / (2 * Math.min(...of.radius))] : diptych.range(of, frames, state.colour);
        [low, high] = [Math.min(low, range[0]), Math.max(high, range[1])];
        panel.canvas.style.aspectRatio = String(Math.min(Math.max(diptych.aspect(scene, state.view), 0.75), 2.6));
      }
      state.range = [low, high];
      legend.replaceChildren(diptych.legend(sceneOf(scene, panels[0].variant), state.colour, state.range));
      draw();
    }

    function describe(panel) {
      const { variant, frame } = panel;
      if (state.time > variant.last) return `stopped at ${diptych.si(variant.last, "s")}: ${variant.stopped || "its recording ends here"}`;
      if (!variant.overlap) return "no lasting contact recorded";
      let [touching, deepest] = [0, 0];
      frame.overlap.forEach((overlap, k) => {
        touching += Number(overlap > 0);
        deepest = Math.max(deepest, overlap / (2 * variant.radius[k]));
      });
      return touching ? `${touching} in contact, deepest overlap ${(100 * deepest).toPrecision(2)} % of the diameter` : "none in contact";
    }

    function draw() {
      for (const panel of panels) {
        const { variant, canvas, frame } = panel;
        frameAt(scene, variant, state.time, frame);
        const options = { view: state.view, colour: state.colour, range: state.range };
        if (state.focus !== null && state.focus < variant.count) {
          const centre = [0, 1, 2].map((axis) => frame.position[3 * state.focus + axis]);
          options.mark = state.focus;
          options.focus = { centre, width: WIDE * 2 * variant.radius[state.focus] };
        }
        diptych.drawScene(canvas, sceneOf(scene, variant), frame, options);
      }
      // texts are changed after all panels are drawn, because a changed text makes the browser lay out the page again
      for (const panel of panels) {
        const words = describe(panel);
        if (panel.words.textContent !== words) panel.words.textContent = words;
        panel.canvas.setAttribute("aria-label", `${panel.variant.name}: ${panel.variant.count} spheres at ${diptych.si(state.time, "s")}; ${words}`);
      }
      slider.value = String(Math.round((1000 * state.time) / end));
      slider.setAttribute("aria-valuetext", diptych.si(state.time, "s"));
      clock.textContent = `t = ${diptych.si(state.time, "s", 4)} of ${diptych.si(end, "s", 4)}`;
    }

    function stop() {
      state.playing = false;
      play.textContent = "Play";
      said.textContent = panels.map((panel) => panel.canvas.getAttribute("aria-label")).join(". ");
    }

    function advance(now) {
      if (!state.playing) return;
      const wait = still.matches ? 700 : 0;
      const gone = Math.min(now - state.before, wait + 100);
      if (gone >= wait) {
        state.before = now;
        state.time += still.matches ? (WHOLE / STEPS) * state.pace : (gone / 1000) * state.pace;
        if (state.time >= state.until) {
          state.time = state.until;
          stop();
        }
        draw();
      }
      requestAnimationFrame(advance);
    }

    function start() {
      state.playing = true;
      play.textContent = "Pause";
      state.before = performance.now();
      requestAnimationFrame(advance);
    }

    play.addEventListener("click", () => {
      if (state.playing) return stop();
      [state.pace, state.until] = [end / WHOLE, end];
      if (state.time >= end) state.time = 0;
      start();
    });
    slow.addEventListener("click", () => {
      const shown = panels.map((panel) => panel.variant);
      const found = contact(scene, shown, state.time) || contact(scene, shown, 0);
      if (!found) return void (said.textContent = "Nothing is struck in this recording.");
      const long = found.to - found.from;
      state.focus = found.particle;
      [state.time, state.until, state.pace] = [Math.max(found.from - 0.4 * long, 0), Math.min(found.to + 0.4 * long, end), long / CLOSE];
      whole.hidden = false;
      start();
    });
    whole.addEventListener("click", () => {
      state.focus = null;
      whole.hidden = true;
      play.focus();
      draw();
    });
    slider.addEventListener("input", () => {
      stop();
      state.time = (Number(slider.value) / 1000) * end;
      draw();
    });
    section.addEventListener("keydown", (event) => {
      if (event.target.tagName !== "CANVAS") return;
      if (event.key === " ") play.click();
      else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
        stop();
        state.time = Math.min(Math.max(state.time + (event.key === "ArrowLeft" ? -1 : 1) * (end / 200), 0), end);
        draw();
      } else return;
      event.preventDefault();
    });
    new ResizeObserver(() => draw()).observe(section);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());
    settle();
  }

  document.querySelectorAll("section.player").forEach(player);
  // the hidden parts of the page are opened for printing
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((part) => part.setAttribute("open", "")));
})();
