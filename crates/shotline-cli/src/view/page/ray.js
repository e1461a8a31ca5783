// The crossings of a ray, and the steps of the accelerator that finds them.

const vectorText = (v) => v.map(short).join(", ");
const vectorOf = (text) => {
  const numbers = text.split(/[\s,;]+/).filter(Boolean).map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) ? numbers : null;
};

async function shootThrough(pane, [x, y]) {
  const size = sizeOf(pane);
  const scale = size[0] / pane.overlay.clientWidth;
  await shoot({ camera: state.camera, size, at: [x * scale, y * scale] });
}

async function shoot(ray) {
  const begun = performance.now();
  try {
    const { head } = await connection.ask({ ask: "shoot", ray });
    const { ray: { origin, direction }, ...report } = head.answer;
    state.ray = { origin, direction, ...report, chosen: null };
    setTrouble(null);
  } catch (error) {
    setTrouble(error.message);
    return;
  }
  byId("ray").hidden = false;
  byId("ray-from").value = vectorText(state.ray.origin);
  byId("ray-along").value = vectorText(state.ray.direction);
  fillCrossings();
  byId("ray").dataset.ms = String(Math.round(performance.now() - begun));
  if (byId("trace-button").getAttribute("aria-pressed") === "true") await trace();
  drawOverlays();
  changed();
}

function cell(text, isNumber) {
  const td = document.createElement("td");
  td.textContent = text;
  if (isNumber) td.className = "number";
  return td;
}

function fillCrossings() {
  const { crossings, materials, overlaps } = state.ray;
  const total = materials.reduce((sum, material) => sum + (material.length ?? Infinity), 0);
  const summary = crossings.length === 0 ? "the ray crosses nothing" : `${crossings.length} crossings, ${withUnit(short(Number.isFinite(total) ? total : null))} inside`;
  byId("ray-summary").textContent = overlaps.length ? `${summary}, ${overlaps.length} overlaps` : summary;
  const table = document.createElement("table");
  const length = unitOf() ? ` [${unitOf()}]` : "";
  const columns = ["#", `distance${length}`, "", "object", "surface", "material", "path", "x", "y", "z", "normal", "obliquity", `inside so far${length}`];
  const numbers = new Set([0, 1, 7, 8, 9, 11, 12]);
  const header = table.createTHead().insertRow();
  columns.forEach((name, i) => {
    const th = document.createElement("th");
    th.textContent = name;
    if (numbers.has(i)) th.className = "number";
    header.append(th);
  });
  const body = table.createTBody();
  crossings.forEach((crossing, i) => {
    const kind = crossing.kind === "surface" ? "" : ` (${crossing.kind})`;
    const point = crossing.point ?? ["", "", ""];
    const texts = [
      i + 1, short(crossing.distance), (crossing.entering ? "in" : "out") + kind, crossing.object, crossing.surface ?? "",
      crossing.material ?? "", crossing.path, ...point.map((x) => (x === "" ? "" : short(x))),
      crossing.normal ? crossing.normal.map((x) => Number(x.toFixed(3))).join(" ") : "",
      crossing.obliquity === null ? "" : `${crossing.obliquity.toFixed(1)}°`, crossing.thickness === null ? "" : short(crossing.thickness),
    ];
    const row = body.insertRow();
    row.append(...texts.map((text, j) => cell(text, numbers.has(j))));
    const choose = (chosen) => { state.ray.chosen = chosen; drawOverlays(); };
    row.addEventListener("pointerenter", () => choose(i));
    row.addEventListener("pointerleave", () => choose(null));
  });
  byId("crossings").replaceChildren(crossings.length ? table : "");
}

async function trace() {
  if (!state.ray) return;
  const { origin, direction } = state.ray;
  const query = byId("trace-query").value;
  const { head } = await connection.ask({ ask: "trace", ray: { origin, direction }, accel: state.accel, query });
  state.steps = head.answer.steps;
  const list = byId("steps");
  list.replaceChildren(...state.steps.map((step, i) => {
    const item = document.createElement("li");
    const t = document.createElement("span");
    t.className = "t";
    t.textContent = `${step.t === null ? "" : short(step.t)}`.padStart(9) + "  ";
    item.append(t, "  ".repeat(step.depth) + step.text);
    item.addEventListener("click", () => showStep(i));
    return item;
  }));
  if (head.answer.left_out) {
    const item = document.createElement("li");
    item.textContent = `${head.answer.left_out} more steps are left out`;
    list.append(item);
  }
  byId("trace-step").max = Math.max(0, state.steps.length - 1);
  showStep(0);
}

function showStep(number) {
  if (!state.steps.length) return;
  state.step = Math.max(0, Math.min(state.steps.length - 1, number));
  byId("trace-step").value = state.step;
  byId("trace-number").textContent = `${state.step + 1} of ${state.steps.length}`;
  const items = byId("steps").children;
  for (const item of items) item.classList.remove("chosen");
  items[state.step].classList.add("chosen");
  items[state.step].scrollIntoView({ block: "nearest" });
  drawOverlays();
}

function showTrace(isShown) {
  byId("trace-button").setAttribute("aria-pressed", String(isShown));
  for (const id of ["steps", "trace-query", "trace-tools"]) byId(id).hidden = !isShown;
  if (isShown) trace().catch((error) => setTrouble(error.message));
  else { state.step = null; state.steps = []; drawOverlays(); }
}

function closeRay() {
  showTrace(false);
  state.ray = null;
  byId("ray").hidden = true;
  drawOverlays();
  changed();
}

function connectRay() {
  byId("ray-close").addEventListener("click", closeRay);
  byId("trace-button").addEventListener("click", () => showTrace(byId("trace-button").getAttribute("aria-pressed") !== "true"));
  byId("trace-query").addEventListener("change", () => trace());
  byId("trace-step").addEventListener("input", (event) => showStep(Number(event.target.value)));
  byId("trace-back").addEventListener("click", () => showStep(state.step - 1));
  byId("trace-forward").addEventListener("click", () => showStep(state.step + 1));
  byId("ray-form").addEventListener("submit", (event) => {
    event.preventDefault();
    const [origin, direction] = ["ray-from", "ray-along"].map((id) => vectorOf(byId(id).value));
    if (origin && direction && length(direction) > 0) shoot({ origin, direction });
    else setTrouble("A ray has three numbers for its origin and three, not all 0, for its direction.");
  });
}
