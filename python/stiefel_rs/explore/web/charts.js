"use strict";
/** Small graphs against time, with a line at the present time; clicking on one goes to that time. */
Explore.charts = (() => {
  const EDGE = { left: 40, right: 16, top: 6, bottom: 18 };
  const colour = (name) => Explore.theme.colour(name);

  /** Distance of the ticks, so that there are at most five. */
  function step(range, most = 4) {
    const rough = range / most;
    const power = 10 ** Math.floor(Math.log10(rough));
    return [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough * 0.999);
  }

  function ticks(from, to, most) {
    const size = step(to - from, most);
    const first = Math.ceil(from / size - 1e-9);
    const count = Math.floor(to / size + 1e-9) - first;
    return Array.from({ length: count + 1 }, (_, i) => (first + i) * size);
  }

  const written = (x, size) =>
    (Math.abs(x) >= 1e4 || (size < 1e-3 && x !== 0)
      ? x.toExponential(0).replace("e+", "e").replace("-", "−")
      : x.toFixed(Math.max(0, -Math.floor(Math.log10(size) + 1e-9))));

  function scaleOf(canvas, span, top) {
    const box = canvas.getBoundingClientRect();
    const [w, h] = [box.width - EDGE.left - EDGE.right, box.height - EDGE.top - EDGE.bottom];
    return {
      width: box.width, height: box.height, bottom: box.height - EDGE.bottom,
      x: (t) => EDGE.left + (w * (t - span[0])) / (span[1] - span[0]),
      y: (value) => EDGE.top + h * (1 - value / top),
      time: (x) => span[0] + ((x - EDGE.left) / w) * (span[1] - span[0]),
    };
  }

  function axes(ctx, scale, span, top) {
    Object.assign(ctx, { lineWidth: 1, strokeStyle: colour("line"), fillStyle: colour("soft") });
    Object.assign(ctx, { font: `11px ${colour("font")}`, textAlign: "right", textBaseline: "middle" });
    ctx.setLineDash([]);
    ctx.beginPath();
    const rows = ticks(0, top, 3);
    for (const value of rows) {
      ctx.moveTo(EDGE.left, scale.y(value));
      ctx.lineTo(scale.width - EDGE.right, scale.y(value));
      ctx.fillText(written(value, step(top, 3)), EDGE.left - 7, scale.y(value));
    }
    ctx.stroke();
    Object.assign(ctx, { textAlign: "center", textBaseline: "top" });
    const columns = ticks(...span, 6);
    columns.forEach((t) => ctx.fillText(`${written(t, step(span[1] - span[0], 6))} s`, scale.x(t), scale.bottom + 6));
  }

  function draw(ctx, scale, t, { values, colour: name, dash, width = 2.2 }) {
    Object.assign(ctx, { strokeStyle: colour(name), lineWidth: width, lineJoin: "round" });
    ctx.setLineDash(dash ?? []);
    ctx.beginPath();
    for (let i = 0; i < t.length; i += 1) {
      if (i) ctx.lineTo(scale.x(t[i]), scale.y(values[i]));
      else ctx.moveTo(scale.x(t[i]), scale.y(values[i]));
    }
    ctx.stroke();
    ctx.setLineDash([]);
  }

  /** A graph on a canvas; `seek(t)` is called for clicks. */
  function chart(canvas, seek) {
    let scale = null;
    const go = (event) => scale && seek(scale.time(event.clientX - canvas.getBoundingClientRect().left));
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      go(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (canvas.hasPointerCapture(event.pointerId)) go(event);
    });
    return {
      /** Draw the series { values, colour, dash } against the times t, and the present time. */
      paint(t, series, now) {
        const span = [t[0], t[t.length - 1]];
        const largest = Math.max(0, ...series.map(({ values }) => values.reduce((most, x) => Math.max(most, x), 0)));
        const top = largest > 1e-9 ? 1.08 * largest : 1;
        const ctx = Explore.canvas.cleared(canvas);
        scale = scaleOf(canvas, span, top);
        axes(ctx, scale, span, top);
        series.forEach((each) => draw(ctx, scale, t, each));
        Object.assign(ctx, { strokeStyle: colour("accent"), lineWidth: 1.5 });
        ctx.beginPath();
        ctx.moveTo(scale.x(now), EDGE.top);
        ctx.lineTo(scale.x(now), scale.bottom);
        ctx.stroke();
        const { index, part } = Explore.samples.locate(t, now);
        for (const { values, colour: name } of series) {
          const value = values[index] + part * (values[Math.min(index + 1, values.length - 1)] - values[index]);
          ctx.beginPath();
          ctx.arc(scale.x(now), scale.y(value), 3.6, 0, 2 * Math.PI);
          ctx.fillStyle = colour(name);
          ctx.fill();
        }
      },
    };
  }

  return { chart };
})();
