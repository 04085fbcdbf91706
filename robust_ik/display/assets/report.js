(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const viewer = openScene(document.getElementById("pane"));
  const player = openPlayer(viewer, onTime);
  const charts = [...document.querySelectorAll(".chart")];
  const longest = Math.max(...data.runs.map((run) => run.duration)) || 1;
  let current = -1;

  if (viewer) data.scene.forEach((command) => viewer.handle_command_bytearray(bytesOf(command)));

  function choose(index) {
    current = index;
    mark("[data-run]", (element) => Number(element.dataset.run) === index);
    document.querySelectorAll(".chart").forEach((chart) =>
      chart.querySelectorAll("polyline").forEach((line, i) => line.classList.toggle("current", i === index)));
    const color = document.querySelector(`.methods [data-run="${index}"] .swatch`).style.background;
    document.documentElement.style.setProperty("--current", color);
    if (viewer) data.runs.forEach((run, i) => viewer.set_property(run.trail, "visible", i === index));
    player.start(data.runs[index].animation, data.runs[index].duration);
  }

  function mark(selector, isCurrent) {
    document.querySelectorAll(selector).forEach((element) => {
      element.classList.toggle("current", isCurrent(element));
      if (element.tagName === "BUTTON") element.setAttribute("aria-pressed", isCurrent(element));
    });
  }

  /* The trail is drawn as far as the tip has come. */
  function growTrail(run, time) {
    const geometry = viewer.scene_tree.find([...run.trail, "<object>"]).object.geometry;
    const share = run.duration > 0 ? time / run.duration : 1;
    const perFrame = geometry.index.count / (run.frames - 1);
    geometry.setDrawRange(0, perFrame * Math.round(share * (run.frames - 1)));
    viewer.set_dirty();
  }

  function onTime(time) {
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
    player.setPlaying(false);
    player.seek(longest * ((share - Number(chart.dataset.left)) / Number(chart.dataset.width)));
  }

  /* #method=NAME&t=SECONDS */
  function followAddress() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    const index = data.runs.findIndex((run) => run.name === wanted.get("method"));
    if (index >= 0 || current < 0) choose(Math.max(index, 0));
    const time = Number.parseFloat(wanted.get("t"));
    if (Number.isFinite(time)) {
      player.setPlaying(false);
      player.seek(time);
    }
  }

  document.querySelectorAll(".methods [data-run]").forEach((button) =>
    button.addEventListener("click", () => {
      choose(Number(button.dataset.run));
      const address = new URLSearchParams({ method: data.runs[current].name });
      history.replaceState(null, "", `#${address}`);
    }));
  followLegend(viewer, data.groups);
  charts.forEach((chart) => chart.addEventListener("pointerdown", (event) => seekInChart(chart, event)));
  window.addEventListener("hashchange", followAddress);
  followAddress();
})();
