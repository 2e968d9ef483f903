"use strict";
/** The unit sphere on a canvas: the ball, lines and arrows on it. What is on the far half is paler. */
Explore.sphere = (() => {
  const { plus, scaled, cross, length, unit } = Explore.vectors;
  const { half, circle, GRID_LINES } = Explore.paths;
  const colour = (name) => Explore.theme.colour(name);

  /** Draw flat pieces, in radii of the sphere. */
  function strokes(ctx, cam, pieces) {
    ctx.beginPath();
    for (const piece of pieces) {
      piece.forEach(([x, y], i) => {
        const [px, py] = [cam.width / 2 + cam.radius * x, cam.height / 2 - cam.radius * y];
        if (i) ctx.lineTo(px, py);
        else ctx.moveTo(px, py);
      });
    }
    ctx.stroke();
  }

  function style(ctx, strokeStyle, lineWidth, { alpha = 1, dash = [] } = {}) {
    Object.assign(ctx, { strokeStyle, lineWidth, globalAlpha: alpha, lineJoin: "round" });
    ctx.lineCap = dash.length ? "butt" : "round";
    ctx.setLineDash(dash);
  }

  /** The ball and the lines behind. */
  function back(ctx, cam) {
    const [x, y, r] = [cam.width / 2, cam.height / 2, cam.radius];
    const glow = ctx.createRadialGradient(x, y, r * 0.98, x, y, r * Math.min(1.2, cam.half));
    glow.addColorStop(0, colour("halo"));
    glow.addColorStop(1, colour("halo-end"));
    ctx.fillStyle = glow;
    ctx.fillRect(0, 0, cam.width, cam.height);
    const ball = ctx.createRadialGradient(x - 0.38 * r, y - 0.46 * r, 0.08 * r, x, y, r);
    ball.addColorStop(0, colour("ball-light"));
    ball.addColorStop(0.62, colour("ball"));
    ball.addColorStop(1, colour("ball-edge"));
    ctx.fillStyle = ball;
    ctx.beginPath();
    ctx.arc(x, y, r, 0, 2 * Math.PI);
    ctx.fill();
    style(ctx, colour("grid"), 1, { alpha: 0.35 });
    strokes(ctx, cam, half(GRID_LINES, cam, false));
    ctx.globalAlpha = 1;
  }

  /** The lines in front and the rim. */
  function front(ctx, cam) {
    style(ctx, colour("grid"), 1, { alpha: 0.8 });
    strokes(ctx, cam, half(GRID_LINES, cam, true));
    style(ctx, colour("rim"), 1.4);
    strokes(ctx, cam, [circle([0, 0, 0], [1, 0, 0], [0, 1, 0])]);
    ctx.globalAlpha = 1;
  }

  /** One half of a curve; `look` is { colour, width, dash }. */
  function curve(ctx, cam, paths, near, look) {
    const pieces = half(paths, cam, near);
    if (near) {
      style(ctx, colour("ball"), look.width + 3.5, { alpha: 0.75 });
      strokes(ctx, cam, pieces);
    }
    const width = near ? look.width : 0.75 * look.width;
    style(ctx, colour(look.colour), width, { alpha: near ? 1 : 0.3, dash: look.dash });
    strokes(ctx, cam, pieces);
    style(ctx, "#000", 1);
  }

  /** The way that a point has just come, fading. */
  function tail(ctx, cam, path, look) {
    style(ctx, colour(look.colour), look.width);
    ctx.lineCap = "butt";
    for (let i = 1; i < path.length; i += 1) {
      const part = i / path.length;
      const [[x1, y1], [x2, y2]] = [cam.place(path[i - 1]), cam.place(path[i])];
      ctx.globalAlpha = 0.4 * part * part * (cam.depth(path[i]) >= 0 ? 1 : 0.35);
      ctx.lineWidth = look.width + 9 * part;
      ctx.beginPath();
      ctx.moveTo(x1, y1);
      ctx.lineTo(x2, y2);
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  function dot(ctx, cam, point, radius, name, { hollow = false } = {}) {
    const [x, y] = cam.place(point);
    ctx.globalAlpha = cam.depth(point) >= -1e-9 ? 1 : 0.4;
    ctx.beginPath();
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    ctx.fillStyle = hollow ? colour("ball") : colour(name);
    ctx.strokeStyle = hollow ? colour(name) : colour("ball");
    ctx.lineWidth = 2;
    ctx.fill();
    ctx.stroke();
    ctx.globalAlpha = 1;
  }

  /** Arrow between two points of space. */
  function arrow(ctx, cam, from, to, { colour: name, width = 3, alpha = 1, head = 9, dash = [] }) {
    const [[x1, y1], [x2, y2]] = [cam.place(from), cam.place(to)];
    const size = Math.hypot(x2 - x1, y2 - y1);
    if (size < 0.5) return;
    const [u, v] = [(x2 - x1) / size, (y2 - y1) / size];
    const tip = Math.min(head, size);
    style(ctx, colour(name), width, { alpha, dash });
    ctx.beginPath();
    ctx.moveTo(x1, y1);
    ctx.lineTo(x2 - 0.8 * tip * u, y2 - 0.8 * tip * v);
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.fillStyle = colour(name);
    ctx.beginPath();
    ctx.moveTo(x2, y2);
    ctx.lineTo(x2 - tip * u - 0.45 * tip * v, y2 - tip * v + 0.45 * tip * u);
    ctx.lineTo(x2 - tip * u + 0.45 * tip * v, y2 - tip * v - 0.45 * tip * u);
    ctx.closePath();
    ctx.fill();
    ctx.globalAlpha = 1;
  }

  /** Bar across the end of an arrow that can be no longer. */
  function stop(ctx, cam, from, to) {
    const along = plus(to, from, -1);
    if (length(along) < 1e-9) return;
    const side = scaled(unit(cross(along, cam.front)), 0.09);
    if (!side.every(Number.isFinite)) return;
    const [[x1, y1], [x2, y2]] = [cam.place(plus(to, side)), cam.place(plus(to, side, -1))];
    style(ctx, colour("warn"), 4);
    ctx.beginPath();
    ctx.moveTo(x1, y1);
    ctx.lineTo(x2, y2);
    ctx.stroke();
    ctx.globalAlpha = 1;
  }

  /** Moving frame of a point on the sphere: two tangent axes and the normal. */
  function triad(ctx, cam, axes, size) {
    const point = axes[2];
    const alpha = cam.depth(point) >= 0 ? 1 : 0.4;
    const order = [0, 1, 2].sort((i, j) => cam.depth(axes[i]) - cam.depth(axes[j]));
    for (const i of order) {
      arrow(ctx, cam, point, plus(point, axes[i], size), { colour: `axis-${"xyz"[i]}`, alpha, width: 3.2, head: 10 });
    }
  }

  function label(ctx, text, [x, y], { colour: name = "ink", align = "left", alpha = 1 } = {}) {
    Object.assign(ctx, { font: `600 14px ${colour("font")}`, textAlign: align, textBaseline: "middle" });
    Object.assign(ctx, { globalAlpha: alpha, strokeStyle: colour("ball"), lineWidth: 4, fillStyle: colour(name) });
    ctx.lineJoin = "round";
    ctx.setLineDash([]);
    ctx.strokeText(text, x, y);
    ctx.fillText(text, x, y);
    ctx.globalAlpha = 1;
  }

  return { back, front, curve, tail, dot, arrow, stop, triad, label };
})();
