"use strict";
/** Curves as they were sampled: columns as paths, and the frame at a time between the samples. */
Explore.samples = (() => {
  const { dot, cross, plus, scaled, unit, length, rotated, between } = Explore.vectors;

  const row = (points, index, columns, j) => [0, 1, 2].map((i) => points[(index * 3 + i) * columns + j]);

  const read = (points, columns) => Array.from({ length: columns }, (_, j) =>
    Array.from({ length: points.length / (3 * columns) }, (__, index) => row(points, index, columns, j)));

  /** Columns of a curve as paths on the sphere. */
  function paths(curve, columns) {
    curve.paths ??= read(curve.points, columns);
    return curve.paths;
  }

  /** A tangent vector carried along a path without turning: by the least rotation from each sample to the next. */
  function carried(path) {
    const first = path.find((point, i) => i > 0 && length(plus(point, path[0], -1)) > 1e-4);
    let vector = first ? plus(first, path[0], -dot(first, path[0])) : cross(path[0], [0.3, 0.2, 0.9]);
    vector = unit(vector);
    return path.map((point, i) => {
      if (i > 0) vector = rotated(between(path[i - 1], point), vector);
      return vector;
    });
  }

  /** Index of the last sample that is not later, and how far the time is towards the next one. */
  function locate(t, time) {
    let [low, high] = [0, t.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle;
      else high = middle;
    }
    const step = t[high] - t[low];
    return { index: low, part: step > 0 ? Explore.vectors.clamped((time - t[low]) / step, 0, 1) : 0 };
  }

  const mixed = (path, { index, part }) =>
    plus(scaled(path[index], 1 - part), path[Math.min(index + 1, path.length - 1)], part);

  /** Axes of the moving frame: of frames their own; of points a carried tangent vector, its neighbour, the normal. */
  function axes(curve, columns, t, time) {
    const at = locate(t, time);
    const all = paths(curve, columns);
    if (columns === 1) {
      curve.carried ??= carried(all[0]);
      const normal = unit(mixed(all[0], at));
      const tangent = mixed(curve.carried, at);
      const x = unit(plus(tangent, normal, -dot(tangent, normal)));
      return [x, cross(normal, x), normal];
    }
    const x = unit(mixed(all[0], at));
    const second = mixed(all[1], at);
    const y = unit(plus(second, x, -dot(second, x)));
    return [x, y, cross(x, y)];
  }

  return { read, paths, locate, axes };
})();
