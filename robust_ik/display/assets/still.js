(function () {
  const viewer = openScene(document.getElementById("pane"));
  if (!viewer) return;
  const commands = JSON.parse(document.getElementById("data").textContent);
  commands.forEach((command) => viewer.handle_command_bytearray(bytesOf(command)));
})();
