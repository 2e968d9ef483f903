"use strict";
/** Keyframes that are rotations: a body that is turned by dragging it or the tips of its axes. */
Explore.rotations = (app, scene) => {
  const { state } = scene;
  const { element, button } = Explore.controls;
  const { plus, scaled, length, composed, turn, axesOf, between } = Explore.vectors;
  const STEP = 0.1;

  const selected = () => state.values[state.selected];

  /** Turn a keyframe about a direction of space. */
  function spin(index, axis, angle) {
    scene.set(index, composed(turn(axis, angle), state.values[index]));
  }

  /** Roll the body under the pointer, as a ball of the radius of the sphere. */
  function roll(cam, index, place, from, radius = cam.radius) {
    const [dx, dy] = [place[0] - from[0], place[1] - from[1]];
    const axis = plus(scaled(cam.up, dx), cam.right, dy);
    const size = length(axis);
    if (size > 0) spin(index, scaled(axis, 1 / size), size / radius);
    return "";
  }

  function moveTip(cam, axis, place) {
    const tip = axesOf(selected())[axis];
    const { point, outside } = cam.onSphere(place, cam.depth(tip) >= 0);
    scene.set(state.selected, composed(between(tip, point), selected()));
    return outside ? `The ${"xyz"[axis]} axis is at the rim. Turn the view to move it on.` : "";
  }

  function start() {
    if (!scene.editing()) scene.select(scene.nearest());
  }

  scene.handles = (cam) => {
    if (scene.fixed) return [];
    const centre = [cam.width / 2, cam.height / 2];
    const body = {
      key: "body", kind: "body", label: `Turn keyframe ${state.selected + 1}`, place: centre,
      size: 2 * Explore.body.REACH * cam.radius, start,
      // Its place stays, so that each move is counted from the one before.
      move: (place, from) => roll(cam, state.selected, place, from),
    };
    if (!scene.editing()) return [body];
    const tips = axesOf(selected()).map((tip, axis) => ({
      key: `tip-${axis}`, kind: `tip axis-${"xyz"[axis]}`,
      label: `Tip of the ${"xyz"[axis]} axis, keyframe ${state.selected + 1}`,
      place: cam.place(tip), far: cam.depth(tip) < 0, move: (place) => moveTip(cam, axis, place),
    }));
    return [body, ...tips];
  };

  scene.marks = (ctx, cam) => {
    for (const value of state.values) {
      axesOf(value).forEach((tip, axis) => Explore.sphere.dot(ctx, cam, tip, 4, `axis-${"xyz"[axis]}`));
    }
  };

  function turnButton(axis, sign) {
    const label = `Turn about the body's ${"xyz"[axis]} axis by ${sign < 0 ? "−" : ""}${STEP} rad`;
    const made = button(`${"xyz"[axis]} ${sign < 0 ? "−" : "+"}`, label, () => {
      scene.select(state.selected);
      spin(state.selected, axesOf(selected())[axis], sign * STEP);
      app.touched();
      app.status.say("limit", "");
      app.changed();
    }, `turn-${"xyz"[axis]}${sign < 0 ? "-minus" : ""}`);
    made.classList.add(`axis-${"xyz"[axis]}`);
    return made;
  }

  scene.valueRows = () => {
    const buttons = [0, 1, 2].flatMap((axis) => [-1, 1].map((sign) => turnButton(axis, sign)));
    const name = element("span", { textContent: `turn ${STEP} rad` });
    return [element("div", { className: "row turns" }, name, element("div", {}, ...buttons))];
  };

  /** Axes of the keyframe that is turned now: the body follows at once, not with the curve. */
  scene.standing = () => (scene.editing() ? axesOf(selected()) : null);
  scene.roll = roll;
  scene.hint ||= "Drag the body, or one in the row below, to turn a keyframe. Drag outside of it to turn the view.";
  return scene;
};
