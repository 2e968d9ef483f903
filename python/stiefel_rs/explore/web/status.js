"use strict";
/** The line that says what is wrong, what met a limit, or what can be done here. It has its place, whatever it says. */
Explore.status = (element) => {
  const said = { problem: "", limit: "", note: "", hint: "" };

  function show() {
    const level = Object.keys(said).find((name) => said[name]) ?? "hint";
    const text = [said.limit, said.problem].filter(Boolean).join(" ") || said[level];
    if (element.textContent !== text) element.textContent = text;
    element.title = text;
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
