"use strict";
/** Vectors of three entries, and rotations as unit quaternions [x, y, z, w]. */
Explore.vectors = (() => {
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const scaled = (a, s) => a.map((x) => s * x);
  /** a + s b */
  const plus = (a, b, s = 1) => a.map((x, i) => x + s * b[i]);
  const length = (a) => Math.hypot(...a);
  const unit = (a) => scaled(a, 1 / length(a));
  const clamped = (x, least, most) => Math.min(most, Math.max(least, x));

  /** The rotation by q after that by p. */
  function composed(q, p) {
    const [v, w] = [q.slice(0, 3), p.slice(0, 3)];
    const vector = plus(plus(cross(v, w), w, q[3]), v, p[3]);
    return unit([...vector, q[3] * p[3] - dot(v, w)]);
  }

  /** Rotation about a unit axis. */
  const turn = (axis, angle) => [...scaled(axis, Math.sin(angle / 2)), Math.cos(angle / 2)];

  function rotated([x, y, z, w], a) {
    const twice = scaled(cross([x, y, z], a), 2);
    return plus(plus(a, twice, w), cross([x, y, z], twice));
  }

  /** Images of the three axes. */
  const axesOf = (q) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => rotated(q, axis));

  /** The least rotation that takes one unit vector to another. */
  function between(a, b) {
    const half = plus(a, b);
    if (length(half) < 1e-6) return turn(unit(cross(a, Math.abs(a[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0])), Math.PI);
    const middle = unit(half);
    return unit([...cross(a, middle), dot(a, middle)]);
  }

  /** Quaternion of the rotation with these images of the axes. */
  function ofAxes([a, b, c]) {
    const trace = a[0] + b[1] + c[2];
    const squares = [1 + 2 * a[0] - trace, 1 + 2 * b[1] - trace, 1 + 2 * c[2] - trace, 1 + trace];
    const largest = squares.indexOf(Math.max(...squares));
    const [xy, xz, yz] = [a[1] + b[0], a[2] + c[0], b[2] + c[1]];
    const [wx, wy, wz] = [b[2] - c[1], c[0] - a[2], a[1] - b[0]];
    return unit([
      [squares[0], xy, xz, wx],
      [xy, squares[1], yz, wy],
      [xz, yz, squares[2], wz],
      [wx, wy, wz, squares[3]],
    ][largest]);
  }

  return { dot, cross, scaled, plus, length, unit, clamped, composed, turn, rotated, axesOf, between, ofAxes };
})();
