"use strict";
/** The numbers of both curves, and the boxes that show or hide them. */
Explore.table = (body, app) => {
  const { element } = Explore.controls;
  const { three } = Explore.numbers;
  const SVG = ["http:", "", "www.w3.org", "2000", "svg"].join("/");
  const maximum = (values) => values.reduce((most, x) => Math.max(most, x), 0);
  const more = element("small", { id: "excess" });
  let rows = {};

  function swatch(name) {
    const svg = document.createElementNS(SVG, "svg");
    const line = document.createElementNS(SVG, "line");
    const attributes = { x1: 0, x2: 30, y1: 6, y2: 6, class: `line-${name}` };
    Object.entries(attributes).forEach(([key, value]) => line.setAttribute(key, value));
    svg.setAttribute("class", "swatch");
    svg.setAttribute("aria-hidden", "true");
    svg.append(line);
    return svg;
  }

  function row(name, title, place) {
    const box = element("input", { type: "checkbox", id: `show-${name}`, checked: true });
    box.addEventListener("change", () => app.showCurve(name, box.checked));
    const label = element("label", {}, box, swatch(place), element("span", { textContent: title }));
    const cells = ["cost", "length", "speed"].map((what) => element("td", { id: `${what}-${name}` }));
    body.append(element("tr", {}, element("th", { scope: "row" }, label), ...cells));
    return Object.fromEntries(["cost", "length", "speed"].map((what, i) => [what, cells[i]]));
  }

  function write(cells, curve) {
    if (curve.error) {
      Object.values(cells).forEach((cell) => { cell.textContent = "none"; });
      return;
    }
    cells.cost.textContent = curve.cost === null ? "∞" : three(curve.cost);
    cells.cost.title = curve.cost === null ? "The velocity jumps at the keyframes" : "";
    cells.length.textContent = three(curve.length);
    cells.speed.textContent = three(maximum(curve.speed));
  }

  /** By how much the cost of the second curve exceeds that of the first, in percent. */
  function excess([one, other]) {
    if (one.error || other.error || other.cost === null || one.cost < 1e-9) return "";
    const percent = (100 * (other.cost - one.cost)) / one.cost;
    return `${percent >= 0 ? "+" : ""}${three(percent)} %`;
  }

  return {
    open(curves) {
      body.replaceChildren();
      rows = Object.fromEntries(Object.entries(curves).map(([name, title], i) =>
        [name, row(name, title, i ? "other" : "main")]));
      more.textContent = "";
      Object.values(rows)[1].cost.append(more);
    },
    show(answer, largest, took) {
      const names = Object.keys(rows);
      names.forEach((name) => write(rows[name], answer.curves[name]));
      more.textContent = excess(names.map((name) => answer.curves[name]));
      rows[names[1]].cost.append(more);
      largest.textContent = answer.angle ? `at most ${Explore.numbers.with(maximum(answer.angle), "rad")}` : "";
      took.textContent = app.latency.length ? `drag to curve ${three(app.latency[app.latency.length - 1])} ms` : "";
    },
  };
};
