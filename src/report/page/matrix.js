// Vectors (3 numbers), rotations (9) and matrices (16), column-major.
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const unit = (a) => scaled(a, 1 / (Math.hypot(...a) || 1));
const mix = (a, b, t) => a.map((v, i) => v + (b[i] - v) * t);

const turned = (r, v) => [0, 1, 2].map((i) => r[i] * v[0] + r[3 + i] * v[1] + r[6 + i] * v[2]);
const chained = (a, b) => [0, 3, 6].flatMap((k) => turned(a, b.slice(k, k + 3)));

// Rotation about a unit axis (Rodrigues).
function about([x, y, z], angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  const d = 1 - c;
  return [
    c + x * x * d, y * x * d + z * s, z * x * d - y * s,
    x * y * d - z * s, c + y * y * d, z * y * d + x * s,
    x * z * d + y * s, y * z * d - x * s, c + z * z * d,
  ];
}

const ofQuaternion = ([w, x, y, z]) => [
  1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
  2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
  2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y),
];

const placed = (r, p) => [r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, p[0], p[1], p[2], 1];

function times(a, b) {
  const out = new Array(16).fill(0);
  for (let c = 0; c < 4; c++) for (let r = 0; r < 4; r++) for (let k = 0; k < 4; k++) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
  return out;
}

function project(m, [x, y, z]) {
  const w = m[3] * x + m[7] * y + m[11] * z + m[15];
  return [0, 1, 2].map((i) => (m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]) / w);
}

const perspective = (tan, aspect, near, far) => [
  1 / (tan * aspect), 0, 0, 0, 0, 1 / tan, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0,
];
