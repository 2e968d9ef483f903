"use strict";
/** The page's parts; each file adds one. */
const Explore = {};

/** Light or dark: as the system says, until the button is pressed. */
Explore.theme = (() => {
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");
  const listeners = [];
  let colours = {};

  function set(name) {
    root.dataset.theme = name;
    colours = {};
    listeners.forEach((listener) => listener());
  }

  system.addEventListener("change", () => set(system.matches ? "dark" : "light"));
  set(system.matches ? "dark" : "light");

  return {
    toggle: () => set(root.dataset.theme === "dark" ? "light" : "dark"),
    whenChanged: (listener) => listeners.push(listener),
    /** Value of a custom property of the style sheet, such as a colour. */
    colour(name) {
      colours[name] ??= getComputedStyle(root).getPropertyValue(`--${name}`).trim();
      return colours[name];
    },
    stillness: matchMedia("(prefers-reduced-motion: reduce)"),
  };
})();
