"use strict";

/* A meshcat viewer that fills its pane, keeps everything in sight and understands shared geometry. */
function openScene(pane) {
  let viewer;
  try {
    viewer = new MeshCat.Viewer(pane);
  } catch (error) {
    const note = document.createElement("p");
    note.className = "failure";
    note.textContent = "The 3D view needs WebGL, which this browser does not offer.";
    pane.replaceChildren(note);
    console.warn(error);
    return null;
  }
  keepSize(viewer, pane);
  const frame = keepInSight(viewer, pane);
  understandCommands(viewer, frame);
  calmLight(viewer);
  followTheme(viewer);
  return viewer;
}

/* The stock viewer takes the height of the window. */
function keepSize(viewer, pane) {
  const resize = viewer.set_3d_pane_size.bind(viewer);
  viewer.set_3d_pane_size = () => resize(Math.max(pane.clientWidth, 1), Math.max(pane.clientHeight, 1));
  new ResizeObserver(() => viewer.set_3d_pane_size()).observe(pane);
  viewer.set_3d_pane_size();
}

/* Places the camera so that a ball fits the pane, whatever its shape, until the reader turns the scene. */
function keepInSight(viewer, pane) {
  let view = null;
  let touched = false;
  let controls = null;
  function frame() {
    if (!view) return;
    const [x, y, z, radius, dx, dy, dz] = view;
    const camera = viewer.camera;
    const aspect = pane.clientWidth / Math.max(pane.clientHeight, 1);
    const half = Math.atan(Math.tan((camera.fov * Math.PI) / 360) * Math.min(1, aspect));
    const distance = radius / Math.sin(half);
    camera.near = distance / 200;
    camera.far = distance * 200;
    camera.position.set(x + distance * dx, z + distance * dz, -(y + distance * dy));
    viewer.controls.target.set(x, z, -y);
    viewer.controls.update();
    viewer.set_dirty();
    if (controls !== viewer.controls) {
      controls = viewer.controls;
      controls.addEventListener("start", () => { touched = true; });
    }
  }
  new ResizeObserver(() => { if (!touched) frame(); }).observe(pane);
  pane.addEventListener("dblclick", () => { touched = false; frame(); });
  return (wanted) => { view = wanted; touched = false; frame(); };
}

/* Two things that the stock viewer does not know: where to look, and geometry that several objects show. */
function understandCommands(viewer, frame) {
  const shared = new Map();
  const handle = viewer.handle_command.bind(viewer);
  viewer.handle_command = (command) => {
    if (command.type === "share_geometry") {
      shared.set(command.key, command.geometry);
      return;
    }
    if (command.type === "set_object" && command.object.geometries) {
      command.object.geometries = command.object.geometries.map((geometry) =>
        "shared" in geometry ? { ...shared.get(geometry.shared), uuid: geometry.uuid } : geometry);
    }
    handle(command);
    if (command.type === "set_property" && command.property === "view") frame(command.value);
  };
}

/* Less light from everywhere and some from beside the camera, so that both white and black robots keep their shape. */
function calmLight(viewer) {
  const strength = { AmbientLight: 0.35, FillLight: 0.12, PointLightNegativeX: 0.16, PointLightPositiveX: 0.24 };
  for (const [light, value] of Object.entries(strength)) {
    viewer.set_property(["Lights", light, "<object>"], "intensity", value);
  }
  const lamp = new MeshCat.THREE.DirectionalLight(0xffffff, 0.4);
  lamp.position.set(-0.7, 0.9, 0.6);
  lamp.target.position.set(0, 0, -1);
  viewer.camera.add(lamp, lamp.target);
}

function followTheme(viewer) {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const paint = () => {
    const style = getComputedStyle(document.documentElement);
    for (const end of ["top", "bottom"]) {
      const color = style.getPropertyValue(`--sky-${end}`).trim().split(/\s+/).map(Number);
      viewer.set_property(["Background"], `${end}_color`, color);
    }
  };
  paint();
  dark.addEventListener("change", paint);
}

function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}
