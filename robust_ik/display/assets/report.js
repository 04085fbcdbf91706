(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const viewer = openScene(document.getElementById("pane"));
  const play = document.getElementById("play");
  const slider = document.getElementById("time");
  const clock = document.getElementById("clock");
  const charts = [...document.querySelectorAll(".chart")];
  const longest = Math.max(...data.runs.map((run) => run.duration)) || 1;
  let current = -1;
  let shown = -1;

  /* Without WebGL the page still tells its numbers: the same calls, on nothing. */
  const animator = viewer ? viewer.animator : { time: 0, playing: false };
  document.body.classList.toggle("without-view", !viewer);
  if (viewer) data.scene.forEach((command) => viewer.handle_command_bytearray(bytesOf(command)));

  function choose(index) {
    const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    const { time, playing } = current < 0 ? { time: 0, playing: !calm } : animator;
    current = index;
    mark("[data-run]", (element) => Number(element.dataset.run) === index);
    document.querySelectorAll(".chart").forEach((chart) =>
      chart.querySelectorAll("polyline").forEach((line, i) => line.classList.toggle("current", i === index)));
    const color = document.querySelector(`.methods [data-run="${index}"] .swatch`).style.background;
    document.documentElement.style.setProperty("--current", color);
    slider.max = data.runs[index].duration;
    if (!viewer) return;
    viewer.handle_command_bytearray(bytesOf(data.runs[index].animation));
    data.runs.forEach((run, i) => viewer.set_property(run.trail, "visible", i === index));
    seek(time);
    setPlaying(playing);
  }

  function mark(selector, isCurrent) {
    document.querySelectorAll(selector).forEach((element) => {
      element.classList.toggle("current", isCurrent(element));
      if (element.tagName === "BUTTON") element.setAttribute("aria-pressed", isCurrent(element));
    });
  }

  function seek(time) {
    const bounded = Math.min(Math.max(time, 0), data.runs[current].duration);
    if (viewer) animator.seek(bounded);
    animator.time = bounded;
    shown = -1;
  }

  function setPlaying(playing) {
    if (viewer && playing !== animator.playing) playing ? animator.play() : animator.pause();
    play.classList.toggle("playing", playing);
  }

  /* The trail is drawn as far as the tip has come. */
  function growTrail(run, time) {
    const geometry = viewer.scene_tree.find([...run.trail, "<object>"]).object.geometry;
    const share = run.duration > 0 ? time / run.duration : 1;
    const perFrame = geometry.index.count / (run.frames - 1);
    geometry.setDrawRange(0, perFrame * Math.round(share * (run.frames - 1)));
    viewer.set_dirty();
  }

  function tick() {
    requestAnimationFrame(tick);
    const time = animator.time;
    if (time === shown) return;
    shown = time;
    slider.value = time;
    clock.textContent = `${time.toFixed(2)} s`;
    for (const chart of charts) {
      const width = chart.viewBox.baseVal.width;
      const x = width * (Number(chart.dataset.left) + Number(chart.dataset.width) * (time / longest));
      const cursor = chart.querySelector(".cursor");
      cursor.setAttribute("x1", x);
      cursor.setAttribute("x2", x);
    }
    if (viewer) growTrail(data.runs[current], time);
  }

  function seekInChart(chart, event) {
    const box = chart.getBoundingClientRect();
    const share = (event.clientX - box.left) / box.width;
    setPlaying(false);
    seek(longest * ((share - Number(chart.dataset.left)) / Number(chart.dataset.width)));
  }

  /* #method=NAME&t=SECONDS */
  function followAddress() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    const index = data.runs.findIndex((run) => run.name === wanted.get("method"));
    if (index >= 0 || current < 0) choose(Math.max(index, 0));
    const time = Number.parseFloat(wanted.get("t"));
    if (Number.isFinite(time)) {
      setPlaying(false);
      seek(time);
    }
  }

  document.querySelectorAll(".methods [data-run]").forEach((button) =>
    button.addEventListener("click", () => {
      choose(Number(button.dataset.run));
      const address = new URLSearchParams({ method: data.runs[current].name });
      history.replaceState(null, "", `#${address}`);
    }));
  document.querySelectorAll("[data-group]").forEach((button) =>
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      document.querySelectorAll(`[data-group="${button.dataset.group}"]`).forEach((entry) =>
        entry.setAttribute("aria-pressed", on));
      if (viewer) {
        viewer.set_property(data.groups[button.dataset.group], "visible", on);
        viewer.set_dirty();
      }
    }));
  play.addEventListener("click", () => setPlaying(!animator.playing));
  slider.addEventListener("input", () => { setPlaying(false); seek(Number(slider.value)); });
  charts.forEach((chart) => chart.addEventListener("pointerdown", (event) => seekInChart(chart, event)));
  window.addEventListener("hashchange", followAddress);
  followAddress();
  tick();
})();
