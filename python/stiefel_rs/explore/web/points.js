"use strict";
/** Keyframes that are points of the sphere: numbered handles on it. */
Explore.points = (app, scene) => {
  const { state } = scene;
  const { slider } = Explore.controls;

  const longitude = ([x, y]) => Math.atan2(y, x);
  const latitude = ([, , z]) => Math.asin(Explore.vectors.clamped(z, -1, 1));
  const at = (u, v) => [Math.cos(v) * Math.cos(u), Math.cos(v) * Math.sin(u), Math.sin(v)];

  function move(cam, index, place) {
    const near = cam.depth(state.values[index]) >= 0;
    const { point, outside } = cam.onSphere(place, near);
    scene.set(index, point);
    return outside ? `Keyframe ${index + 1} is at the rim. Turn the view to move it on.` : "";
  }

  scene.handles = (cam) => (scene.fixed ? [] : state.values.map((value, index) => ({
    key: `keyframe-${index}`, kind: "keyframe", text: index + 1, label: `Keyframe ${index + 1}`,
    place: cam.place(value), far: cam.depth(value) < 0, selected: index === state.selected,
    start: () => { if (!scene.editing() || index !== state.selected) scene.select(index); },
    move: (place) => move(cam, index, place),
  })));

  scene.marks = (ctx, cam) => {
    if (scene.fixed) state.values.forEach((value) => Explore.sphere.dot(ctx, cam, value, 6, "accent"));
  };

  scene.valueRows = () => {
    const rows = [
      ["longitude", longitude, 3.14, (value, p) => at(value, latitude(p))],
      // Short of the poles, where the longitude would be lost.
      ["latitude", latitude, 1.57, (value, p) => at(longitude(p), value)],
    ];
    return rows.map(([name, read, limit, moved]) => {
      const range = { min: -limit, max: limit, step: 0.01 };
      const made = slider({ id: name, name, unit: "rad", range }, app, (value) => {
        scene.select(state.selected);
        scene.set(state.selected, moved(value, state.values[state.selected]));
      });
      scene.onWrite(() => made.write(read(state.values[state.selected])));
      return made.row;
    });
  };

  scene.hint ||= "Drag a numbered point. Drag elsewhere to turn the view.";
  return scene;
};
