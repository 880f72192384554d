// Connection to the program: requests are sent as JSON, and frames arrive as bytes (src/lab/frame.rs).

import { COLUMNS, panel } from "./frames.js";

// Splits a frame into its head and the numbers of its panels.
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let at = 4 + length;
  const panels = head.counts.map((count) => {
    const values = new Float32Array(buffer, at, COLUMNS * count);
    at += 4 * values.length;
    return panel(values);
  });
  return { head, panels };
}

// Opens the connection. `on` has the functions that are called for a message (`told`), for a frame (`framed`) and at
// the end (`closed`). Returns a function that sends a request.
export function connect(on) {
  const address = new URL("socket", location.href);
  address.protocol = "ws:";
  address.hash = "";
  const socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  socket.addEventListener("message", ({ data }) => (typeof data === "string" ? on.told(JSON.parse(data)) : on.framed(data)));
  socket.addEventListener("close", () => on.closed());
  return (ask) => {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(ask));
  };
}
