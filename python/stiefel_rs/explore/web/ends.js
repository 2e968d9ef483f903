"use strict";
/** The scene of two ends: their velocities are arrows with handles at the tips. */
Explore.ends = (app, name, info, solver) => {
  const { dot, plus, clamped } = Explore.vectors;
  const { slider, group } = Explore.controls;
  const ENDS = ["start", "end"];
  const axes = solver.axes(name);
  const speed = "rad/s";
  const state = { angle: info.angle, velocities: [[], []], limits: new Set() };
  let shown = null;
  let sliders = [];

  const highest = (index) => (axes ? axes[index][axes[index].length - 1] : info.limit);
  const snapped = (velocity) =>
    (axes ? velocity.map((x, i) => axes[i][Explore.solver.nearest(axes[i], x)]) : velocity);
  // Arrows are drawn at a fraction of their length.
  const scale = () => (axes ? 0.75 / Math.max(...axes.flat()) : 0.95 / info.limit);
  const column = (matrix, j) => matrix.map((row) => row[j]);

  function velocity(end, j) {
    const { basis } = shown[ENDS[end]];
    return [0, 1, 2].map((i) => state.velocities[end].reduce((sum, x, p) => sum + x * basis[p][i][j], 0));
  }

  function arrow(end, j) {
    const from = column(shown[ENDS[end]].point, j);
    return [from, plus(from, velocity(end, j), scale())];
  }

  /** Set a velocity; what is beyond the range stays at its end, which is said. */
  function set(end, wanted) {
    const slack = (i) => (axes ? 0.75 * (axes[i][1] - axes[i][0]) : 1e-9);
    const over = wanted.findIndex((x, i) => Math.abs(x) > highest(i) + slack(i));
    const kept = wanted.map((x, i) => clamped(Math.round(x * 1000) / 1000, -highest(i), highest(i)));
    state.velocities = state.velocities.map((old, i) => (i === end ? snapped(kept) : old));
    if (over < 0) {
      state.limits.delete(end);
      return "";
    }
    state.limits.add(end);
    const value = Explore.numbers.with(highest(over), speed);
    return `Velocity at the ${ENDS[end]}, ${info.parameters[over]}: at most ${value} here.`;
  }

  /** Change a velocity so that the arrow's tip is at a place of the stage; it stays in the tangent plane. */
  function pull(cam, end, j, [x, y]) {
    const { basis } = shown[ENDS[end]];
    // Parameters that turn the frame about this column do not move its tip.
    const moving = basis.map((b, p) => [p, column(b, j)]).filter(([, b]) => dot(b, b) > 0.25);
    const [[p, b], [q, c]] = moving;
    const s = scale() * cam.radius;
    const A = [[s * dot(b, cam.right), s * dot(c, cam.right)], [-s * dot(b, cam.up), -s * dot(c, cam.up)]];
    const now = cam.place(arrow(end, j)[1]);
    const [dx, dy] = [x - now[0], y - now[1]];
    // A tangent plane seen from its edge: what cannot be seen is changed as little as possible.
    const det = A[0][0] * A[1][1] - A[0][1] * A[1][0];
    const damping = Math.abs(det) < 0.2 * s * s ? 0.04 * s * s : 0;
    const gram = (i, k) => A[0][i] * A[0][k] + A[1][i] * A[1][k] + (i === k ? damping : 0);
    const M = [0, 1].map((i) => [0, 1].map((k) => gram(i, k)));
    const r = [0, 1].map((i) => A[0][i] * dx + A[1][i] * dy);
    const d = M[0][0] * M[1][1] - M[0][1] * M[1][0];
    const next = [...state.velocities[end]];
    next[p] += (M[1][1] * r[0] - M[0][1] * r[1]) / d;
    next[q] += (M[0][0] * r[1] - M[1][0] * r[0]) / d;
    return set(end, next);
  }

  const each = (visit) =>
    ENDS.flatMap((side, end) => Array.from({ length: info.columns }, (_, j) => visit(side, end, j)));

  function handles(cam) {
    if (!shown) return [];
    return each((side, end, j) => {
      const [from, to] = arrow(end, j);
      const part = info.columns > 1 ? `, ${"xy"[j]} axis` : "";
      return {
        key: `${side}-${j}`, kind: side, label: `Velocity at the ${side}${part}`,
        place: cam.place(to), far: cam.depth(from) < 0, move: (place) => pull(cam, end, j, place),
      };
    });
  }

  /** Place of a name: behind the arrow, where it does not hide it, and inside of the picture. */
  function beside(cam, [from, to], width) {
    const [[x1, y1], [x2, y2]] = [cam.place(from), cam.place(to)];
    const left = (x2 > x1 && x1 > width) || x1 + width > cam.width;
    return [[x1 + (left ? -11 : 11), y1 + (y2 > y1 ? -12 : 14)], left ? "right" : "left"];
  }

  function marks(ctx, cam) {
    each((side, end, j) => {
      const [from, to] = arrow(end, j);
      const alpha = cam.depth(from) < 0 ? 0.45 : 1;
      if (state.limits.has(end)) Explore.sphere.stop(ctx, cam, from, to);
      Explore.sphere.arrow(ctx, cam, from, to, { colour: side, width: 3.5, head: 13, alpha });
      Explore.sphere.dot(ctx, cam, from, 5.5, side);
      const text = info.columns > 1 ? `${side} ${"xy"[j]}` : side;
      const [place, align] = beside(cam, [from, to], 10 * text.length);
      Explore.sphere.label(ctx, text, place, { colour: side, align, alpha });
    });
  }

  function parameterSlider(end, index) {
    const step = axes ? axes[index][1] - axes[index][0] : 0.05;
    const range = { min: -highest(index), max: highest(index), step };
    const look = { id: `${ENDS[end]}-${index}`, name: info.parameters[index], unit: speed, range };
    const made = slider(look, app, (value) =>
      set(end, state.velocities[end].map((old, i) => (i === index ? value : old))));
    sliders.push(() => made.write(state.velocities[end][index]));
    return made.row;
  }

  function panel() {
    sliders = [];
    const what = info.columns > 1 ? "Angular velocity" : "Velocity";
    const groups = ENDS.map((side, end) =>
      group(`${what} at the ${side}`, side, ...info.parameters.map((_, index) => parameterSlider(end, index))));
    if (!axes) groups.push(group("Between the ends", "angle", angleSlider()));
    return groups;
  }

  function angleSlider() {
    const range = { min: 0.1, max: 3.14, step: 0.01 };
    const made = slider({ id: "angle", name: "angle", unit: "rad", range }, app, (value) => {
      // The last place of the slider is the opposite point.
      state.angle = value > 3.135 ? Math.PI : value;
    });
    sliders.push(() => made.write(state.angle));
    return made.row;
  }

  return {
    hint: "Drag the tip of an arrow. Drag elsewhere to turn the view.",
    slow: 0.25,
    // Half of the picture in radii of the sphere: arrows reach outside of it.
    half: 1.22,
    span: () => [0, 1],
    request: () => ({ kind: name, angle: state.angle, v0: state.velocities[0], v1: state.velocities[1] }),
    received: (answer) => { shown = answer; },
    reset() {
      const velocities = info.velocities.map((v) => snapped([...v]));
      Object.assign(state, { angle: info.angle, velocities, limits: new Set() });
    },
    handles, marks, panel,
    write: () => sliders.forEach((write) => write()),
    state,
  };
};
