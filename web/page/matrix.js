/* Matrices of 16 numbers, column-major, in double precision. */

export const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

export function multiply(a, b) {
  const product = new Array(16);
  for (let column = 0; column < 4; column++)
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
      product[4 * column + row] = sum;
    }
  return product;
}

export const upper = (m) => [m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]];

/* Of 3x3 matrices. */
export function multiply3(a, b) {
  const product = new Array(9);
  for (let column = 0; column < 3; column++)
    for (let row = 0; row < 3; row++) product[3 * column + row] = a[row] * b[3 * column] + a[3 + row] * b[3 * column + 1] + a[6 + row] * b[3 * column + 2];
  return product;
}

export const apply3 = (m, v) => [0, 1, 2].map((row) => m[row] * v[0] + m[3 + row] * v[1] + m[6 + row] * v[2]);
export const point = (m, p) => [0, 1, 2].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);

export const scaling = (x, y, z) => [x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1];
export const translation = (x, y, z) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (v) => Math.hypot(v[0], v[1], v[2]);
export const unit = (v) => { const l = length(v); return l > 0 ? v.map((x) => x / l) : v; };
export const degreesBetween = (a, b) => (Math.atan2(length(cross(a, b)), dot(a, b)) * 180) / Math.PI;

/* Whether a part of the ball round the origin may be in the picture. m: from where it lies to the picture's clip space. */
export const meetsPicture = (m) => [0, 1, 2].every((row) => [1, -1].every((sign) => {
  const plane = [3, 7, 11, 15].map((w) => m[w] + sign * m[w - 3 + row]);
  return !(plane[3] < -length(plane));
}));

/* The inverse of an affine matrix; null where it has none. */
export function invert(m) {
  const [a, b, c] = [m.slice(0, 3), m.slice(4, 7), m.slice(8, 11)];
  const bc = cross(b, c), ca = cross(c, a), ab = cross(a, b), determinant = dot(a, bc);
  if (!(Math.abs(determinant) > 0) || !isFinite(1 / determinant)) return null;
  const rows = [bc, ca, ab].map((row) => row.map((x) => x / determinant)), t = m.slice(12, 15);
  return [rows[0][0], rows[1][0], rows[2][0], 0, rows[0][1], rows[1][1], rows[2][1], 0, rows[0][2], rows[1][2], rows[2][2], 0, -dot(rows[0], t), -dot(rows[1], t), -dot(rows[2], t), 1];
}
