// Sliders and choices of a scene.

import { number } from "./words.js";

const STEPS = 120; // of a slider that goes by factors

function element(name, properties, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

// Between places of a slider and values.
function scale({ least, most, logarithmic, whole }) {
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

// One knob; `turned(name, value)` is called when it is moved.
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
  if (words) {
    input = element("select", { id }, ...words.map(([value, text]) => element("option", { value, textContent: text })));
    input.value = shown.value;
    input.addEventListener("change", () => {
      say(input.value);
      turned(shown.name, input.value);
    });
  } else {
    const along = scale(shown.kind.number);
    input = element("input", { id, type: "range", min: along.min, max: along.max, step: along.step });
    input.value = along.place(shown.value);
    const home = along.place(shown.default);
    input.addEventListener("input", () => {
      const place = Number(input.value);
      const value = place === home ? shown.default : Math.min(Math.max(along.value(place), shown.kind.number.least), shown.kind.number.most);
      input.setAttribute("aria-valuetext", say(value));
      turned(shown.name, value);
    });
    input.setAttribute("aria-valuetext", `${number(shown.value)} ${shown.unit}`.trim());
  }
  input.setAttribute("aria-describedby", help.id);
  say(shown.value);
  box.append(input, help);
  return box;
}

// All knobs of a scene.
export function knobs(parent, list, turned) {
  parent.replaceChildren(...list.map((shown) => knob(shown, turned)));
}
