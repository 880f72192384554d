// Numbers of the particles in a frame (data of one instant, from which the page draws its panels).

export const COLUMNS = 6; // x, y, z, speed, overlap, radius

// Arrays of one panel, one for each quantity. `values` has the six numbers of the first particle, then those of the
// next. The speed is stored as the x component of the velocity.
export function panel(values) {
  const count = values.length / COLUMNS;
  const [position, velocity] = [new Float32Array(3 * count), new Float32Array(3 * count)];
  const [overlap, radius] = [new Float32Array(count), new Float32Array(count)];
  for (let k = 0; k < count; k++) {
    position.set(values.subarray(COLUMNS * k, COLUMNS * k + 3), 3 * k);
    velocity[3 * k] = values[COLUMNS * k + 3];
    overlap[k] = values[COLUMNS * k + 4];
    radius[k] = values[COLUMNS * k + 5];
  }
  return { position, velocity, overlap, radius };
}
