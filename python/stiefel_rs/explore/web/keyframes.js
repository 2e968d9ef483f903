"use strict";
/** The scenes of keyframes: their times and values, which one is selected, and the panel for it. */
Explore.keyframes = (app, name, info, solver) => {
  const { clamped, unit, ofAxes } = Explore.vectors;
  const { slider, group, button, choice } = Explore.controls;
  const seconds = (x) => Explore.numbers.with(x, "s");
  const state = { t: [], values: [], selected: 0, ends: "natural" };
  // Times are multiples of 0.01 s; what is that near to a limit has not met it.
  const ROUNDING = 0.006;
  const fixed = solver.fixed(name);
  let sliders = [];

  const scene = {
    hint: fixed ? "Drag to turn the view." : "",
    slow: 1,
    half: 1.09,
    state, fixed,
    span: () => [state.t[0], state.t[state.t.length - 1]],
    request: () => ({ kind: name, t: state.t, values: state.values, ends: state.ends }),
    received: () => {},
    reset() {
      const values = info.values.map((value) => [...value]);
      Object.assign(state, { t: [...info.t], values, selected: 0, ends: "natural" });
    },
    write: () => sliders.forEach((write) => write()),
    limits: { duration: info.duration },
  };

  /** Whether the moving frame stands at the selected keyframe, so that dragging it is seen. */
  scene.editing = () => !app.player.playing() && Math.abs(app.player.time() - state.t[state.selected]) < 1e-6;

  scene.select = (index) => {
    state.selected = index;
    app.player.pause();
    app.player.seek(state.t[index]);
    scene.write();
    app.repaint();
  };

  scene.nearest = () => state.t.reduce((best, t, i) =>
    (Math.abs(t - app.player.time()) < Math.abs(state.t[best] - app.player.time()) ? i : best), 0);

  /** Move a keyframe to a value. */
  scene.set = (index, value) => { state.values[index] = unit(value); };

  /** Move a keyframe in time; it keeps its distance to its neighbours, which is said. */
  scene.moveTime = (index, wanted) => {
    const least = index > 0 ? state.t[index - 1] + info.gap : 0;
    const most = index < state.t.length - 1 ? state.t[index + 1] - info.gap : info.duration;
    const time = clamped(Math.round(wanted * 100) / 100, least, most);
    const standing = scene.editing() && state.selected === index;
    state.t[index] = time;
    if (standing) app.player.seek(time);
    const stays = `Keyframe ${index + 1} stays ${seconds(info.gap)}`;
    if (wanted < least - ROUNDING) {
      return index ? `${stays} after keyframe ${index}.` : "Times begin at 0 s.";
    }
    if (wanted > most + ROUNDING) {
      return index < state.t.length - 1 ? `${stays} before keyframe ${index + 2}.` : `Times end at ${seconds(most)}.`;
    }
    return "";
  };

  /** A time for a new keyframe: the present one, or the middle of the longest gap if that is too near to another. */
  function freeTime() {
    const now = Math.round(app.player.time() * 100) / 100;
    if (Math.min(...state.t.map((t) => Math.abs(t - now))) >= info.gap) return now;
    const gaps = state.t.slice(1).map((t, i) => t - state.t[i]);
    const longest = gaps.indexOf(Math.max(...gaps));
    return gaps[longest] >= 2 * info.gap ? state.t[longest] + gaps[longest] / 2 : null;
  }

  scene.add = () => {
    const [, most] = info.count;
    const time = freeTime();
    const curve = app.curve();
    if (state.t.length >= most) return app.status.say("limit", `At most ${most} keyframes here.`);
    if (time === null) return app.status.say("limit", `No room: keyframes stay ${seconds(info.gap)} apart.`);
    if (!curve) return app.status.say("limit", "No curve to put a keyframe on.");
    const axes = Explore.samples.axes(curve, info.columns, app.answer().t, time);
    const index = state.t.findIndex((t) => t > time);
    state.t.splice(index, 0, time);
    state.values.splice(index, 0, info.columns === 1 ? axes[2] : ofAxes(axes));
    app.status.say("limit", "");
    scene.select(index);
    return app.changed();
  };

  scene.remove = (index = state.selected) => {
    const [least] = info.count;
    if (state.t.length <= least) return app.status.say("limit", `A curve needs ${least} keyframes.`);
    state.t.splice(index, 1);
    state.values.splice(index, 1);
    app.status.say("limit", "");
    scene.select(Math.min(index, state.t.length - 1));
    return app.changed();
  };

  function timeSlider() {
    const range = { min: 0, max: info.duration, step: 0.01 };
    const made = slider({ id: "keyframe-time", name: "time", unit: "s", range }, app, (value) => {
      if (!scene.editing()) app.player.seek(state.t[state.selected]);
      app.player.pause();
      return scene.moveTime(state.selected, value);
    });
    sliders.push(() => made.write(state.t[state.selected]));
    return made.row;
  }

  function edit() {
    const fields = group("", "keyframe", timeSlider(), ...scene.valueRows());
    sliders.push(() => {
      fields.firstChild.textContent = `Keyframe ${state.selected + 1} of ${state.t.length}`;
    });
    return fields;
  }

  function actions() {
    const conditions = { natural: "free (natural)", clamped: "at rest (clamped)" };
    const ends = choice("end-conditions", "ends", conditions, (value) => {
      state.ends = value;
      app.changed();
    });
    sliders.push(() => { ends.select.value = state.ends; });
    const add = button("Add keyframe", "Add a keyframe at the present time", scene.add, "add");
    const remove = button("Remove", "Remove the selected keyframe", () => scene.remove(), "remove");
    const buttons = Explore.controls.element("div", { className: "buttons" }, add, remove);
    return group("Spline", "spline", ends.row, buttons);
  }

  scene.panel = () => {
    sliders = [];
    return fixed ? [] : [edit(), actions()];
  };
  scene.onWrite = (write) => sliders.push(write);
  return info.columns === 1 ? Explore.points(app, scene) : Explore.rotations(app, scene);
};
