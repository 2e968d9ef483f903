"use strict";
/** Pieces of the panel: sliders with names and units, buttons, choices. */
Explore.controls = (() => {
  function element(name, properties = {}, ...children) {
    const made = document.createElement(name);
    Object.assign(made, properties);
    made.append(...children);
    return made;
  }

  /** A slider; `changed(value)` may answer with what to say about a limit. Its `write(value)` shows a value. */
  function slider({ id, name, unit, range }, app, changed) {
    const input = element("input", { type: "range", id, ...range });
    const output = element("output");
    output.htmlFor = id;
    const label = element("label", { htmlFor: id, textContent: name });
    const row = element("div", { className: "row" }, label, input, output);
    const write = (value) => {
      input.value = value;
      output.textContent = Explore.numbers.with(value, unit);
      input.setAttribute("aria-valuetext", output.textContent);
    };
    input.addEventListener("input", () => {
      app.touched();
      app.status.say("limit", changed(Number(input.value)) ?? "");
      app.changed();
    });
    return { row, write, input };
  }

  const group = (title, style, ...rows) =>
    element("fieldset", { className: style }, element("legend", { textContent: title }), ...rows);

  function button(text, label, pressed, id = "") {
    const made = element("button", { type: "button", textContent: text, title: label, id });
    made.setAttribute("aria-label", label);
    made.addEventListener("click", pressed);
    return made;
  }

  function choice(id, name, options, changed) {
    const made = Object.entries(options).map(([value, textContent]) => element("option", { value, textContent }));
    const select = element("select", { id }, ...made);
    select.addEventListener("change", () => changed(select.value));
    const label = element("label", { htmlFor: id, textContent: name });
    return { row: element("div", { className: "row" }, label, select), select };
  }

  return { element, slider, group, button, choice };
})();
