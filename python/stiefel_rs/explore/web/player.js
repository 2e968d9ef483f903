"use strict";
/** The present time, and its run from the start of the curve to its end, again and again. */
Explore.player = (button, clock, rates, app) => {
  // Real seconds for which the end is shown before the curve begins again.
  const REST = 0.6;
  let [time, running, before, rested] = [0, false, null, 0];

  const span = () => app.scene().span();

  function show() {
    clock.textContent = Explore.numbers.with(time, "s");
    button.setAttribute("aria-pressed", running);
    button.setAttribute("aria-label", running ? "Pause" : "Play");
    button.title = `${running ? "Pause" : "Play"} (space)`;
    document.body.dataset.playing = running;
  }

  function step(now) {
    if (!running) return;
    const passed = before === null ? 0 : (now - before) / 1000;
    before = now;
    const [first, last] = span();
    if (time >= last) {
      rested += passed;
      if (rested > REST) [time, rested] = [first, 0];
    } else {
      time = Math.min(last, time + passed * Number(rates.value));
    }
    show();
    app.repaint();
    requestAnimationFrame(step);
  }

  function play() {
    if (running) return;
    if (time >= span()[1]) [time] = span();
    [running, before, rested] = [true, null, 0];
    show();
    requestAnimationFrame(step);
    app.repaint();
  }

  function pause() {
    running = false;
    show();
  }

  button.addEventListener("click", () => {
    if (running) pause();
    else play();
    app.repaint();
  });

  return {
    play, pause,
    playing: () => running,
    time: () => time,
    /** Go to a time; the ends of the curve are as far as it goes. */
    seek(wanted) {
      time = Explore.vectors.clamped(wanted, ...span());
      rested = 0;
      show();
    },
  };
};
