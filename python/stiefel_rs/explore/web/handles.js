"use strict";
/**
 * What can be dragged on the stage: round buttons above the canvas, so that the keyboard reaches them too.
 *
 * A handle is { key, label, place, text, kind, far, move }; `move(place, from)` does what a drag to a place does and
 * returns what to say where it met a limit. `size` is for handles that are larger than others.
 */
Explore.handles = (layer, app) => {
  const STEP = 8;
  const made = new Map();
  let held = null;

  function run(handle, place, from) {
    app.touched();
    const limit = handle.move(place, from) ?? "";
    app.status.say("limit", limit);
    made.get(handle.key)?.element.classList.toggle("limit", Boolean(limit));
    app.changed();
  }

  const position = (event) => {
    const box = layer.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  function press(event, entry) {
    if (event.button !== 0 || held) return;
    const [x, y] = position(event);
    const [hx, hy] = entry.handle.place;
    held = { entry, pointer: event.pointerId, grip: [x - hx, y - hy], last: [hx, hy] };
    entry.element.setPointerCapture(event.pointerId);
    entry.element.classList.add("held");
    entry.element.focus({ preventScroll: true });
    entry.handle.start?.();
    event.preventDefault();
  }

  function drag(event) {
    if (!held || held.pointer !== event.pointerId) return;
    const [x, y] = position(event);
    const place = [x - held.grip[0], y - held.grip[1]];
    const from = held.last;
    held.last = place;
    run(held.entry.handle, place, from);
  }

  function release(event) {
    if (!held || held.pointer !== event.pointerId) return;
    held.entry.element.classList.remove("held", "limit");
    held = null;
  }

  function key(event, entry) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!way) return;
    event.preventDefault();
    const step = event.shiftKey ? 1 : STEP;
    const { place } = entry.handle;
    entry.handle.start?.();
    run(entry.handle, [place[0] + step * way[0], place[1] + step * way[1]], place);
  }

  function make(handle) {
    const element = document.createElement("button");
    element.type = "button";
    element.dataset.key = handle.key;
    const entry = { element, handle };
    element.addEventListener("pointerdown", (event) => press(event, entry));
    element.addEventListener("pointermove", drag);
    element.addEventListener("pointerup", release);
    element.addEventListener("pointercancel", release);
    element.addEventListener("keydown", (event) => key(event, entry));
    element.addEventListener("blur", () => element.classList.remove("limit"));
    layer.append(element);
    made.set(handle.key, entry);
    return entry;
  }

  return {
    /** Show these handles and no others. */
    show(handles) {
      const wanted = new Set(handles.map((handle) => handle.key));
      for (const [name, entry] of made) {
        if (wanted.has(name)) continue;
        if (held?.entry === entry) held = null;
        entry.element.remove();
        made.delete(name);
      }
      for (const handle of handles) {
        const entry = made.get(handle.key) ?? make(handle);
        entry.handle = handle;
        const { element } = entry;
        element.classList.add("handle", ...handle.kind.split(" "));
        element.classList.toggle("far", Boolean(handle.far));
        element.classList.toggle("selected", Boolean(handle.selected));
        element.textContent = handle.text ?? "";
        element.setAttribute("aria-label", handle.label);
        element.title = handle.label;
        if (handle.size) element.style.width = element.style.height = `${handle.size}px`;
        const [x, y] = handle.place;
        element.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
      }
    },
    /** Whether something is being dragged. */
    busy: () => held !== null,
  };
};
