"use strict";
/** Puts the parts together: the scenes, what is computed for them, and what is painted when. */
Explore.app = (() => {
  const $ = (id) => document.getElementById(id);
  const config = JSON.parse($("config").textContent);
  const solver = Explore.solver.for(config);
  const GONE = "The program that computes has ended. Start stiefel-rs explore again.";
  const REQUESTS = 2;
  const FIRST_VIEW = { azimuth: 0.25, elevation: 0.35 };
  const scenes = {};
  const hidden = new Set();
  let [kind, view, answer] = [config.kind, { ...FIRST_VIEW }, null];
  // Time of the first touch that was not asked for yet, in ms, and whether there is something to ask for.
  let [touch, changed] = [null, false];
  // Requests: their number, those without an answer, the number of the one that is shown.
  let [asked, waiting, shown] = [0, 0, -1];

  const app = {
    latency: [],
    info: () => config.kinds[kind],
    scene: () => scenes[kind],
    answer: () => answer,
    view: () => view,
    camera: () => stage.camera(),
    isShown: (name) => !hidden.has(name),
    status: Explore.status($("status")),
    /** The curve of the scene, if there is one. */
    curve() {
      const found = answer?.curves[Object.keys(app.info().curves)[0]];
      return found && !found.error ? found : null;
    },
    /** Called when something is dragged: from here the time to the curve counts. */
    touched() { touch ??= performance.now(); },
    showCurve(name, show) {
      if (show) hidden.delete(name);
      else hidden.add(name);
      app.repaint();
    },
  };

  const stage = Explore.stage($("view"), app);
  const handles = Explore.handles($("handles"), app);
  const strip = Explore.strip($("strip"), app);
  const table = Explore.table($("curves"), app);
  app.player = Explore.player($("play"), $("clock"), $("rate"), app);
  const timeline = Explore.timeline($("track"), app);
  const seek = (time) => {
    app.player.pause();
    app.player.seek(time);
    app.repaint();
  };
  const charts = ["speed", "acceleration", "angle"].map((id) => [id, Explore.charts.chart($(id), seek)]);

  const LOOKS = [{ colour: "main" }, { colour: "other", dash: [6, 4], width: 2 }];

  function paintCharts() {
    if (!answer) return;
    const names = Object.keys(app.info().curves);
    const curves = names.map((name, i) => ({ name, curve: answer.curves[name], look: LOOKS[i] }))
      .filter(({ name, curve }) => app.isShown(name) && !curve.error);
    for (const [id, chart] of charts) {
      const [t, series] = id === "angle"
        ? [answer.angleT, [{ values: answer.angle, colour: "between" }]]
        : [answer.profileT, curves.map(({ curve, look }) => ({ values: curve[id], ...look }))];
      chart.paint(t, series.filter(({ values }) => values), app.player.time());
    }
  }

  /** Paint what is dragged: between two answers the handles are already where the pointer is. */
  function paintScene() {
    stage.paint();
    handles.show(app.scene().handles(stage.camera()));
    strip.paint();
    timeline.paint();
  }

  app.repaint = () => {
    paintScene();
    paintCharts();
  };

  /** Show an answer to what was touched at a time. */
  function receive(found, scene, since) {
    answer = found;
    scene.received(found);
    app.player.seek(app.player.time());
    // The first one: the table says which curves are missing.
    app.status.say("problem", Object.values(found.curves).find(({ error }) => error)?.error);
    app.repaint();
    if (since !== null) app.latency.push(performance.now() - since);
    table.show(answer, $("angle-max"), $("took"));
  }

  async function ask() {
    const [scene, since, number] = [app.scene(), touch, asked];
    [touch, changed] = [null, false];
    asked += 1;
    waiting += 1;
    // A TypeError of fetch: nobody answers.
    const found = await solver.ask(scene.request()).catch((error) => {
      app.status.say("problem", error instanceof TypeError ? GONE : error.message);
    });
    waiting -= 1;
    if (found && scene === app.scene() && number > shown) {
      shown = number;
      receive(found, scene, since);
    }
    refresh();
  }

  /** Ask for the curves of the scene: two requests at a time, so that a drag need not wait for the answer before. */
  async function refresh() {
    document.body.dataset.state = changed || waiting ? "busy" : "ready";
    if (changed && waiting < REQUESTS) await ask();
  }

  app.changed = () => {
    app.scene().write();
    paintScene();
    changed = true;
    return refresh();
  };

  function open(name) {
    kind = name;
    answer = null;
    hidden.clear();
    const scene = app.scene();
    table.open(app.info().curves);
    $("controls").replaceChildren(...scene.panel());
    $("rate").value = String(scene.slow);
    document.body.dataset.kind = name;
    document.body.dataset.family = app.info().family;
    for (const level of ["problem", "limit"]) app.status.say(level, "");
    app.status.say("note", solver.note(name));
    $("spacing").textContent = solver.spacing(name);
    app.status.say("hint", scene.hint);
    app.player.seek(scene.span()[0]);
    return app.changed();
  }

  function reset() {
    app.scene().reset();
    view = { ...FIRST_VIEW };
    return open(kind);
  }

  function buildTabs() {
    const { element } = Explore.controls;
    for (const [name, { title }] of Object.entries(config.kinds)) {
      const input = element("input", { type: "radio", name: "kind", value: name, id: `kind-${name}` });
      input.checked = name === kind;
      input.addEventListener("change", () => open(name));
      $("kinds").append(input, element("label", { htmlFor: input.id, textContent: title }));
    }
  }

  /** Turn the view by dragging beside the handles, or with the arrow keys. */
  function listenToView() {
    const canvas = $("view");
    let from = null;
    const turn = (azimuth, elevation) => {
      const stopped = Explore.camera.turn(view, azimuth, elevation);
      app.status.say("limit", stopped ? "The view is straight above a pole and turns no further." : "");
      app.repaint();
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!from) return;
      const { radius } = stage.camera();
      turn(-(event.clientX - from[0]) / radius, (event.clientY - from[1]) / radius);
      from = [event.clientX, event.clientY];
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { from = null; });
    canvas.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!way) return;
      event.preventDefault();
      turn(0.1 * way[0], 0.1 * way[1]);
    });
  }

  function listen() {
    $("controls").addEventListener("submit", (event) => event.preventDefault());
    $("reset").addEventListener("click", reset);
    $("theme").addEventListener("click", Explore.theme.toggle);
    $("present").addEventListener("click", () => {
      $("present").setAttribute("aria-pressed", document.body.classList.toggle("present"));
      app.repaint();
    });
    document.addEventListener("pointerdown", () => app.status.say("limit", ""), { capture: true });
    Explore.theme.whenChanged(app.repaint);
    new ResizeObserver(app.repaint).observe($("stage"));
    document.addEventListener("keydown", (event) => {
      if (event.key !== " " || event.target.matches("button, input, select, summary")) return;
      event.preventDefault();
      $("play").click();
    });
    listenToView();
  }

  for (const [name, info] of Object.entries(config.kinds)) {
    scenes[name] = Explore[info.family](app, name, info, solver);
    scenes[name].reset();
  }
  buildTabs();
  listen();
  open(kind).then(() => {
    if (!Explore.theme.stillness.matches) app.player.play();
  });
  return app;
})();
