// Page of the lab: opens scenes, sends the settings of the user to the program, and draws the frames that arrive.

import { knobs } from "./controls.js";
import { Graph } from "./graph.js";
import { connect, unpack } from "./link.js";
import { Profiles } from "./profiles.js";
import { Stage } from "./stage.js";
import { number, si } from "./words.js";

const THROTTLE = 120; // [ms] between two choices that are sent while a slider moves
const GRAPHS = 150; // [ms] between two drawings of the curves

const at = (id) => document.getElementById(id);
const state = {
  scenes: [], opened: null, stage: null, graphs: [], profiles: null, settings: {}, right: 0, serial: 0, playing: true, pace: 1,
  frame: null, waiting: false, over: false, graphed: 0, drawn: 0,
};

// ---- requests to the program

let ask = () => {};
let pending = null;
let sent = 0;

function open() {
  state.serial += 1;
  const choice = { ask: "open", scene: state.scene, settings: state.settings, right: state.right, serial: state.serial };
  clearTimeout(pending);
  pending = setTimeout(() => {
    sent = performance.now();
    ask(choice);
  }, Math.max(0, sent + THROTTLE - performance.now()));
}

// Shows a sentence above the panels; `alarm` is true if something went wrong.
function say(words, alarm = false) {
  at("status").textContent = words;
  at("status").classList.toggle("alarm", alarm);
}

function choose(name) {
  const known = state.scenes.some((scene) => scene.name === name) ? name : state.scenes[0].name;
  Object.assign(state, { scene: known, settings: {}, right: 0 });
  say("");
  open();
}

function play(on) {
  state.playing = on;
  button();
  ask({ ask: "play", on });
}

// Updates the text of the first button, which names the effect of a click.
function button() {
  at("play").textContent = state.over ? "Play again" : state.playing ? "Pause" : "Play";
}

// ---- messages from the program

function told(message) {
  if (message.tell === "scenes") {
    state.scenes = message.scenes;
    at("version").textContent = message.recorded
      ? `Recorded with diptych ${message.version}. The runs of this page are recorded, one setting at a time, and need no program.`
      : `diptych ${message.version}. Everything on this page is computed by the program that serves it, on this machine.`;
    at("scenes").replaceChildren(
      ...message.scenes.map(({ name, title }) => {
        const item = document.createElement("li");
        item.append(Object.assign(document.createElement("a"), { href: `#${name}`, textContent: title }));
        return item;
      }),
    );
    choose(location.hash.slice(1));
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) state.stand = true;
  } else if (message.tell === "refused") {
    if (message.serial === state.serial) say(`This cannot be run: ${message.why}`, true);
  } else if (message.tell === "opened") {
    opened(message);
  }
}

function opened(message) {
  const fresh = state.opened?.scene !== message.scene;
  state.opened = message;
  state.stage = new Stage(message);
  state.over = false;
  state.frame = null;
  button();
  say(message.warnings.map((words) => `Note: ${words}.`).join(" "), message.warnings.length > 0);
  if (fresh) words(message);
  if (message.recorded) {
    // recorded runs differ from the case by one setting, so all other settings return to those of the case
    Object.assign(state, { settings: { ...message.recorded }, right: message.right });
    at("right").value = message.right;
    message.knobs.forEach((knob) => state.set(knob.name, knob.value));
  }
  at("commands").textContent = [message.command, ...message.sides.map((side) => side.command)].join("\n\n");
  const address = URL.createObjectURL(new Blob([message.case], { type: "application/toml" }));
  if (state.address) URL.revokeObjectURL(state.address);
  state.address = address;
  Object.assign(at("download"), { href: address, download: `lab-${message.scene}.toml` });
  pictures(message);
  if (state.stand) {
    state.stand = false;
    play(false);
  }
}

// Shows the texts of a scene, which do not depend on its settings.
function words(message) {
  document.title = `${message.title} · Diptych lab`;
  at("title").textContent = message.title;
  at("sentences").textContent = message.sentences.join(" ");
  for (const part of ["equation", "symbols", "question", "answer"]) at(part).textContent = message[part];
  at("answer").closest("details").open = false;
  for (const link of at("scenes").querySelectorAll("a")) {
    if (link.hash === `#${message.scene}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  at("right").replaceChildren(...message.rights.map((title, value) => Object.assign(document.createElement("option"), { value, textContent: title })));
  at("right").value = message.right;
  at("right").disabled = message.rights.length < 2;
  at("rights-note").hidden = !message.rights.includes("hybrid");
  show(message.knobs);
  pace();
}

function show(list) {
  state.set = knobs(at("knobs"), list, (name, value) => {
    const shown = list.find((knob) => knob.name === name);
    if (value === shown.default) delete state.settings[name];
    else state.settings[name] = value;
    open();
  });
}

function pictures(message) {
  const parent = at("graphs");
  parent.replaceChildren();
  const units = [["[µs]", 1e6], ["[ms]", 1e3]];
  const unit = (graph) => units.find(([name]) => graph.x[1].includes(name))?.[1] ?? 1;
  state.graphs = message.graphs.map((graph) => new Graph(graph, message.duration * unit(graph), parent));
  state.profiles = message.scene === "channel" ? new Profiles(parent) : null;
  at("verdict").hidden = !state.profiles;
  at("verdict").querySelector("p").textContent = "Nothing has been averaged yet.";
  const theory = message.graphs.find((graph) => graph.theory)?.theory[0];
  const key = (style, text) => {
    const box = document.createElement("span");
    box.className = "key graph";
    box.innerHTML = `<svg viewBox="0 0 32 10" aria-hidden="true" class="themed"><path class="${style}" d="M0 5H32"></path></svg>`;
    box.append(text);
    return box;
  };
  const many = message.graphs.some((graph) => graph.columns.length > 1);
  at("lines").replaceChildren(
    key(`line ${many ? "ink" : "s1"}`, `left: ${message.sides[0].title}`),
    key(`line right ${many ? "ink" : "s2"}`, `right: ${message.sides[1].title}`),
    ...(theory ? [key("theory", theory)] : []),
    ...(many ? ["one colour for each sphere"] : []),
  );
}

// ---- frames

function framed(buffer) {
  const frame = state.opened && unpack(buffer);
  if (!frame || frame.head.serial !== state.opened.serial) {
    ask({ ask: "drawn" });
    return;
  }
  frame.head.sides.forEach((side, k) => state.graphs.forEach((graph) => graph.add(k, side.rows)));
  if (frame.head.judged) judged(frame.head.judged);
  state.frame = frame;
  if (!state.waiting) {
    state.waiting = true;
    requestAnimationFrame(draw);
  } else {
    ask({ ask: "drawn" });
  }
}

function draw(now) {
  state.waiting = false;
  const { frame, stage } = state;
  if (!frame) {
    // the user has opened another scene in the meantime
    ask({ ask: "drawn" });
    return;
  }
  stage.draw(frame, at("colour").value);
  const over = frame.head.sides.every((side) => side.state !== "running");
  if (over || now - state.graphed > GRAPHS || frame.head.sides.every((side) => side.time === 0)) {
    state.graphs.forEach((graph) => graph.draw());
    state.graphed = now;
  }
  if (over && !state.over) {
    state.over = true;
    button();
    const failed = frame.head.sides.some((side) => side.failure);
    say(failed ? "The scene has stopped: see below the panels." : "The scene is over.", failed);
  }
  state.drawn += 1;
  // the tests of the page read these values
  Object.assign(document.documentElement.dataset, { drawn: state.drawn, scene: state.opened.scene, serial: frame.head.serial, time: frame.head.sides[0].time, over });
  ask({ ask: "drawn" });
}

function judged(verdict) {
  const words = { equivalent: "Equivalent so far", different: "Different", unresolved: "Unresolved so far" };
  const box = at("verdict").querySelector("p");
  box.textContent = `${words[verdict.answer] ?? verdict.answer}. ${verdict.sentence} Averages are taken from ${si(verdict.from, "s")} on. The margin is wide because the spheres are few.`;
  state.profiles?.draw(verdict.profiles);
}

// ---- controls

function pace() {
  const slider = at("pace");
  state.pace = 10 ** ((Number(slider.value) - 20) / 20);
  ask({ ask: "pace", factor: state.pace });
  const speed = state.opened ? `${si(state.opened.pace * state.pace, "s")} per second` : "";
  at("pace-value").textContent = speed;
  slider.setAttribute("aria-valuetext", speed);
}

at("pace").value = 20;
at("pace").addEventListener("input", pace);
at("play").addEventListener("click", () => {
  if (state.over) open();
  play(state.over || !state.playing);
});
at("step").addEventListener("click", () => {
  play(false);
  ask({ ask: "step" });
});
at("again").addEventListener("click", open);
at("reset").addEventListener("click", () => {
  state.settings = {};
  show(state.opened.knobs.map((knob) => ({ ...knob, value: knob.default })));
  open();
});
at("right").addEventListener("change", () => {
  state.right = Number(at("right").value);
  open();
});
at("colour").addEventListener("change", () => state.frame && state.stage.draw(state.frame, at("colour").value));
addEventListener("hashchange", () => state.scenes.length && choose(location.hash.slice(1)));
document.addEventListener("visibilitychange", () => ask({ ask: "look", on: !document.hidden }));
addEventListener("resize", () => state.frame && state.stage.draw(state.frame, at("colour").value));

ask = connect({
  told,
  framed,
  closed() {
    say("The lab has ended, or four pages are open already. Start `diptych lab` again and open the address that it prints.", true);
  },
});
