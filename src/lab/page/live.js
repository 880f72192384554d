// Page of the live view of a run: draws the frames that the program sends.

import { Graph } from "./graph.js";
import { connect, unpack } from "./link.js";
import { Stage } from "./stage.js";

const GRAPHS = 150; // [ms] between two drawings of the curves

const at = (id) => document.getElementById(id);
const state = { stage: null, graphs: [], frame: null, waiting: false, graphed: 0, drawn: 0 };
let ask = () => {};

function told(message) {
  document.title = `${message.title} · Diptych run`;
  at("title").textContent = message.title;
  at("version").textContent = `diptych ${message.version}, on this machine.`;
  state.stage = new Stage(message);
  at("graphs").replaceChildren();
  state.graphs = message.graphs.map((graph) => new Graph(graph, message.until, at("graphs")));
}

function framed(buffer) {
  state.frame = unpack(buffer);
  if (state.waiting) return ask({ ask: "drawn" });
  state.waiting = true;
  requestAnimationFrame(draw);
}

function draw(now) {
  state.waiting = false;
  const { frame, stage, graphs } = state;
  const [side] = frame.head.sides;
  stage.draw(frame, at("colour").value);
  at("sentence").textContent = frame.head.sentence;
  at("sentence").hidden = !frame.head.sentence;
  if (side.state === "over" || now - state.graphed > GRAPHS) {
    graphs.forEach((graph) => {
      graph.rows[0] = side.rows;
      graph.draw();
    });
    state.graphed = now;
  }
  if (side.state === "over") at("status").textContent = "The run is over.";
  state.drawn += 1;
  // the tests of the page read these values
  Object.assign(document.documentElement.dataset, { drawn: state.drawn, time: side.time, over: side.state === "over" });
  ask({ ask: "drawn" });
}

const again = () => state.frame && state.stage.draw(state.frame, at("colour").value);
at("colour").addEventListener("change", again);
addEventListener("resize", again);

ask = connect({
  told,
  framed,
  closed() {
    if (at("status").textContent) return;
    at("status").textContent = "The program has ended, or four pages are open already.";
    at("status").classList.add("alarm");
  },
});
