"use strict";
(() => {
  const config = JSON.parse(document.getElementById("config").textContent);
  const grid = JSON.parse(document.getElementById("grid").textContent);
  const $ = (id) => document.getElementById(id);
  const SVG = "http" + "://www.w3.org/2000/svg";
  // Half of the picture's width and height in radii of the sphere.
  const HALF = { x: 1.42, y: 1.42 * 0.9 };
  const CURVES = ["gcp", "cubic"];
  const COLOURS = { gcp: "#D55E00", cubic: "#000000", near: "#B4B4B4", far: "#E9E9E9", edge: "#666666", distance: "#0072B2" };
  const DASHES = { gcp: "6px,4px", cubic: "solid" };
  const FAR_OPACITY = 0.28;
  // Longest chord of a curve that is drawn, in radii of the sphere. A server sends points as close; grids are coarser.
  const CHORD = 0.05;
  const ENDS = ["start", "end"];
  const PLOT = { displayModeBar: false, staticPlot: true, responsive: true };
  const FIRST_VIEW = { azimuth: 0.25, elevation: 0.35 };

  const state = { kind: config.kind, angle: 0, velocities: [[], []], view: { ...FIRST_VIEW } };
  let shown = null;

  // Vectors and the picture's plane.
  const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
  const column = (matrix, j) => matrix.map((row) => row[j]);
  const kind = () => config.kinds[state.kind];

  /** Unit vectors to the right, up, and towards the reader. */
  function camera() {
    const { azimuth: a, elevation: e } = state.view;
    return {
      right: [-Math.sin(a), Math.cos(a), 0],
      up: [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)],
      front: [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)],
    };
  }

  // Static pages: the nearest node of the grid.

  function numbers(text, Type) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Type(bytes.buffer);
  }

  const table = grid && {
    points: numbers(grid.points, Int16Array),
    profiles: numbers(grid.profiles, Int16Array),
    scales: numbers(grid.scales, Float64Array),
    costs: numbers(grid.costs, Float64Array),
  };

  const nearest = (axis, x) => axis.reduce((best, value, i) => (Math.abs(value - x) < Math.abs(axis[best] - x) ? i : best), 0);
  const snap = (velocity) => (grid ? velocity.map((x, i) => grid.axes[i][nearest(grid.axes[i], x)]) : velocity);

  function lookUp() {
    const UNIT = 32767;
    const m = grid.samples;
    const size = 3 * kind().k;
    const node = state.velocities.flat().reduce((index, x, i) => {
      const axis = grid.axes[i % grid.axes.length];
      return index * axis.length + nearest(axis, x);
    }, 0);
    const profile = (i) =>
      Array.from(table.profiles.subarray((node * 5 + i) * m, (node * 5 + i + 1) * m), (x) => (x / UNIT) * table.scales[node * 5 + i]);
    const errors = grid.errors[node] || {};
    const curves = {};
    CURVES.forEach((name, i) => {
      const first = (node * 2 + i) * m * size;
      curves[name] = errors[name] ? { error: errors[name] } : {
        points: Array.from({ length: m }, (_, t) =>
          Array.from(table.points.subarray(first + t * size, first + (t + 1) * size), (x) => x / UNIT)),
        speed: profile(2 * i),
        acceleration: profile(2 * i + 1),
        cost: table.costs[node * 2 + i],
      };
    });
    const t = Array.from({ length: m }, (_, i) => i / (m - 1));
    return { t, start: grid.start, end: grid.end, curves, distance: Object.keys(errors).length ? null : profile(4) };
  }

  // Served pages: one request at a time; what changes meanwhile is asked for afterwards.

  let asking = false;
  let again = false;

  async function ask() {
    const token = new URLSearchParams(location.search).get("token") || "";
    const body = JSON.stringify({ kind: state.kind, angle: state.angle, v0: state.velocities[0], v1: state.velocities[1] });
    const response = await fetch("/curves", {
      method: "POST", headers: { "Content-Type": "application/json", "X-Token": token }, body,
    });
    const found = await response.json();
    if (!response.ok) throw new Error(found.error);
    return found;
  }

  async function refresh() {
    document.body.dataset.state = "busy";
    if (asking) {
      again = true;
      return;
    }
    asking = true;
    do {
      again = false;
      const asked = { kind: state.kind, velocities: state.velocities };
      try {
        const found = grid ? lookUp() : await ask();
        if (asked.kind === state.kind) show(found, asked.velocities);
      } catch (error) {
        tell(error instanceof TypeError ? "The server does not answer: start stiefel-rs explore again." : error.message);
      }
    } while (again);
    asking = false;
    document.body.dataset.state = "ready";
  }

  // The sphere.

  function circle(centre, u, v) {
    return Array.from({ length: 121 }, (_, i) => {
      const angle = (i * Math.PI) / 60;
      return centre.map((c, j) => c + Math.cos(angle) * u[j] + Math.sin(angle) * v[j]);
    });
  }

  const GRID_LINES = [
    ...[-60, -30, 0, 30, 60].map((degrees) => {
      const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
      return circle([0, 0, s], [c, 0, 0], [0, c, 0]);
    }),
    ...[0, 30, 60, 90, 120, 150].map((degrees) => {
      const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
      return circle([0, 0, 0], [c, s, 0], [0, 0, 1]);
    }),
  ];

  /** Where a chord crosses the rim, from the depths of its ends. */
  function rim(p, q, before, depth) {
    const crossing = p.map((x, i) => x + (before / (before - depth)) * (q[i] - x));
    const length = Math.hypot(...crossing);
    return crossing.map((x) => x / length);
  }

  /** Flat coordinates of what is on one half, up to the rim, with gaps for the rest. */
  function half(paths, view, near) {
    const [x, y] = [[], []];
    const add = (point) => {
      x.push(point && dot(point, view.right));
      y.push(point && dot(point, view.up));
    };
    for (const path of paths) {
      const depths = path.map((point) => dot(point, view.front));
      path.forEach((point, i) => {
        const here = depths[i] >= 0 === near;
        if (i > 0 && depths[i - 1] >= 0 !== depths[i] >= 0) {
          add(rim(path[i - 1], point, depths[i - 1], depths[i]));
          if (!here) add(null);
        }
        if (here) add(point);
      });
      add(null);
    }
    return { x, y };
  }

  /** A path with points between its own where these are far apart: by polynomials through four of them, on the sphere. */
  function fine(path) {
    const longest = Math.max(...path.slice(1).map((q, i) => Math.hypot(...q.map((x, j) => x - path[i][j]))));
    const pieces = longest > CHORD ? Math.ceil(longest / (0.8 * CHORD)) : 1;
    if (pieces === 1 || path.length < 4) return path;
    return Array.from({ length: (path.length - 1) * pieces + 1 }, (_, index) => {
      const first = Math.min(Math.max(Math.floor(index / pieces) - 1, 0), path.length - 4);
      const x = index / pieces - first;
      const weights = [0, 1, 2, 3].map((k) => [0, 1, 2, 3].reduce((w, l) => (l === k ? w : (w * (x - l)) / (k - l)), 1));
      const point = [0, 1, 2].map((i) => weights.reduce((sum, w, k) => sum + w * path[first + k][i], 0));
      const length = Math.hypot(...point);
      return point.map((z) => z / length);
    });
  }

  const line = (flat, color, width, more = {}) => ({
    ...flat, type: "scatter", mode: "lines", line: { color, width, simplify: false, ...(more.dash ? { dash: more.dash } : {}) },
    opacity: more.opacity ?? 1, name: more.name ?? "", hoverinfo: "skip", showlegend: false, connectgaps: false,
  });

  function drawSphere() {
    const view = camera();
    const traces = [false, true].map((near) => line(half(GRID_LINES, view, near), near ? COLOURS.near : COLOURS.far, 1));
    traces.push(line(half([circle([0, 0, 0], view.right, view.up)], { ...view, front: [0, 0, 0] }, true), COLOURS.edge, 1.3));
    for (const name of ["cubic", "gcp"]) {
      const points = shown?.curves[name].points;
      if (!points) continue;
      const paths = Array.from({ length: kind().k }, (_, j) => fine(points.map((p) => [0, 1, 2].map((i) => p[i * kind().k + j]))));
      for (const near of [false, true]) {
        const more = { dash: DASHES[name], opacity: near ? 1 : FAR_OPACITY, name: `${name} ${near ? "near" : "far"}` };
        traces.push(line(half(paths, view, near), COLOURS[name], 2.6, more));
      }
    }
    const axis = (range) => ({ range, visible: false, fixedrange: true });
    Plotly.react("sphere", traces, {
      margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      xaxis: axis([-HALF.x, HALF.x]), yaxis: axis([-HALF.y, HALF.y]),
    }, PLOT);
    drawArrows();
  }

  // Arrows: drawn at a fraction of their length, with handles at their tips.

  const scale = () => (grid ? 0.8 / Math.max(...grid.axes.flat()) : 1.1 / kind().limit);

  function velocity(end, j) {
    const { basis } = shown[ENDS[end]];
    return [0, 1, 2].map((i) => state.velocities[end].reduce((sum, x, p) => sum + x * basis[p][i][j], 0));
  }

  function element(name, attributes) {
    const made = document.createElementNS(SVG, name);
    Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, value));
    return made;
  }

  /** The picture's plane, y downwards as SVG has it. */
  const flat = (point, view) => [dot(point, view.right), -dot(point, view.up)];

  function drawArrows() {
    const view = camera();
    const parts = [];
    for (let end = 0; shown && end < 2; end += 1) {
      for (let j = 0; j < kind().k; j += 1) {
        const point = column(shown[ENDS[end]].point, j);
        const tip = point.map((x, i) => x + scale() * velocity(end, j)[i]);
        const [[x1, y1], [x2, y2]] = [flat(point, view), flat(tip, view)];
        const side = `${ENDS[end]}${dot(point, view.front) < 0 ? " far" : ""}`;
        const held = drag && drag.end === end && drag.column === j ? " dragged" : "";
        parts.push(element("line", { x1, y1, x2, y2, class: `arrow ${side}` }));
        parts.push(element("circle", { cx: x1, cy: y1, r: 0.024, class: `tip ${side}` }));
        parts.push(element("circle", { cx: x2, cy: y2, r: 0.056, class: `handle ${side}${held}`, "data-end": end, "data-column": j }));
        parts.push(head(x1, y1, x2, y2, side));
        const name = kind().k > 1 ? `${ENDS[end]}, column ${j + 1}` : ENDS[end];
        const label = element("text", { ...beside(x1, y1, x2, y2, 0.04 * name.length), class: `name ${side}` });
        label.textContent = name;
        parts.push(label);
      }
    }
    $("overlay").replaceChildren(...parts);
  }

  /** Place of a name: behind the arrow, where it hides neither the arrow nor its handle, and inside of the picture. */
  function beside(x1, y1, x2, y2, width) {
    const left = (x2 > x1 && x1 - width > -HALF.x) || x1 + width > HALF.x;
    return { x: x1 + (left ? -0.05 : 0.05), y: y1 + (y2 > y1 ? -0.05 : 0.1), "text-anchor": left ? "end" : "start" };
  }

  function head(x1, y1, x2, y2, side) {
    const length = Math.hypot(x2 - x1, y2 - y1);
    const [u, v] = length > 1e-9 ? [(x2 - x1) / length, (y2 - y1) / length] : [0, 0];
    const at = (along, across) => `${x2 + 0.04 * (along * u - across * v)},${y2 + 0.04 * (along * v + across * u)}`;
    return element("polygon", { points: [at(0.6, 0), at(-1, 0.75), at(-1, -0.75)].join(" "), class: `tip ${side}` });
  }

  // Dragging.

  let drag = null;

  function place(event) {
    const box = $("overlay").getBoundingClientRect();
    return [HALF.x * ((2 * (event.clientX - box.left)) / box.width - 1), HALF.y * ((2 * (event.clientY - box.top)) / box.height - 1)];
  }

  /** Change the velocity so that the arrow's tip is at a place of the picture; it stays in the tangent plane. */
  function pull(end, j, [x, y]) {
    const view = camera();
    const { point, basis } = shown[ENDS[end]];
    // Parameters that turn the frame about this column do not move its tip.
    const moving = basis.map((b, p) => [p, column(b, j)]).filter(([, b]) => dot(b, b) > 0.25);
    const [[p, b], [q, c]] = moving;
    const s = scale();
    const A = [[s * dot(b, view.right), s * dot(c, view.right)], [-s * dot(b, view.up), -s * dot(c, view.up)]];
    const base = column(point, j);
    const now = flat(base.map((z, i) => z + s * velocity(end, j)[i]), view);
    const [dx, dy] = [x - now[0], y - now[1]];
    // A tangent plane seen from its edge: what cannot be seen is changed as little as possible.
    const det = A[0][0] * A[1][1] - A[0][1] * A[1][0];
    const damping = Math.abs(det) < 0.2 * s * s ? 0.04 * s * s : 0;
    const M = [0, 1].map((i) => [0, 1].map((k) => A[0][i] * A[0][k] + A[1][i] * A[1][k] + (i === k ? damping : 0)));
    const r = [0, 1].map((i) => A[0][i] * dx + A[1][i] * dy);
    const d = M[0][0] * M[1][1] - M[0][1] * M[1][0];
    const next = [...state.velocities[end]];
    next[p] += (M[1][1] * r[0] - M[0][1] * r[1]) / d;
    next[q] += (M[0][0] * r[1] - M[1][0] * r[0]) / d;
    setVelocity(end, next);
  }

  function listen() {
    const overlay = $("overlay");
    overlay.setAttribute("viewBox", `${-HALF.x} ${-HALF.y} ${2 * HALF.x} ${2 * HALF.y}`);
    overlay.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || drag) return;
      const { end, column: j } = event.target.dataset;
      drag = { pointer: event.pointerId, end: end === undefined ? null : +end, column: +j, x: event.clientX, y: event.clientY };
      overlay.setPointerCapture(event.pointerId);
      overlay.classList.toggle("turning", drag.end === null);
      event.preventDefault();
    });
    overlay.addEventListener("pointermove", (event) => {
      if (!drag || drag.pointer !== event.pointerId || !shown) return;
      if (drag.end !== null) {
        pull(drag.end, drag.column, place(event));
        return;
      }
      const radius = overlay.getBoundingClientRect().width / (2 * HALF.x);
      state.view.azimuth -= (event.clientX - drag.x) / radius;
      state.view.elevation += (event.clientY - drag.y) / radius;
      state.view.elevation = Math.min(1.5, Math.max(-1.5, state.view.elevation));
      Object.assign(drag, { x: event.clientX, y: event.clientY });
      drawSphere();
    });
    const done = (event) => {
      if (!drag || drag.pointer !== event.pointerId) return;
      drag = null;
      overlay.classList.remove("turning");
      drawArrows();
    };
    overlay.addEventListener("pointerup", done);
    overlay.addEventListener("pointercancel", done);
  }

  // Numbers and profiles.

  function tell(text) {
    $("message").textContent = text;
    $("message").hidden = !text;
  }

  const digits = (x) => (x === 0 ? "0" : Math.abs(x) < 1e-3 || Math.abs(x) >= 1e6 ? x.toExponential(3) : x.toPrecision(6));

  function chart(id, title, traces, color = null) {
    const series = traces.filter(([, y]) => y).map(([name, y]) => ({
      x: shown.t, y, type: "scatter", mode: "lines", name, hoverinfo: "skip", showlegend: false,
      line: { color: color ?? COLOURS[name], width: 2.2, dash: DASHES[name] ?? "solid", simplify: false },
    }));
    const axis = { gridcolor: "#E4E4E4", zeroline: false, fixedrange: true, linecolor: "#999999", showline: true, ticks: "outside", tickcolor: "#999999" };
    Plotly.react(id, series, {
      margin: { l: 62, r: 10, t: 26, b: id === "distance" ? 46 : 26 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: "system-ui, DejaVu Sans, sans-serif", size: 12, color: "#333333" },
      title: { text: title, x: 0, xanchor: "left", y: 1, yanchor: "top", pad: { t: 3 }, font: { size: 13 } },
      xaxis: { ...axis, range: [0, 1], dtick: 0.25, title: { text: id === "distance" ? "time t" : "", standoff: 4 } },
      yaxis: { ...axis, rangemode: "tozero", nticks: 5, exponentformat: "power", showticklabels: series.length > 0 },
    }, PLOT);
  }

  function show(found, velocities) {
    shown = found;
    const { gcp, cubic } = found.curves;
    const errors = CURVES.filter((name) => found.curves[name].error);
    const names = { gcp: "No geometric cubic", cubic: "No exact cubic" };
    tell(errors.map((name) => `${names[name]}: ${found.curves[name].error}`).join(" "));
    $("cost-gcp").textContent = gcp.error ? "none" : digits(gcp.cost);
    $("cost-cubic").textContent = cubic.error ? "none" : digits(cubic.cost);
    const excess = gcp.error || cubic.error || cubic.cost < 1e-12 ? null : (100 * (gcp.cost - cubic.cost)) / cubic.cost;
    $("excess").textContent = excess === null ? "" : `${excess < 0 ? "−" : "+"}${Math.abs(excess).toPrecision(3)} %`;
    $("distance-max").textContent = found.distance ? digits(Math.max(...found.distance)) : "none";
    for (const [id, title] of [["speed", "speed |S′|"], ["acceleration", "covariant acceleration |Dₜ S′|"]]) {
      chart(id, title, ["cubic", "gcp"].map((name) => [name, found.curves[name][id]]));
    }
    chart("distance", "Frobenius distance of the curves", [["distance", found.distance]], COLOURS.distance);
    drawSphere();
    document.body.dataset.velocities = JSON.stringify(velocities);
  }

  // Sliders.

  function setVelocity(end, wanted) {
    const axes = grid?.axes;
    const { limit } = kind();
    const kept = snap(wanted.map((x, i) => {
      const top = axes ? axes[i][axes[i].length - 1] : limit;
      return Math.min(top, Math.max(-top, Math.round(x * 1000) / 1000));
    }));
    if (kept.every((x, i) => x === state.velocities[end][i])) return;
    state.velocities = state.velocities.map((old, i) => (i === end ? kept : old));
    writeSliders();
    drawArrows();
    refresh();
  }

  function writeSliders() {
    document.querySelectorAll("#controls input").forEach((input) => {
      const { end, index } = input.dataset;
      const value = end === undefined ? state.angle : state.velocities[+end][+index];
      input.value = value;
      input.nextElementSibling.textContent = value.toFixed(2).replace("-", "−");
    });
  }

  function row(name, id, attributes, data, changed) {
    const made = document.createElement("div");
    made.className = "row";
    const label = document.createElement("label");
    label.htmlFor = id;
    label.textContent = name;
    const input = document.createElement("input");
    Object.assign(input, { type: "range", id, ...attributes });
    Object.assign(input.dataset, data);
    input.addEventListener("input", () => changed(+input.value));
    const value = document.createElement("output");
    value.htmlFor = id;
    made.append(label, input, value);
    return made;
  }

  function group(title, style, rows) {
    const made = document.createElement("fieldset");
    const legend = document.createElement("legend");
    legend.textContent = title;
    legend.className = `${style}-legend`;
    if (style === "angle") made.className = "wide";
    made.append(legend, ...rows);
    return made;
  }

  function buildControls() {
    const { parameters, limit } = kind();
    const what = kind().k > 1 ? "Angular velocity" : "Velocity";
    const groups = ENDS.map((name, end) => group(`${what} at the ${name}`, name, parameters.map((parameter, index) => {
      const axis = grid?.axes[index];
      const range = axis ? { min: axis[0], max: axis[axis.length - 1], step: axis[1] - axis[0] } : { min: -limit, max: limit, step: 0.05 };
      return row(parameter, `${name}-${index}`, range, { end, index }, (value) => {
        const next = [...state.velocities[end]];
        next[index] = value;
        setVelocity(end, next);
      });
    })));
    if (!grid) {
      groups.push(group("Angle between the ends", "angle", [
        row("radians", "angle", { min: 0.1, max: 3.14, step: 0.01 }, {}, (value) => {
          // The last place of the slider is the opposite point.
          state.angle = value > 3.135 ? Math.PI : value;
          writeSliders();
          refresh();
        }),
      ]));
    }
    $("controls").replaceChildren(...groups);
  }

  function start(name) {
    Object.assign(state, { kind: name, angle: config.kinds[name].angle, view: { ...FIRST_VIEW } });
    state.velocities = config.kinds[name].velocities.map((v) => snap([...v]));
    shown = null;
    buildControls();
    writeSliders();
    return refresh();
  }

  function buildKinds() {
    const names = Object.keys(config.kinds);
    if (names.length < 2) return;
    for (const name of names) {
      const label = document.createElement("label");
      const input = document.createElement("input");
      Object.assign(input, { type: "radio", name: "kind", value: name, id: `kind-${name}`, checked: name === state.kind });
      input.addEventListener("change", () => start(name));
      label.append(input, ` ${config.kinds[name].title}`);
      $("kinds").append(label);
    }
  }

  $("controls").addEventListener("submit", (event) => event.preventDefault());
  $("reset").addEventListener("click", () => start(state.kind));
  buildKinds();
  listen();
  start(config.kind);
})();
