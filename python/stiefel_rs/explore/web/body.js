"use strict";
/** A body that turns about its centre: a spacecraft of flat faces, and its three axes. */
Explore.body = (() => {
  const { dot, cross, plus, scaled, unit } = Explore.vectors;
  const colour = (name) => Explore.theme.colour(name);

  /** Box between two corners, as faces { corners, paint }. */
  function box([x0, y0, z0], [x1, y1, z1], paint) {
    const corner = (i) => [i & 1 ? x1 : x0, i & 2 ? y1 : y0, i & 4 ? z1 : z0];
    const faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    return faces.map((face) => ({ corners: face.map(corner), paint }));
  }

  /** Cone along x with an open or a closed mouth. */
  function cone(from, to, wide, narrow, paint) {
    const sides = 14;
    const ring = (x, r) => Array.from({ length: sides }, (_, i) => {
      const angle = (2 * Math.PI * i) / sides;
      return [x, r * Math.cos(angle), r * Math.sin(angle)];
    });
    const [one, other] = [ring(from, wide), ring(to, narrow)];
    const walls = one.map((_, i) => {
      const next = (i + 1) % sides;
      return { corners: [one[i], one[next], other[next], other[i]], paint };
    });
    return [...walls, { corners: other, paint }, { corners: [...one].reverse(), paint }];
  }

  /** Flat box between two distances along y, which may be negative. */
  const plate = (half, a, b, paint) => box([-half, Math.min(a, b), -0.012], [half, Math.max(a, b), 0.012], paint);

  const panel = (edges) => edges.slice(1).flatMap((edge, i) => plate(0.15, edges[i], edge, "panel"));

  // Convex parts, each beyond one side of the hull: those on sides that point away are painted before it.
  const PARTS = [
    { side: [0, 0, 0], faces: box([-0.2, -0.13, -0.13], [0.2, 0.13, 0.13], "hull") },
    { side: [1, 0, 0], faces: cone(0.2, 0.34, 0.12, 0.035, "nose") },
    { side: [-1, 0, 0], faces: cone(-0.2, -0.27, 0.05, 0.09, "nose") },
    { side: [0, 0, 1], faces: box([-0.05, -0.05, 0.13], [0.05, 0.05, 0.2], "nose") },
    ...[1, -1].map((way) => ({
      side: [0, way, 0],
      faces: [...plate(0.02, 0.13 * way, 0.2 * way, "hull"), ...panel([0.2, 0.327, 0.453, 0.58].map((y) => y * way))],
    })),
  ];

  const REACH = 0.62;
  const moved = (axes, [x, y, z], size) => plus(plus(scaled(axes[0], size * x), axes[1], size * y), axes[2], size * z);

  function seenOf(faces, cam, axes, size) {
    const found = faces.map(({ corners, paint }) => {
      const points = corners.map((point) => moved(axes, point, size));
      const normal = unit(cross(plus(points[1], points[0], -1), plus(points[2], points[0], -1)));
      const centre = scaled(points.reduce((sum, point) => plus(sum, point)), 1 / points.length);
      return { points, normal, depth: dot(centre, cam.front), paint };
    });
    return found.filter(({ normal }) => dot(normal, cam.front) > 0).sort((a, b) => a.depth - b.depth);
  }

  /** Faces that point to the reader, those behind first. */
  function seen(cam, axes, size) {
    const parts = PARTS.map(({ side, faces }) => ({ faces, depth: cam.depth(moved(axes, side, 1)) }));
    return parts.sort((a, b) => a.depth - b.depth).flatMap(({ faces }) => seenOf(faces, cam, axes, size));
  }

  /** Paint of a face in the light, which comes from above on the left of the reader. */
  function shaded(name, normal, cam) {
    const light = unit(plus(plus(scaled(cam.front, 0.75), cam.up, 0.6), cam.right, -0.35));
    const bright = 0.68 + 0.32 * Math.max(0, dot(normal, light));
    const [r, g, b] = colour(name).split(" ").map(Number);
    return `rgb(${[r, g, b].map((x) => Math.round(Math.min(255, x * bright))).join(" ")})`;
  }

  function outline(ctx, cam, points) {
    ctx.beginPath();
    points.forEach((point, i) => (i ? ctx.lineTo(...cam.place(point)) : ctx.moveTo(...cam.place(point))));
    ctx.closePath();
  }

  /** The body itself; a ghost shows its edges alone. */
  function solid(ctx, cam, axes, size, { ghost = null } = {}) {
    ctx.lineJoin = "round";
    ctx.setLineDash([]);
    for (const { points, normal, paint } of seen(cam, axes, size)) {
      outline(ctx, cam, points);
      if (ghost) {
        Object.assign(ctx, { strokeStyle: colour(ghost), lineWidth: 1.1, globalAlpha: 0.75 });
      } else {
        const fill = shaded(`body-${paint}`, normal, cam);
        const edge = paint === "panel" ? colour("body-line") : fill;
        Object.assign(ctx, { fillStyle: fill, strokeStyle: edge, lineWidth: 0.8 });
        ctx.fill();
      }
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  /** Body and its axes; what points away is behind it. */
  function withAxes(ctx, cam, axes, { size = 1, reach = 1, width = 3, head = 11, ghost = null } = {}) {
    const order = [0, 1, 2].sort((i, j) => cam.depth(axes[i]) - cam.depth(axes[j]));
    const draw = (i) => Explore.sphere.arrow(ctx, cam, [0, 0, 0], scaled(axes[i], reach), {
      colour: `axis-${"xyz"[i]}`, width, head, alpha: cam.depth(axes[i]) < 0 ? 0.75 : 1,
    });
    order.filter((i) => cam.depth(axes[i]) < 0).forEach(draw);
    solid(ctx, cam, axes, size, { ghost });
    order.filter((i) => cam.depth(axes[i]) >= 0).forEach(draw);
  }

  return { solid, withAxes, REACH };
})();
