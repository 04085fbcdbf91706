(function () {
  const viewer = openScene(document.getElementById("pane"));
  if (viewer) viewer.connect();
})();
