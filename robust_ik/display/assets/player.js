/* What plays in a viewer, with the button, slider and clock that tell and set its time.
   Without WebGL the page still tells its numbers: the same calls, on nothing. */
function openPlayer(viewer, onTime) {
  const button = document.getElementById("play");
  const slider = document.getElementById("time");
  const clock = document.getElementById("clock");
  const animator = viewer ? viewer.animator : { time: 0, playing: false };
  const player = { duration: 0, started: false, seek, setPlaying, start };
  let shown = -1;

  document.body.classList.toggle("without-view", !viewer);

  /* Goes on where and as it was; the first time from the beginning. */
  function start(animation, duration, from) {
    const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    const { time, playing } = player.started ? animator : { time: 0, playing: !calm };
    player.started = true;
    player.duration = duration;
    slider.max = duration;
    if (!viewer) return;
    viewer.handle_command_bytearray(bytesOf(animation));
    seek(from === undefined ? time : from);
    setPlaying(playing);
  }

  function seek(time) {
    const bounded = Math.min(Math.max(time, 0), player.duration);
    if (viewer) animator.seek(bounded);
    animator.time = bounded;
    shown = -1;
  }

  function setPlaying(playing) {
    if (viewer && playing !== animator.playing) playing ? animator.play() : animator.pause();
    button.classList.toggle("playing", playing);
  }

  function tick() {
    requestAnimationFrame(tick);
    const time = animator.time;
    if (time === shown || !player.started) return;
    shown = time;
    slider.value = time;
    clock.textContent = `${time.toFixed(2)} s`;
    onTime(time);
  }

  button.addEventListener("click", () => setPlaying(!animator.playing));
  slider.addEventListener("input", () => { setPlaying(false); seek(Number(slider.value)); });
  requestAnimationFrame(tick);
  return player;
}

/* Entries of the legend hide and show what they name. */
function followLegend(viewer, groups) {
  document.querySelectorAll("[data-group]").forEach((button) =>
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      document.querySelectorAll(`[data-group="${button.dataset.group}"]`).forEach((entry) =>
        entry.setAttribute("aria-pressed", on));
      if (viewer) {
        viewer.set_property(groups[button.dataset.group], "visible", on);
        viewer.set_dirty();
      }
    }));
}
