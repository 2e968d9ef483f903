"use strict";
/** The line that says what is wrong, what met a limit, or what can be done here. It has its place, whatever it says. */
Explore.status = (element) => {
  const said = { problem: "", limit: "", note: "", hint: "" };

  function show() {
    const level = Object.keys(said).find((name) => said[name]) ?? "hint";
    if (element.textContent !== said[level]) element.textContent = said[level];
    element.title = said[level];
    element.dataset.level = level;
  }

  return {
    /** Say something at a level; an empty text takes it back. */
    say(level, text) {
      said[level] = text ?? "";
      show();
    },
  };
};
