// The numbers of particles in a frame.

export const COLUMNS = 6; // x, y, z, speed, overlap, radius

// The numbers of one panel by what they are; `values` has the columns of one particle after the other.
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
