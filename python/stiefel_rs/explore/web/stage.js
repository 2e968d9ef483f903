"use strict";
/** The picture: sphere, curves, the frame or body that moves, and the marks of the scene. */
Explore.stage = (canvas, app) => {
  const { sphere, samples } = Explore;
  const OTHER = { colour: "other", width: 2, dash: [7, 5] };
  const TAIL = 0.14;

  function looks(columns, main) {
    const colours = columns === 1 ? ["main"] : ["axis-x", "axis-y", "axis-z"].slice(0, columns);
    return main ? colours.map((colour) => ({ colour, width: 3.4 })) : colours.map(() => OTHER);
  }

  /** Both curves, the one compared with first; those that are missing or hidden are left out. */
  function drawn() {
    const { columns, curves } = app.info();
    return Object.keys(curves).map((name, i) => ({ name, main: i === 0, curve: app.answer()?.curves[name] }))
      .filter(({ name, curve }) => curve && !curve.error && app.isShown(name)).reverse()
      .map((each) => ({ ...each, paths: samples.paths(each.curve, columns), looks: looks(columns, each.main) }));
  }

  const halves = (ctx, cam, all, near) => all.forEach(({ paths, looks: each }) =>
    paths.forEach((path, j) => sphere.curve(ctx, cam, [path], near, each[j])));

  function tails(ctx, cam, { paths, looks: each }) {
    const { t } = app.answer();
    const [first, last] = [t[0], t[t.length - 1]];
    const now = app.player.time();
    const from = samples.locate(t, Math.max(first, now - TAIL * (last - first))).index;
    const { index } = samples.locate(t, now);
    paths.forEach((path, j) => sphere.tail(ctx, cam, path.slice(from, index + 1), each[j]));
  }

  /** Axes of the frame that moves along a curve. */
  const moving = ({ curve }) => samples.axes(curve, app.info().columns, app.answer().t, app.player.time());

  function frames(ctx, cam, all) {
    const { columns } = app.info();
    // At a keyframe both curves are where its body is.
    for (const each of app.scene().standing?.() ? [] : all) {
      const axes = moving(each);
      const tips = columns === 1 ? [axes[2]] : axes.slice(0, columns);
      if (!each.main) tips.forEach((tip) => sphere.dot(ctx, cam, tip, 5, "other", { hollow: true }));
      else if (columns === 1) sphere.triad(ctx, cam, axes, 0.3);
    }
  }

  function bodies(ctx, cam, all) {
    const scene = app.scene();
    const [main, other] = [all.find((each) => each.main), all.find((each) => !each.main)];
    const standing = scene.standing?.();
    if (other && !standing) Explore.body.solid(ctx, cam, moving(other), 1, { ghost: "other" });
    if (main || standing) Explore.body.withAxes(ctx, cam, standing ?? moving(main), { size: 1 });
  }

  return {
    camera() {
      const box = canvas.getBoundingClientRect();
      return Explore.camera.make(app.view(), box.width, box.height, app.scene().half);
    },
    paint() {
      const ctx = Explore.canvas.cleared(canvas);
      const cam = this.camera();
      const all = drawn();
      sphere.back(ctx, cam);
      halves(ctx, cam, all, false);
      if (app.info().columns > 1) bodies(ctx, cam, all);
      sphere.front(ctx, cam);
      halves(ctx, cam, all, true);
      const main = all.find((each) => each.main);
      if (main) tails(ctx, cam, main);
      if (app.answer()) app.scene().marks(ctx, cam);
      frames(ctx, cam, all);
    },
  };
};
