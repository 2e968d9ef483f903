"use strict";
/** Numbers with three digits and their units. */
Explore.numbers = (() => {
  const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const power = (n) => `10${n < 0 ? "⁻" : ""}${[...String(Math.abs(n))].map((digit) => RAISED[digit]).join("")}`;

  function three(x) {
    if (Math.abs(x) < 1e-9) return "0.00";
    const rounded = Math.abs(Number(x.toPrecision(3)));
    const order = Math.floor(Math.log10(rounded) + 1e-12);
    const digits = order < -3 || order > 4
      ? `${(rounded / 10 ** order).toFixed(2)} × ${power(order)}`
      : rounded.toFixed(Math.max(0, 2 - order));
    return `${x < 0 ? "−" : ""}${digits}`;
  }

  return {
    three,
    with: (x, unit) => `${three(x)} ${unit}`,
  };
})();
