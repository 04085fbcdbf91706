(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const viewer = openScene(document.getElementById("pane"));
  const player = openPlayer(viewer, onTime);
  const caption = document.getElementById("caption");
  const buttons = [...document.querySelectorAll("button[data-row]")];
  const motions = [...document.querySelectorAll("[data-motion]")];
  let current = -1;
  let kind = "walk";

  if (viewer) data.scene.forEach((command) => viewer.handle_command_bytearray(bytesOf(command)));
  for (const row of data.rows) {
    for (const motion of Object.values(row)) motion.values = new Float32Array(bytesOf(motion.values).buffer);
  }

  function choose(index, wanted) {
    current = index;
    kind = wanted;
    const motion = data.rows[index][kind];
    document.querySelectorAll("tr[data-row]").forEach((row) =>
      row.classList.toggle("current", Number(row.dataset.row) === index));
    buttons.forEach((button, i) => {
      button.setAttribute("aria-expanded", i === index);
      document.getElementById(button.getAttribute("aria-controls")).hidden = i !== index;
    });
    motions.forEach((button) => button.setAttribute("aria-pressed", button.dataset.motion === kind));
    caption.replaceChildren(...[buttons[index].textContent, motion.caption].map((text, i) => {
      const line = document.createElement(i ? "span" : "strong");
      line.textContent = text;
      return line;
    }));
    if (viewer) {
      data.rows.forEach((row, i) => Object.entries(row).forEach(([name, each]) =>
        viewer.set_property(each.trail, "visible", i === index && name === kind)));
    }
    player.start(motion.animation, motion.duration, 0);
  }

  /* Joint values and dots on curves follow the robot. */
  function onTime(time) {
    const motion = data.rows[current][kind];
    const n = data.units.length;
    const last = motion.values.length / n - 1;
    const place = Math.min(last, (time / motion.duration) * last);
    const before = Math.min(Math.floor(place), last - 1);
    const now = data.units.map((_, joint) => {
      const [a, b] = [motion.values[before * n + joint], motion.values[(before + 1) * n + joint]];
      return a + (place - before) * (b - a);
    });
    const card = document.getElementById(buttons[current].getAttribute("aria-controls"));
    card.querySelectorAll("output[data-joint]").forEach((output) => {
      const joint = Number(output.dataset.joint);
      const value = data.turning[joint] ? turned(now[joint], "°") : now[joint];
      output.textContent = spoken(value, data.units[joint]);
    });
    card.querySelectorAll(".now").forEach((dot) => {
      const joints = dot.dataset.joints.split(" ").map(Number);
      const side = dot.ownerSVGElement.viewBox.baseVal.width;
      const [x, y] = [dot.dataset.x, dot.dataset.y].map((ends, i) => {
        const [low, high] = ends.split(" ").map(Number);
        return (turned(now[joints[i]], data.units[joints[i]]) - low) / (high - low);
      });
      dot.setAttribute("cx", side * x);
      dot.setAttribute("cy", side * (1 - y));
    });
  }

  function turned(value, unit) {
    return unit === "°" ? value - 360 * Math.floor((value + 180) / 360) : value;
  }

  function spoken(value, unit) {
    const text = unit === "°" ? `${value.toFixed(1)}°` : `${value.toFixed(3)} ${unit}`;
    return (/^-0\.0*\D*$/.test(text) ? text.slice(1) : text).replace("-", "−");
  }

  /* #row=NUMBER&motion=walk|sway&t=SECONDS */
  function followAddress() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    const row = Number.parseInt(wanted.get("row"), 10) - 1;
    const motion = wanted.get("motion") === "sway" ? "sway" : "walk";
    if (row in data.rows) choose(row, motion);
    else if (current < 0) choose(0, motion);
    if (row in data.rows) bringIntoSight(buttons[row].closest("tr"));
    const time = Number.parseFloat(wanted.get("t"));
    if (Number.isFinite(time)) {
      player.setPlaying(false);
      player.seek(time);
    }
  }

  /* Scrolls the side beside the view only: on a narrow screen the view itself must stay where it is. */
  function bringIntoSight(row) {
    const side = row.closest("aside");
    const [inner, outer] = [row.getBoundingClientRect(), side.getBoundingClientRect()];
    if (inner.top < outer.top || inner.bottom + outer.height / 3 > outer.bottom) side.scrollTop += inner.top - outer.top - 60;
  }

  function chosen(index, wanted) {
    choose(index, wanted);
    history.replaceState(null, "", `#${new URLSearchParams({ row: index + 1, motion: wanted })}`);
  }

  followLegend(viewer, data.groups);
  if (data.rows.length === 0) return;
  document.querySelectorAll("tr.family").forEach((row) =>
    row.addEventListener("click", () => chosen(Number(row.dataset.row), "walk")));
  motions.forEach((button) => button.addEventListener("click", () => chosen(current, button.dataset.motion)));
  window.addEventListener("hashchange", followAddress);
  followAddress();
})();
