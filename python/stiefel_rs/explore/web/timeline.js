"use strict";
/** The track below the stage: the present time, and the keyframes as markers that are dragged along it. */
Explore.timeline = (track, app) => {
  const { element } = Explore.controls;
  const head = element("div", { className: "head", id: "head", tabIndex: 0 });
  head.setAttribute("role", "slider");
  head.setAttribute("aria-label", "Time");
  const run = element("div", { className: "run" });
  track.append(run, head);
  let markers = [];
  let held = null;

  const duration = () => app.scene().limits?.duration ?? app.scene().span()[1];
  const share = (time) => `${(100 * time) / duration()}%`;

  function timeAt(event) {
    const box = track.getBoundingClientRect();
    return ((event.clientX - box.left) / box.width) * duration();
  }

  function seek(time) {
    const [first, last] = app.scene().span();
    const slack = 0.01 * (last - first);
    const text = (name, end) => `The curve ${name} at ${Explore.numbers.with(end, "s")}.`;
    const limit = time < first - slack ? text("starts", first) : time > last + slack ? text("ends", last) : "";
    app.status.say("limit", limit);
    app.player.pause();
    app.player.seek(time);
    app.repaint();
  }

  track.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.target.dataset.index !== undefined) return;
    track.setPointerCapture(event.pointerId);
    held = "head";
    head.focus({ preventScroll: true });
    seek(timeAt(event));
    event.preventDefault();
  });
  track.addEventListener("pointermove", (event) => {
    if (held === "head") seek(timeAt(event));
  });
  for (const name of ["pointerup", "pointercancel"]) track.addEventListener(name, () => { held = null; });
  track.addEventListener("dblclick", (event) => {
    if (event.target.dataset.index === undefined) app.scene().add?.();
  });

  head.addEventListener("keydown", (event) => {
    const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    const [first, last] = app.scene().span();
    if (way) seek(app.player.time() + way * (event.shiftKey ? 0.01 : 0.05) * (last - first));
    else if (event.key === "Home") seek(first);
    else if (event.key === "End") seek(last);
    else return;
    event.preventDefault();
  });

  function moveTime(index, time) {
    app.touched();
    const limit = app.scene().moveTime(index, time);
    app.status.say("limit", limit);
    markers[index].classList.toggle("limit", Boolean(limit));
    app.changed();
  }

  function marker() {
    const made = element("button", { type: "button", className: "marker" });
    const index = () => Number(made.dataset.index);
    made.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      made.setPointerCapture(event.pointerId);
      held = made;
      app.scene().select(index());
    });
    made.addEventListener("pointermove", (event) => {
      if (held === made && !app.scene().fixed) moveTime(index(), timeAt(event));
    });
    for (const name of ["pointerup", "pointercancel"]) {
      made.addEventListener(name, () => {
        held = null;
        made.classList.remove("limit");
      });
    }
    made.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (app.scene().fixed) return;
      if (way) {
        app.scene().select(index());
        moveTime(index(), app.scene().state.t[index()] + way * (event.shiftKey ? 0.01 : 0.1));
      } else if (event.key === "Delete") app.scene().remove(index());
    });
    made.addEventListener("focus", () => app.scene().state.selected !== index() && app.scene().select(index()));
    made.addEventListener("blur", () => made.classList.remove("limit"));
    track.append(made);
    return made;
  }

  return {
    paint() {
      const scene = app.scene();
      const [first, last] = scene.span();
      Object.assign(run.style, { left: share(first), width: share(last - first) });
      head.style.left = share(app.player.time());
      head.setAttribute("aria-valuemin", first.toFixed(2));
      head.setAttribute("aria-valuemax", last.toFixed(2));
      head.setAttribute("aria-valuenow", app.player.time().toFixed(2));
      head.setAttribute("aria-valuetext", Explore.numbers.with(app.player.time(), "s"));
      const t = scene.state.t ?? [];
      while (markers.length > t.length) markers.pop().remove();
      while (markers.length < t.length) markers.push(marker());
      markers.forEach((made, index) => {
        made.dataset.index = index;
        made.style.left = share(t[index]);
        made.textContent = index + 1;
        made.classList.toggle("selected", index === scene.state.selected);
        made.setAttribute("aria-label", `Keyframe ${index + 1} at ${Explore.numbers.with(t[index], "s")}`);
        made.title = scene.fixed ? "" : "Drag, or use the left and right keys, to change the time; Delete removes";
      });
    },
  };
};
