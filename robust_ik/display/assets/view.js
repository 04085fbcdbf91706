/* The live page. It draws what it is told and sends what its reader does; it knows no kinematics. */
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const viewer = openScene(document.getElementById("pane"));
  const at = (id) => document.getElementById(id);
  const n = data.joints.length;
  let state = null;
  let degrees = true;
  let socket = null;
  if (viewer) viewer.connect();
  document.body.classList.toggle("without-view", !viewer);
  followLegend(viewer, data.nodes);

  /* -------------------------------------------------------------------------------- to and from the program */
  function connect() {
    socket = new WebSocket(`ws://${location.host}/control${location.search}`);
    socket.onmessage = (event) => {
      const told = JSON.parse(event.data);
      if (told.kind === "state") show(told);
      else showFamilies(told);
    };
    socket.onclose = () => { at("gone").hidden = false; document.body.classList.add("ended"); };
  }
  function send(command, values) {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ do: command, ...values }));
  }
  /* What a reader drags is sent once a frame at most, the newest values only. */
  const waiting = new Map();
  function sendSoon(key, command, values) {
    if (waiting.size === 0) requestAnimationFrame(() => {
      const all = [...waiting.values()];
      waiting.clear();
      all.forEach(([name, each]) => send(name, each));
    });
    waiting.set(key, [command, values]);
  }

  /* -------------------------------------------------------------------------------- small things */
  function made(kind, properties, parent) {
    const element = Object.assign(document.createElement(kind), properties);
    if (parent) parent.append(element);
    return element;
  }
  const spelled = (value, digits) => (value === null ? "∞" : Number(value).toPrecision(digits));
  const shown = (joint, value) => (data.turning[joint] && degrees ? (value * 180) / Math.PI : value);
  const meant = (joint, value) => (data.turning[joint] && degrees ? (value * Math.PI) / 180 : value);
  const unitOf = (joint) => (data.turning[joint] ? (degrees ? "°" : " rad") : " m");
  const busy = (input) => document.activeElement === input;

  /* -------------------------------------------------------------------------------- joints */
  const joints = data.joints.map((name, joint) => {
    const row = made("div", { className: "joint" }, at("joints"));
    const label = made("label", { textContent: name, title: name, htmlFor: `slide${joint}` }, row);
    const slide = made("input", { type: "range", id: `slide${joint}`, step: "any" }, row);
    const typed = made("input", { type: "number", step: "any" }, row);
    typed.setAttribute("aria-label", `${name}, value`);
    const ends = made("small", {}, row);
    const [low, high] = [made("span", {}, ends), made("span", {}, ends)];
    const reach = data.turning[joint] ? Math.PI : 2 * data.size;
    slide.min = data.lower[joint] === null ? -reach : data.lower[joint];
    slide.max = data.upper[joint] === null ? reach : data.upper[joint];
    slide.addEventListener("input", () => sendSoon(`joint${joint}`, "joint", { index: joint, value: Number(slide.value) }));
    slide.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!way || !state) return;
      event.preventDefault();
      const step = (event.shiftKey ? 0.1 : 1) * (data.turning[joint] ? Math.PI / 180 : 0.01);
      sendSoon(`joint${joint}`, "joint", { index: joint, value: state.values[joint] + way * step });
    });
    typed.addEventListener("change", () => {
      if (typed.value !== "") send("joint", { index: joint, value: meant(joint, Number(typed.value)) });
    });
    return { row, label, slide, typed, low, high };
  });
  function showUnits() {
    joints.forEach(({ low, high }, joint) => {
      const end = (value) => (value === null ? "no limit" : `${Number(shown(joint, value).toFixed(3))}${unitOf(joint)}`);
      low.textContent = end(data.lower[joint]);
      high.textContent = end(data.upper[joint]);
    });
    at("unit").textContent = degrees ? "degrees" : "radians";
  }
  at("unit").addEventListener("click", () => {
    degrees = !degrees;
    at("unit").setAttribute("aria-pressed", degrees);
    showUnits();
    if (state) show(state);
  });
  at("rest").addEventListener("click", () => send("rest", {}));

  /* -------------------------------------------------------------------------------- tool */
  const fields = {};
  for (const [kind, name] of [["position", "position, m"], ["rotation", "axis · angle"]]) {
    const row = made("div", { className: "numbers" }, at("tool"));
    made("span", { textContent: name, title: kind === "rotation" ? "axis times angle, in radians" : "" }, row);
    fields[kind] = ["x", "y", "z"].map((axis) => {
      const field = made("input", { type: "number", step: "any" }, row);
      field.setAttribute("aria-label", `${kind} ${axis}`);
      field.addEventListener("change", () => {
        const values = fields[kind].map((each) => Number(each.value));
        send(kind, { values });
      });
      return field;
    });
  }
  at("target").addEventListener("keydown", (event) => {
    const way = {
      ArrowUp: [1, 0, 0], ArrowDown: [-1, 0, 0], ArrowLeft: [0, 1, 0], ArrowRight: [0, -1, 0],
      PageUp: [0, 0, 1], PageDown: [0, 0, -1],
    }[event.key];
    if (!way || !state) return;
    event.preventDefault();
    const step = data.size * (event.shiftKey ? 0.001 : 0.01);
    sendSoon("target", "position", { values: state.kept.map((value, axis) => value + step * way[axis]) });
  });
  /* The ball is dragged in the plane through it that faces the camera. MeshCat's y is up: (x, z, −y). */
  function dragTarget(pane) {
    const THREE = MeshCat.THREE;
    const place = () => new THREE.Vector3(state.kept[0], state.kept[2], -state.kept[1]).project(viewer.camera);
    const pointer = (event) => {
      const box = pane.getBoundingClientRect();
      return [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height, box];
    };
    let depth = null;
    pane.addEventListener("pointerdown", (event) => {
      if (!state) return;
      const ball = place();
      const [x, y, box] = pointer(event);
      if (Math.hypot(((x - ball.x) * box.width) / 2, ((y - ball.y) * box.height) / 2) > 22) return;
      depth = ball.z;
      pane.setPointerCapture(event.pointerId);
      event.stopPropagation();
      event.preventDefault();
    }, true);
    pane.addEventListener("pointermove", (event) => {
      if (depth === null) return;
      event.stopPropagation();
      const [x, y] = pointer(event);
      const to = new THREE.Vector3(x, y, depth).unproject(viewer.camera);
      sendSoon("target", "position", { values: [to.x, -to.z, to.y] });
    }, true);
    for (const end of ["pointerup", "pointercancel"]) {
      pane.addEventListener(end, (event) => { if (depth !== null) event.stopPropagation(); depth = null; }, true);
    }
  }
  if (viewer) dragTarget(at("pane"));

  /* -------------------------------------------------------------------------------- inverse */
  const inverse = at("inverse");
  data.inverses.forEach(({ name }) => made("option", { value: name, textContent: name }, inverse));
  function chooseInverse() {
    const kind = data.inverses.find(({ name }) => name === inverse.value);
    const typed = {};
    at("parameters").replaceChildren();
    const tell = () => send("inverse", {
      name: kind.name,
      parameters: Object.fromEntries(Object.entries(typed).map(([name, field]) => [name, Number(field.value)])),
    });
    for (const [name, value] of Object.entries(kind.parameters)) {
      const label = made("label", { textContent: `${name} ` }, at("parameters"));
      typed[name] = made("input", { type: "number", step: "any", value }, label);
      typed[name].addEventListener("change", tell);
    }
    return tell;
  }
  inverse.value = "JParse";
  chooseInverse();
  inverse.addEventListener("change", () => chooseInverse()());

  /* -------------------------------------------------------------------------------- what it is told */
  function show(told) {
    const still = state === null || state.still !== told.still;
    /* What was nearest is told a little later: until then the last words stay. */
    const nearby = told.nearby || (state && state.nearby);
    state = { ...told, nearby };
    at("said").textContent = told.said;
    joints.forEach(({ row, slide, typed }, joint) => {
      if (!busy(slide) || !slide.matches(":active")) slide.value = told.values[joint];
      if (!busy(typed)) typed.value = Number(shown(joint, told.values[joint]).toFixed(4));
      row.classList.toggle("near", told.room[joint] < 0.05);
    });
    for (const kind of ["position", "rotation"]) {
      fields[kind].forEach((field, axis) => { if (!busy(field)) field.value = Number(told[kind][axis].toFixed(5)); });
    }
    at("where").textContent = told.kept.map((value) => value.toFixed(3)).join(", ");
    showSigma(told);
    if (still) showSelfMotions(told.still);
    showNearby(nearby);
    showSolutions(told.solutions);
  }
  function showSigma(told) {
    const largest = Math.max(told.sigma[0], 1e-300);
    at("sigma").replaceChildren(...told.sigma.flatMap((sigma, place) => {
      const weak = told.weak.some(([each]) => each === sigma);
      const name = made("span", { textContent: `σ${place + 1}` });
      const cell = made("span", { className: weak ? "weak" : "" });
      const track = made("div", { className: "track" }, cell);
      made("div", { className: "bar" }, track).style.width = `${(100 * sigma) / largest}%`;
      if (told.threshold !== null) made("i", { className: "limit" }, track).style.left = `${(100 * told.threshold) / largest}%`;
      const share = told.shares ? `${Math.round(100 * told.shares[place])} % is made` : "";
      return [name, cell, made("span", { className: "value", textContent: spelled(sigma, 3) }),
        made("span", { className: "share", textContent: share })];
    }));
    const exact = told.threshold === null ? "nowhere exact" : `exact above σ = ${spelled(told.threshold, 3)}`;
    at("measures").textContent = `${inverse.value}: ${exact}. Manipulability ${spelled(told.manipulability, 3)}, ` +
      `condition number ${spelled(told.condition, 4)}, corank ${told.corank}.`;
    at("weak").replaceChildren(...told.weak.map(([sigma, words]) =>
      made("li", { textContent: `${words}: ${sigma <= 1e-9 * largest ? "lost" : "slowed down"}, σ ${spelled(sigma, 3)}` })));
  }
  function showSelfMotions(count) {
    at("still").textContent = count ? "The tool stands still while the arm moves." : "None here: every joint motion moves the tool.";
    at("self").replaceChildren();
    for (let index = 0; index < count; index += 1) {
      const row = made("div", { className: "joint" }, at("self"));
      made("label", { textContent: `self-motion ${index + 1}`, htmlFor: `self${index}` }, row);
      const slide = made("input", { type: "range", id: `self${index}`, min: -3.2, max: 3.2, step: 0.02, value: 0 }, row);
      let last = 0;
      slide.addEventListener("input", () => {
        const by = Number(slide.value) - last;
        last = Number(slide.value);
        send("self_motion", { index, by });
      });
    }
  }
  function showNearby(nearby) {
    if (!nearby) return;
    const lost = nearby.lost ? ` Lost there: ${nearby.lost}.` : "";
    const far = nearby.distance < 1e-6 ? "The arm is on it" : `${spelled(nearby.distance, 3)} rad away`;
    at("nearby").textContent = `${nearby.words}: ${far}.${lost}`;
    [...at("families").children].forEach((row, index) => row.classList.toggle("here", index === nearby.index));
  }
  function showFamilies(told) {
    at("searched").value = told.searched;
    at("searched").hidden = told.searched >= 1;
    at("note").textContent = told.note || (told.searched < 1 ? "They are being searched; the arm can be moved meanwhile." : "");
    if (told.searched >= 1 && !told.families.length) at("nearby").textContent = "None is known.";
    at("families").replaceChildren(...told.families.map(({ words, corank, within, lost }, index) => {
      const row = made("li", {});
      const button = made("button", { type: "button", textContent: words, title: lost }, row);
      made("span", { className: "out", textContent: ` corank ${corank}${within ? "" : ", beyond joint limits"}` }, row);
      button.addEventListener("click", () => send("family", { index }));
      return row;
    }));
    if (state) showNearby(state.nearby);
  }
  at("solutions").addEventListener("click", () => send("solutions", {}));
  function showSolutions(found) {
    at("status").textContent = found ? `${found.away.length} within limits, ${found.beyond} beyond. ${found.status}` : "";
    const rows = found ? found.away.map((away, index) => {
      const row = made("li", {});
      const words = `${spelled(away, 3)} rad away${found.singular[index] ? ", singular" : ""}`;
      const button = made("button", { type: "button", textContent: words }, row);
      button.addEventListener("click", () => send("solution", { index }));
      return row;
    }) : [];
    at("found").replaceChildren(...rows);
  }

  /* -------------------------------------------------------------------------------- to take along */
  function copy(text) {
    at("copied").hidden = false;
    at("copied").value = text;
    at("copied").select();
    if (navigator.clipboard) navigator.clipboard.writeText(text).catch(() => {});
  }
  at("python").addEventListener("click", () => copy(
    `q = np.array([${state.q.join(", ")}])\nposition = np.array([${state.position.join(", ")}])\n` +
    `rotation_vector = np.array([${state.rotation.join(", ")}])`));
  at("json").addEventListener("click", () => copy(JSON.stringify({
    robot: data.name, joints: data.joints, q: state.q, position: state.position, rotation_vector: state.rotation,
  })));

  showUnits();
  connect();
})();
