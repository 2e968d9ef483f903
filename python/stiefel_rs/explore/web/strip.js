"use strict";
/** The row of bodies above the track, one for each rotation: pressing selects, dragging turns. */
Explore.strip = (row, app) => {
  const STEP = 8;
  const LARGEST = 92;
  let [bodies, held] = [[], null];

  function turn(index, place, from) {
    app.touched();
    app.scene().roll(app.camera(), index, place, from, bodies[index].clientWidth / 1.7);
    app.status.say("limit", "");
    app.changed();
  }

  function body() {
    const made = document.createElement("button");
    made.type = "button";
    made.className = "body-key";
    made.append(document.createElement("canvas"));
    const index = () => bodies.indexOf(made);
    made.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      app.scene().select(index());
      made.setPointerCapture(event.pointerId);
      held = [event.clientX, event.clientY];
    });
    made.addEventListener("pointermove", (event) => {
      if (!held || !made.hasPointerCapture(event.pointerId) || app.scene().fixed) return;
      const place = [event.clientX, event.clientY];
      turn(index(), place, held);
      held = place;
    });
    for (const name of ["pointerup", "pointercancel"]) made.addEventListener(name, () => { held = null; });
    made.addEventListener("focus", () => app.scene().state.selected !== index() && app.scene().select(index()));
    made.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (app.scene().fixed) return;
      if (way) {
        event.preventDefault();
        app.scene().select(index());
        turn(index(), way.map((x) => x * (event.shiftKey ? 1 : STEP)), [0, 0]);
      } else if (event.key === "Delete") app.scene().remove(index());
    });
    row.append(made);
    return made;
  }

  /** Places of centres: those of the times, but side by side. */
  function places(wanted, size, width) {
    const found = [...wanted];
    for (let i = 0; i < found.length; i += 1) found[i] = Math.max(found[i], i ? found[i - 1] + size : size / 2);
    for (let i = found.length - 1; i >= 0; i -= 1) {
      found[i] = Math.min(found[i], i < found.length - 1 ? found[i + 1] - size : width - size / 2);
    }
    return found;
  }

  return {
    paint() {
      const scene = app.scene();
      row.hidden = !scene.roll;
      const values = scene.roll ? scene.state.values : [];
      while (bodies.length > values.length) bodies.pop().remove();
      while (bodies.length < values.length) bodies.push(body());
      if (!values.length) return;
      const width = row.clientWidth;
      const size = Math.min(LARGEST, row.clientHeight, width / values.length);
      const centres = places(scene.state.t.map((t) => (t / scene.limits.duration) * width), size, width);
      bodies.forEach((made, index) => {
        Object.assign(made.style, { left: `${centres[index] - size / 2}px`, width: `${size}px`, height: `${size}px` });
        made.classList.toggle("selected", index === scene.state.selected);
        made.setAttribute("aria-label", `Keyframe ${index + 1}: turn with the arrow keys`);
        made.title = scene.fixed ? "" : "Drag to turn; Delete removes";
        const ctx = Explore.canvas.cleared(made.firstChild);
        const camera = Explore.camera.make(app.view(), size, size, 0.86);
        const axes = Explore.vectors.axesOf(values[index]);
        Explore.body.withAxes(ctx, camera, axes, { size: 1.15, width: 2, head: 6, reach: 0.8 });
      });
    },
  };
};
