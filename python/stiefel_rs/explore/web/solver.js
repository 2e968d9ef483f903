"use strict";
/** Who computes: the server that sent the page, or the grids inside of a page without one. */
Explore.solver = (() => {
  function numbers(text, Type) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Type(bytes.buffer);
  }

  const floats = (text) => (text === null ? null : numbers(text, Float32Array));

  function decoded(answer) {
    const curves = Object.fromEntries(Object.entries(answer.curves).map(([name, curve]) => {
      const { points, speed, acceleration } = curve;
      return [name, curve.error ? curve : {
        ...curve, points: floats(points), speed: floats(speed), acceleration: floats(acceleration),
      }];
    }));
    const [t, profileT] = [floats(answer.t), floats(answer.profile_t)];
    return { ...answer, t, profileT, angleT: t, curves, angle: floats(answer.angle) };
  }

  /** A server on this machine. */
  function server() {
    const token = new URLSearchParams(location.search).get("token") || "";
    const headers = { "Content-Type": "application/json", "X-Token": token };
    return {
      axes: () => null,
      fixed: () => false,
      note: () => "",
      spacing: () => "",
      async ask(request) {
        const response = await fetch("/curves", { method: "POST", headers, body: JSON.stringify(request) });
        const found = await response.json();
        if (!response.ok) throw new Error(found.error);
        return decoded(found);
      },
    };
  }

  const UNIT = 32767;
  const nearest = (axis, x) =>
    axis.reduce((best, value, i) => (Math.abs(value - x) < Math.abs(axis[best] - x) ? i : best), 0);

  /** Give curves of a grid so many points that they are smooth; their profiles stay. */
  function refined(answer, columns) {
    const found = Object.values(answer.curves).filter(({ error }) => !error);
    found.forEach((curve) => { curve.paths = Explore.samples.read(curve.points, columns); });
    const count = Explore.paths.pieces(found.flatMap(({ paths }) => paths));
    found.forEach((curve) => { curve.paths = curve.paths.map((path) => Explore.paths.fine(path, count)); });
    const pieces = (answer.profileT.length - 1) * count;
    return { ...answer, t: Float32Array.from({ length: pieces + 1 }, (_, i) => i / pieces) };
  }

  /** Curves of one kind between two ends, for velocities of a grid. */
  function table(grid, names, columns) {
    const [points, profiles] = [numbers(grid.points, Int16Array), numbers(grid.profiles, Int16Array)];
    const [scales, totals] = [numbers(grid.scales, Float64Array), numbers(grid.numbers, Float64Array)];
    const m = grid.samples;
    const rows = 2 * names.length + 1;
    const width = points.length / (totals.length / 2);
    const t = Float32Array.from({ length: m }, (_, i) => i / (m - 1));

    function profile(node, i) {
      const first = node * rows + i;
      return Float32Array.from(profiles.subarray(first * m, (first + 1) * m), (x) => (x / UNIT) * scales[first]);
    }

    return ({ v0, v1 }) => {
      const node = [...v0, ...v1].reduce((index, x, i) => {
        const axis = grid.axes[i % grid.axes.length];
        return index * axis.length + nearest(axis, x);
      }, 0);
      const errors = grid.errors[node] || {};
      const curves = Object.fromEntries(names.map((name, i) => {
        const place = node * names.length + i;
        return [name, errors[name] ? { error: errors[name] } : {
          points: Float32Array.from(points.subarray(place * width, (place + 1) * width), (x) => x / UNIT),
          speed: profile(node, 2 * i),
          acceleration: profile(node, 2 * i + 1),
          cost: totals[2 * place],
          length: totals[2 * place + 1],
        }];
      }));
      const angle = Object.keys(errors).length ? null : profile(node, rows - 1);
      return refined({ profileT: t, angleT: t, start: grid.start, end: grid.end, curves, angle }, columns);
    };
  }

  const SNAP = "velocities snap to a grid of computed curves.";
  const STAY = "keyframes cannot be moved. Start stiefel-rs explore to drag them.";

  /** Nobody: grids of velocities, and keyframes that stay. */
  function stored({ grids, fixed, kinds }) {
    const tables = {};
    const lookUp = (name, request) => {
      tables[name] ??= table(grids[name], Object.keys(kinds[name].curves), kinds[name].columns);
      return tables[name](request);
    };
    return {
      axes: (name) => grids[name]?.axes ?? null,
      fixed: (name) => name in fixed,
      note: (name) => `Without a server, ${name in grids ? SNAP : STAY}`,
      spacing: (name) => grids[name]?.spacing ?? "",
      ask: async (request) => (request.kind in fixed ? decoded(fixed[request.kind]) : lookUp(request.kind, request)),
    };
  }

  return { for: (config) => (config.mode === "static" ? stored(config) : server()), nearest };
})();
