// The bar at the top, and the cutting planes.

function options(select, names, chosen) {
  select.replaceChildren(...names.map((name) => new Option(name, name, false, name === chosen)));
}

function fillControls() {
  const { scene } = state;
  byId("name").textContent = scene.name;
  document.title = `${scene.name} · shotline`;
  options(byId("look"), scene.looks.map((look) => look.name), state.look);
  options(byId("accel"), scene.accels, state.accel);
  options(byId("versus"), scene.accels, state.versus ?? otherAccel());
  options(byId("counter"), scene.counters, state.counter);
  options(byId("view"), ["", ...scene.views], "");
}

const otherAccel = () => state.scene.accels.find((name) => name !== state.accel && name === "grid") ?? state.scene.accels[0];

function showControls() {
  const isCost = state.look === "cost" || state.versus !== null;
  byId("counter-label").hidden = !isCost;
  byId("versus-label").hidden = state.versus === null;
  byId("compare").setAttribute("aria-pressed", String(state.versus !== null));
  byId("look").disabled = state.versus !== null;
  captionPanes();
  markObjects();
  drawOverlays();
}

function setPlane(plane, change) {
  Object.assign(plane, change);
  const [min, max] = state.scene.bounds;
  plane.height = Math.max(min[plane.axis], Math.min(max[plane.axis], plane.height));
  showPlane(plane);
  drawOverlays();
  changed();
}

function showPlane(plane) {
  const [min, max] = state.scene.bounds;
  const { axis, side } = plane;
  plane.range.value = ((plane.height - min[axis]) / (max[axis] - min[axis] || 1)) * 1000;
  plane.output.textContent = `without ${"xyz"[axis]} ${side > 0 ? ">" : "<"} ${withUnit(short(plane.height))}`;
}

function addPlane() {
  if (!state.scene.bounds) return;
  const [min, max] = state.scene.bounds;
  const { forward } = basis(state.camera);
  // Across the axis that points most towards the eye, so that the cut is seen.
  const axis = [0, 1, 2].reduce((best, i) => (Math.abs(forward[i]) > Math.abs(forward[best]) ? i : best), 0);
  const plane = { axis, side: forward[axis] > 0 ? -1 : 1, height: (min[axis] + max[axis]) / 2 };
  const row = document.createElement("div");
  row.className = "clip";
  const choice = document.createElement("select");
  choice.setAttribute("aria-label", "Axis of the cut");
  options(choice, ["x", "y", "z"], "xyz"[axis]);
  plane.range = Object.assign(document.createElement("input"), { type: "range", min: 0, max: 1000 });
  plane.range.setAttribute("aria-label", "Height of the cut");
  const flip = Object.assign(document.createElement("button"), { textContent: "⇄", title: "Cut the other side away" });
  const remove = Object.assign(document.createElement("button"), { textContent: "×", title: "Remove the cut" });
  plane.output = document.createElement("output");
  row.append(choice, plane.range, flip, remove, plane.output);
  byId("clips").append(row);
  choice.addEventListener("change", () => {
    const next = "xyz".indexOf(choice.value);
    setPlane(plane, { axis: next, height: (state.scene.bounds[0][next] + state.scene.bounds[1][next]) / 2 });
  });
  plane.range.addEventListener("input", () => {
    const [low, high] = state.scene.bounds.map((corner) => corner[plane.axis]);
    setPlane(plane, { height: low + ((high - low) * Number(plane.range.value)) / 1000 });
  });
  flip.addEventListener("click", () => setPlane(plane, { side: -plane.side }));
  remove.addEventListener("click", () => {
    state.planes = state.planes.filter((other) => other !== plane);
    row.remove();
    drawOverlays();
    changed();
  });
  state.planes.push(plane);
  setPlane(plane, {});
}

function closeOpen() {
  if (!byId("help").hidden) byId("help").hidden = true;
  else if (slice.isOpen) openSlice(false);
  else if (state.ray) closeRay();
}

function fillHelp() {
  const table = document.createElement("table");
  for (const [keys, what] of KEYS) {
    const row = table.insertRow();
    const kbd = document.createElement("kbd");
    kbd.textContent = keys;
    row.insertCell().append(kbd);
    row.insertCell().textContent = what;
  }
  byId("help").replaceChildren(table);
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  try { localStorage.setItem("theme", theme); } catch { /* private windows have no storage */ }
}

function connectControls() {
  let stored = null;
  try { stored = localStorage.getItem("theme"); } catch { /* as above */ }
  setTheme(stored ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
  const choose = (id, key) => byId(id).addEventListener("change", (event) => { state[key] = event.target.value; changed(); });
  choose("look", "look");
  choose("counter", "counter");
  choose("versus", "versus");
  byId("accel").addEventListener("change", (event) => {
    state.accel = event.target.value;
    if (state.step !== null) trace();
    changed();
  });
  byId("view").addEventListener("change", (event) => { if (event.target.value) showView(event.target.value); event.target.value = ""; });
  byId("frame").addEventListener("click", () => showView());
  byId("compare").addEventListener("click", () => { state.versus = state.versus === null ? byId("versus").value : null; changed(); });
  byId("clip-add").addEventListener("click", addPlane);
  byId("theme").addEventListener("click", () => setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
  byId("help-button").addEventListener("click", () => { byId("help").hidden = !byId("help").hidden; });
  byId("tree-button").addEventListener("click", () => {
    const isClosed = document.body.classList.toggle("no-side");
    byId("tree-button").setAttribute("aria-expanded", String(!isClosed));
    changed();
  });
  byId("show-all").addEventListener("click", () => { state.only = null; state.hidden.clear(); changed(); });
  byId("search").addEventListener("input", () => fillTree());
  document.addEventListener("keydown", onKey);
  fillHelp();
}
