"use strict";
/** Lines on the unit sphere, and what of them is seen on the near and on the far half. */
Explore.paths = (() => {
  const { dot, plus, length, unit, clamped } = Explore.vectors;
  // Longest chord of a curve that is drawn, in radii of the sphere. A server sends points as close; grids are coarser.
  const CHORD = 0.05;

  function circle(centre, u, v) {
    return Array.from({ length: 121 }, (_, i) => {
      const angle = (i * Math.PI) / 60;
      return centre.map((c, j) => c + Math.cos(angle) * u[j] + Math.sin(angle) * v[j]);
    });
  }

  const radians = (degrees) => (degrees * Math.PI) / 180;

  const GRID_LINES = [
    ...[-60, -30, 0, 30, 60].map((degrees) => {
      const [c, s] = [Math.cos(radians(degrees)), Math.sin(radians(degrees))];
      return circle([0, 0, s], [c, 0, 0], [0, c, 0]);
    }),
    ...[0, 30, 60, 90, 120, 150].map((degrees) => {
      const [c, s] = [Math.cos(radians(degrees)), Math.sin(radians(degrees))];
      return circle([0, 0, 0], [c, s, 0], [0, 0, 1]);
    }),
  ];

  /** Where a chord crosses the rim, from the depths of its ends. */
  function rim(p, q, before, depth) {
    const crossing = p.map((x, i) => x + (before / (before - depth)) * (q[i] - x));
    const length = Math.hypot(...crossing);
    return crossing.map((x) => x / length);
  }

  /** Flat coordinates of what is on one half, up to the rim, as pieces of connected points. */
  function half(paths, view, near) {
    const pieces = [];
    let piece = [];
    const close = () => {
      if (piece.length) pieces.push(piece);
      piece = [];
    };
    const add = (point) => piece.push([dot(point, view.right), dot(point, view.up)]);
    for (const path of paths) {
      const depths = path.map((point) => dot(point, view.front));
      path.forEach((point, i) => {
        const here = depths[i] >= 0 === near;
        if (i > 0 && depths[i - 1] >= 0 !== depths[i] >= 0) {
          add(rim(path[i - 1], point, depths[i - 1], depths[i]));
          if (!here) close();
        }
        if (here) add(point);
      });
      close();
    }
    return pieces;
  }

  /** How many pieces a chord of these paths needs, so that none is too long. */
  function pieces(paths) {
    const chords = paths.flatMap((path) => path.slice(1).map((q, i) => length(plus(q, path[i], -1))));
    const longest = Math.max(...chords);
    return longest > CHORD ? Math.ceil(longest / (0.8 * CHORD)) : 1;
  }

  /** A path with `count` pieces for each of its chords: by polynomials through four of its points. */
  function fine(path, count) {
    return Array.from({ length: (path.length - 1) * count + 1 }, (_, index) => {
      const first = clamped(Math.floor(index / count) - 1, 0, path.length - 4);
      const x = index / count - first;
      const weights = [0, 1, 2, 3].map((k) =>
        [0, 1, 2, 3].reduce((w, l) => (l === k ? w : (w * (x - l)) / (k - l)), 1));
      return unit([0, 1, 2].map((i) => weights.reduce((sum, w, k) => sum + w * path[first + k][i], 0)));
    });
  }

  return { circle, GRID_LINES, half, pieces, fine };
})();
