// Draws spheres at one instant on a canvas, for the player of a report and for other pages of this program. No other file is needed. The
// colours are custom properties of the page (style.css), so that they follow the reader's choice of a light or a dark page.
//
//     diptych.drawScene(canvas, scene, frame, options)
//
// scene    data that do not change with time
//   size       [x, y, z] of the box [m]
//   periodic   [x, y, z]: true if the box is periodic along the axis (edges of periodic sides are drawn dashed)
//   radius     one per particle [m]
//   species    one per particle, counted from 0; may be absent
//   names      names of the species; may be absent
//   walls      list of walls, each a flat list of line segments: six numbers [m] each, from x y z to x y z
// frame    data that change with time
//   position   three numbers [m] per particle
//   velocity   three numbers [m/s] per particle; may be absent
//   overlap    one per particle [m], 0 without contact; may be absent
//   spin       magnitude of the spin [rad/s], one per particle; may be absent
//   solver     one per particle: 0 flew straight, 1 in an island, 2 moved together with all others; may be absent
// options  all may be absent
//   view       from diptych.view(): "xy", "zy", … two axes, or "3d"; default "xy"
//   colour     "speed", "overlap", "spin", "solver", "species" or "plain"; default "plain"
//   range      [lowest, highest] of the colour scale, from diptych.range(); give panels that stand side by side the same one
//   focus      { centre: [x, y, z] [m], width [m] }: show this part only; default: the whole box
//   mark       place of a particle that gets a ring around it
//   arrows     list of { from: [x, y, z] [m], to: [x, y, z] [m], kind: 0 …, label }: drawn over the spheres in the colour of that series
//
// It returns { place(x, y, z) → [left, top] in CSS pixels, scale: CSS pixels per metre }.
//
//     diptych.aspect(scene, view)                  → width over height of the box in that view, for the canvas
//     diptych.range(scene, frames, colour)         → range that holds nearly all values of these frames
//     diptych.legend(scene, colour, range)         → an element that explains the colours, in words and with a scale
//     diptych.si(value, unit, digits)              → "24.3 µs"
"use strict";
var diptych = diptych || {};

(() => {
  // Lightness rises evenly from the first to the last, so that the order also reads in grey and with any colour vision.
  const SCALE = [[50, 56, 138], [36, 86, 150], [27, 121, 142], [62, 157, 121], [142, 188, 82], [236, 214, 70]];
  const SOLVERS = ["flew straight", "in an island: may touch within this window", "moved together with all others"];
  const MARGIN = 10; // [px] around the box
  const TOUCH = 1e-9; // overlap over diameter up to which spheres only touch; such small numbers are rounding errors

  // Red, green and blue [r, g, b] of a custom property of the page that is written as #rrggbb.
  const hex = (text) => [1, 3, 5].map((k) => parseInt(text.trim().slice(k, k + 2), 16) || 0);
  const css = (rgb) => `rgb(${rgb.map(Math.round).join(",")})`;
  const mix = (a, b, share) => a.map((part, k) => part + (b[k] - part) * share);

  // Present colours of the page around an element. They are looked up again after a moment, because the reader may change them.
  let [colours, looked, fineness] = [null, -Infinity, 1];
  const MOMENT = 300; // [ms]
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (looked = -Infinity));
  const sprites = new Map();
  function palette(element) {
    if (performance.now() - looked < MOMENT) return colours;
    const style = getComputedStyle(element);
    const of = (name) => hex(style.getPropertyValue(name));
    const series = Array.from({ length: 8 }, (_, k) => of(`--series-${k + 1}`));
    const found = { ink: of("--ink"), muted: of("--muted"), paper: of("--scene"), sphere: of("--sphere"), series };
    // pictures of spheres that were made in other colours, or for another screen, are discarded
    const same = colours && JSON.stringify([colours, fineness]) === JSON.stringify([found, window.devicePixelRatio]);
    if (!same) sprites.clear();
    [colours, looked, fineness] = [found, performance.now(), window.devicePixelRatio];
    return colours;
  }

  // [r, g, b] along the scale, in 40 steps.
  const STEPS = Array.from({ length: 41 }, (_, step) => {
    const at = (step / 40) * (SCALE.length - 1);
    const k = Math.min(Math.floor(at), SCALE.length - 2);
    return mix(SCALE[k], SCALE[k + 1], at - k);
  });

  // Directions of the picture: to the right, up, and towards the reader.
  diptych.view = (name = "xy", turn = 35, tilt = 20) => {
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const axis = (letter) => ["x", "y", "z"].map((other) => Number(other === letter));
    if (name === "3d") {
      const [c, s] = [Math.cos((turn * Math.PI) / 180), Math.sin((turn * Math.PI) / 180)];
      const [ct, st] = [Math.cos((tilt * Math.PI) / 180), Math.sin((tilt * Math.PI) / 180)];
      const right = [c, 0, -s];
      const up = [-s * st, ct, -c * st];
      return { right, up, towards: cross(right, up) };
    }
    const [right, up] = [axis(name[0]), axis(name[1])];
    return { right, up, towards: cross(right, up) };
  };

  // Gives the canvas the resolution of the screen. Returns a drawing context whose lengths are CSS pixels.
  diptych.fit = (canvas) => {
    const fine = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const [w, h] = [Math.max(Math.round(width * fine), 1), Math.max(Math.round(height * fine), 1)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const context = canvas.getContext("2d");
    context.setTransform(fine, 0, 0, fine, 0, 0);
    return { context, width, height };
  };

  // Returns functions that give the position of a point in the picture and the depth of the point, and the scale of the picture.
  function camera(scene, options, width, height) {
    const view = options.view && options.view.right ? options.view : diptych.view(options.view || "xy");
    const along = (direction, x, y, z) => direction[0] * x + direction[1] * y + direction[2] * z;
    let [left, right, low, high, far, near] = [Infinity, -Infinity, Infinity, -Infinity, Infinity, -Infinity];
    for (let k = 0; k < 8; k++) {
      const corner = [k & 1, (k >> 1) & 1, k >> 2].map((side, axis) => side * scene.size[axis]);
      const [h, v, d] = [view.right, view.up, view.towards].map((direction) => along(direction, ...corner));
      [left, right, low, high] = [Math.min(left, h), Math.max(right, h), Math.min(low, v), Math.max(high, v)];
      [far, near] = [Math.min(far, d), Math.max(near, d)];
    }
    let middle = [(left + right) / 2, (low + high) / 2];
    let scale = Math.min((width - 2 * MARGIN) / (right - left), (height - 2 * MARGIN) / (high - low));
    if (options.focus) {
      middle = [view.right, view.up].map((direction) => along(direction, ...options.focus.centre));
      scale = width / options.focus.width;
    }
    const [left0, top0] = [width / 2 - middle[0] * scale, height / 2 + middle[1] * scale];
    const place = (x, y, z) => [left0 + along(view.right, x, y, z) * scale, top0 - along(view.up, x, y, z) * scale];
    // depth of a point: 0 at the far end of the box, 1 at the near end
    const depth = (x, y, z) => (near > far ? (along(view.towards, x, y, z) - far) / (near - far) : 1);
    return { place, depth, scale };
  }

  diptych.aspect = (scene, view) => {
    const { right, up } = view && view.right ? view : diptych.view(view || "xy");
    const reach = (direction) => direction.reduce((sum, part, axis) => sum + Math.abs(part) * scene.size[axis], 0);
    return reach(right) / reach(up);
  };

  function line(context, place, segment, from = 0) {
    context.moveTo(...place(segment[from], segment[from + 1], segment[from + 2]));
    context.lineTo(...place(segment[from + 3], segment[from + 4], segment[from + 5]));
  }

  // Draws the edges of the box (those of periodic sides dashed) and the outlines of the walls.
  function drawFrame(context, place, scene, colours) {
    const corner = (k) => [k & 1, (k >> 1) & 1, k >> 2].map((side, axis) => side * scene.size[axis]);
    context.strokeStyle = css(mix(colours.paper, colours.muted, 0.6));
    for (const dashed of [false, true]) {
      context.setLineDash(dashed ? [3, 4] : []);
      context.lineWidth = 1;
      context.beginPath();
      for (let axis = 0; axis < 3; axis++) {
        const others = [0, 1, 2].filter((other) => other !== axis);
        const open = others.some((other) => scene.periodic && scene.periodic[other]);
        for (let k = 0; k < 8 && open === dashed; k++) {
          if (!((k >> axis) & 1)) line(context, place, [...corner(k), ...corner(k | (1 << axis))]);
        }
      }
      context.stroke();
    }
    context.setLineDash([]);
    context.strokeStyle = css(colours.ink);
    for (const wall of scene.walls || []) {
      // a wall of many segments is a curved or finely divided surface, and gets thin lines
      context.lineWidth = wall.length > 6 * 24 ? 0.8 : 2;
      context.beginPath();
      for (let k = 0; k + 5 < wall.length; k += 6) line(context, place, wall, k);
      context.stroke();
    }
  }

  // Value by which a particle is coloured, in the unit of the legend; null without a value.
  function value(scene, frame, colour, k) {
    if (colour === "speed" && frame.velocity) {
      return Math.hypot(frame.velocity[3 * k], frame.velocity[3 * k + 1], frame.velocity[3 * k + 2]);
    }
    if (colour === "overlap" && frame.overlap) {
      const share = frame.overlap[k] / (2 * scene.radius[k]);
      return share > TOUCH ? share : null;
    }
    if (colour === "spin" && frame.spin) return frame.spin[k];
    if (colour === "solver" && frame.solver) return frame.solver[k];
    if (colour === "species" && scene.species) return scene.species[k];
    return null;
  }

  const isScale = (colour) => colour === "speed" || colour === "overlap" || colour === "spin";

  // Numbers of colours: 0 … 40 are those of the scale, 41 is that of a particle that has no value or flew straight, 42 … 49 are those of series.
  const NOTHING = 41;
  function colourOf(found, colour, range) {
    if (found === null || (colour === "solver" && found === 0)) return NOTHING;
    if (!isScale(colour)) return NOTHING + 1 + (found % 8);
    const share = range[1] > range[0] ? (found - range[0]) / (range[1] - range[0]) : 0.5;
    return Math.round(40 * Math.min(Math.max(share, 0), 1));
  }
  const rgb = (number, colours) => (number < NOTHING ? STEPS[number] : number === NOTHING ? colours.sphere : colours.series[number - NOTHING - 1]);

  // A small picture of a sphere is made once for each colour and size, because copying it is much faster than drawing a sphere.
  const LARGE = 24; // [px] radius above which a sphere is drawn each time

  function paint(context, x, y, radius, fill, edge) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = css(fill);
    context.fill();
    if (radius <= 2) return;
    context.lineWidth = radius > 8 ? 1 : 0.6;
    context.strokeStyle = css(edge);
    context.stroke();
  }

  // Picture of a sphere (sprite). Fading and size are rounded to steps that are too small to be seen, so that few pictures are needed.
  function sprite(number, fade, radius, fine, colours) {
    const size = Math.round(radius * 2);
    const key = (number * 16 + fade) * 64 + size;
    let made = sprites.get(key);
    if (!made) {
      const edge = Math.ceil((size / 2 + 1) * fine) * 2;
      const canvas = new OffscreenCanvas(edge, edge);
      const context = canvas.getContext("2d");
      context.setTransform(fine, 0, 0, fine, edge / 2, edge / 2);
      paint(context, 0, 0, Math.max(size / 2, 1), faded(number, fade, colours), mix(colours.ink, colours.paper, 0.5));
      made = canvas.transferToImageBitmap();
      sprites.set(key, made);
    }
    return made;
  }

  // The colour of a distant sphere fades towards that of the background.
  const faded = (number, fade, colours) => mix(rgb(number, colours), colours.paper, (0.45 * fade) / 8);

  function drawSpheres(context, camera, scene, frame, options, colours) {
    const { place, depth, scale } = camera;
    const colour = options.colour || "plain";
    const range = options.range || diptych.range(scene, [frame], colour);
    const fine = window.devicePixelRatio || 1;
    const count = scene.radius.length;
    const near = new Float32Array(count);
    for (let k = 0; k < count; k++) near[k] = depth(frame.position[3 * k], frame.position[3 * k + 1], frame.position[3 * k + 2]);
    const order = Uint32Array.from(near.keys()).sort((a, b) => near[a] - near[b] || a - b);
    for (const k of order) {
      const [x, y] = place(frame.position[3 * k], frame.position[3 * k + 1], frame.position[3 * k + 2]);
      const radius = Math.max(scene.radius[k] * scale, 1);
      const fade = count > 20 ? Math.round(8 * (1 - Math.min(Math.max(near[k], 0), 1))) : 0;
      const number = colourOf(value(scene, frame, colour, k), colour, range);
      if (radius > LARGE) {
        paint(context, x, y, radius, faded(number, fade, colours), mix(colours.ink, colours.paper, 0.5));
      } else {
        const made = sprite(number, fade, radius, fine, colours);
        context.drawImage(made, x - made.width / fine / 2, y - made.height / fine / 2, made.width / fine, made.height / fine);
      }
    }
  }

  function drawRing(context, { place, scale }, scene, frame, k, colours) {
    const [x, y] = place(frame.position[3 * k], frame.position[3 * k + 1], frame.position[3 * k + 2]);
    context.beginPath();
    context.arc(x, y, scene.radius[k] * scale + 3, 0, 2 * Math.PI);
    context.strokeStyle = css(colours.ink);
    context.lineWidth = 2;
    context.stroke();
  }

  function drawArrow(context, place, arrow, colours) {
    const [from, to] = [place(...arrow.from), place(...arrow.to)];
    const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
    if (!(length > 1)) return;
    const [dx, dy] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    const head = Math.min(9, length);
    context.strokeStyle = context.fillStyle = css(colours.series[(arrow.kind || 0) % 8]);
    context.lineWidth = 2.5;
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(to[0] - dx * head * 0.7, to[1] - dy * head * 0.7);
    context.stroke();
    context.beginPath();
    context.moveTo(...to);
    context.lineTo(to[0] - dx * head - dy * head * 0.5, to[1] - dy * head + dx * head * 0.5);
    context.lineTo(to[0] - dx * head + dy * head * 0.5, to[1] - dy * head - dx * head * 0.5);
    context.fill();
    if (arrow.label) {
      context.font = "12px Helvetica, Arial, sans-serif";
      context.textAlign = dx < -0.3 ? "right" : "left";
      const at = [to[0] + (dx < -0.3 ? -5 : 5), to[1] - 5];
      // a rim in the colour of the page, so that the words can be read on any sphere
      [context.lineWidth, context.lineJoin] = [4, "round"];
      [context.strokeStyle, context.fillStyle] = [colours.paper, colours.ink].map(css);
      context.strokeText(arrow.label, ...at);
      context.fillText(arrow.label, ...at);
    }
  }

  diptych.drawScene = (canvas, scene, frame, options = {}) => {
    const { context, width, height } = diptych.fit(canvas);
    const colours = palette(canvas);
    const seen = camera(scene, options, width, height);
    context.fillStyle = css(colours.paper);
    context.fillRect(0, 0, width, height);
    drawFrame(context, seen.place, scene, colours);
    drawSpheres(context, seen, scene, frame, options, colours);
    if (options.mark !== undefined) drawRing(context, seen, scene, frame, options.mark, colours);
    for (const arrow of options.arrows || []) drawArrow(context, seen.place, arrow, colours);
    return { place: seen.place, scale: seen.scale };
  };

  diptych.range = (scene, frames, colour) => {
    if (!isScale(colour)) return [0, 1];
    const found = [];
    for (const frame of frames) {
      for (let k = 0; k < scene.radius.length; k++) {
        const one = value(scene, frame, colour, k);
        if (one !== null && Number.isFinite(one)) found.push(one);
      }
    }
    if (found.length === 0) return colour === "overlap" ? [0, 0] : [0, 1];
    found.sort((a, b) => a - b);
    // the fastest and slowest particles are left out, because one particle much faster than all others would take the whole scale
    const highest = found[Math.min(Math.floor(found.length * 0.995), found.length - 1)];
    const lowest = colour === "overlap" ? 0 : found[Math.floor(found.length * 0.005)];
    return highest - lowest > 1e-3 * Math.abs(highest) ? [lowest, highest] : [0, highest || 1];
  };

  diptych.si = (value, unit, digits = 3) => {
    if (!Number.isFinite(value)) return "–";
    const prefixes = [["G", 1e9], ["M", 1e6], ["k", 1e3], ["", 1], ["m", 1e-3], ["µ", 1e-6], ["n", 1e-9], ["p", 1e-12]];
    const size = Math.abs(value);
    // numbers too small for all prefixes get the last prefix
    const [prefix, factor] = prefixes.find(([, factor]) => size >= factor * 0.9995) || prefixes[size > 0 ? 7 : 3];
    const number = value / factor;
    const places = Math.max(digits - 1 - Math.floor(Math.log10(Math.abs(number) || 1)), 0);
    return `${number.toFixed(Math.min(places, 8)).replace("-", "−")} ${prefix}${unit}`.trim();
  };

  const element = (name, className, text) => {
    const made = document.createElement(name);
    if (className) made.className = className;
    if (text) made.textContent = text;
    return made;
  };

  // Makes a patch of colour for the legend: that of a series or, for null, that of particles without a value.
  function patch(series, text) {
    const made = element("span", "scene-key");
    const colour = element("span", "scene-patch");
    colour.style.background = series === null ? "var(--sphere)" : `var(--series-${(series % 8) + 1})`;
    made.append(colour, text);
    return made;
  }

  diptych.legend = (scene, colour, range) => {
    const legend = element("p", "scene-legend");
    if (isScale(colour)) {
      const words = colour === "overlap" ? "overlap over diameter" : colour;
      const unit = colour === "speed" ? "m/s" : "rad/s";
      const share = (number) => (range[1] > TOUCH ? `${Number((100 * number).toPrecision(2))} %` : "–");
      const show = (number) => (colour === "overlap" ? share(number) : diptych.si(number, unit));
      const bar = element("span", "scene-scale");
      bar.style.background = `linear-gradient(to right, ${SCALE.map(css).join(", ")})`;
      legend.append(`${words}: ${show(range[0])} `, bar, ` ${show(range[1])}`);
      if (colour === "overlap") legend.append(patch(null, "no contact"));
    } else if (colour === "solver") {
      SOLVERS.forEach((words, solver) => legend.append(patch(solver === 0 ? null : solver, words)));
    } else if (colour === "species") {
      const count = Math.max(0, ...(scene.species || [])) + 1;
      for (let k = 0; k < count; k++) legend.append(patch(k, (scene.names || [])[k] || `species ${k + 1}`));
    }
    return legend;
  };
})();
