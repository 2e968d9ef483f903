"use strict";
/** The view of the unit sphere: parallel projection from a direction, in pixels of the stage. */
Explore.camera = (() => {
  const { dot, plus, scaled } = Explore.vectors;
  const HIGHEST = 1.5;

  /** Camera for a view { azimuth, elevation } and a picture, of which half is so many radii of the sphere. */
  function make({ azimuth: a, elevation: e }, width, height, half) {
    const right = [-Math.sin(a), Math.cos(a), 0];
    const up = [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)];
    const front = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    const radius = Math.min(width, height) / (2 * half);
    const place = (point) => [width / 2 + radius * dot(point, right), height / 2 - radius * dot(point, up)];
    return {
      right, up, front, radius, width, height, half, place,
      depth: (point) => dot(point, front),
      /** Point of the sphere at a place, on the near or the far half; the nearest one of the rim outside. */
      onSphere([x, y], near) {
        let [u, v] = [(x - width / 2) / radius, (height / 2 - y) / radius];
        const r = Math.hypot(u, v);
        const outside = r > 1;
        if (outside) [u, v] = [u / r, v / r];
        const depth = (near ? 1 : -1) * Math.sqrt(Math.max(0, 1 - u * u - v * v));
        return { point: plus(plus(scaled(right, u), up, v), front, depth), outside };
      },
    };
  }

  /** Turn the view; says whether it met its limit above a pole. */
  function turn(view, azimuth, elevation) {
    const wanted = view.elevation + elevation;
    view.azimuth += azimuth;
    view.elevation = Explore.vectors.clamped(wanted, -HIGHEST, HIGHEST);
    return view.elevation !== wanted;
  }

  return { make, turn };
})();
