// Controls of a scene: sliders and lists of choices for its parameters.

import { number } from "./words.js";

const STEPS = 120; // number of steps of a logarithmic slider

function element(name, properties, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

// Conversion between positions of a slider and values of its parameter. On a page with recorded runs, `stops` are the
// recorded values, and the slider has one position for each of them.
function scale({ number, stops }) {
  if (stops) return { min: 0, max: stops.length - 1, step: 1, value: (place) => stops[place], place: (value) => stops.indexOf(value) };
  const { least, most, logarithmic, whole } = number;
  if (logarithmic) {
    const factor = Math.log(most / least);
    return {
      min: 0, max: STEPS, step: 1,
      value: (place) => Number((least * Math.exp((factor * place) / STEPS)).toPrecision(3)),
      place: (value) => Math.round((STEPS * Math.log(value / least)) / factor),
    };
  }
  const step = whole ? 1 : 0.01;
  return { min: least, max: most, step, value: Number, place: (value) => value };
}

// Creates the control (knob) of one parameter. The function `turned(name, value)` is called when the user moves it.
function knob(shown, turned) {
  const id = `knob-${shown.name}`;
  const label = element("label", { htmlFor: id, textContent: shown.label });
  const output = element("output", {});
  output.setAttribute("for", id);
  const help = element("small", { id: `${id}-help`, textContent: shown.help });
  const box = element("div", { className: "knob" }, label, output);
  const words = shown.kind.words;
  const say = (value) => {
    const text = words ? "" : `${number(value)} ${shown.unit}`.trim();
    output.textContent = text;
    box.classList.toggle("changed", value !== shown.default);
    return text;
  };
  let input;
  let place = (value) => value;
  if (words) {
    input = element("select", { id }, ...words.map(([value, text]) => element("option", { value, textContent: text })));
    input.value = shown.value;
    input.addEventListener("change", () => {
      say(input.value);
      turned(shown.name, input.value);
    });
  } else {
    const along = scale(shown.kind);
    const clamped = (value) => (shown.kind.number ? Math.min(Math.max(value, shown.kind.number.least), shown.kind.number.most) : value);
    input = element("input", { id, type: "range", min: along.min, max: along.max, step: along.step });
    input.value = along.place(shown.value);
    const home = along.place(shown.default);
    input.addEventListener("input", () => {
      const place = Number(input.value);
      const value = place === home ? shown.default : clamped(along.value(place));
      input.setAttribute("aria-valuetext", say(value));
      turned(shown.name, value);
    });
    input.setAttribute("aria-valuetext", `${number(shown.value)} ${shown.unit}`.trim());
    place = along.place;
  }
  input.setAttribute("aria-describedby", help.id);
  say(shown.value);
  box.append(input, help);
  const set = (value) => {
    input.value = place(value);
    say(value);
  };
  return { box, set };
}

// Creates the controls (knobs) of all parameters of a scene. Returns a function that sets the control with a given name
// to a given value.
export function knobs(parent, list, turned) {
  const made = list.map((shown) => knob(shown, turned));
  parent.replaceChildren(...made.map(({ box }) => box));
  return (name, value) => made[list.findIndex((shown) => shown.name === name)].set(value);
}
