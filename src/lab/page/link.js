// The line to the program: what is asked goes as JSON, frames come as bytes (src/lab/frame.rs).

const COLUMNS = 5; // x, y, z, speed, overlap

// Splits a frame into its head and the numbers of both panels; `counts`: particles of each.
export function unpack(buffer, counts) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let at = 4 + length;
  const panels = counts.map((count) => {
    const values = new Float32Array(buffer, at, COLUMNS * count);
    at += 4 * values.length;
    const [position, velocity, overlap] = [new Float32Array(3 * count), new Float32Array(3 * count), new Float32Array(count)];
    for (let k = 0; k < count; k++) {
      position.set(values.subarray(COLUMNS * k, COLUMNS * k + 3), 3 * k);
      velocity[3 * k] = values[COLUMNS * k + 3];
      overlap[k] = values[COLUMNS * k + 4];
    }
    return { position, velocity, overlap };
  });
  return { head, panels };
}

// Opens the line. `on` has `told`, `framed` and `closed`.
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
