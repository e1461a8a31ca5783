// What is drawn over the pictures: the ray, its crossings, the part of the accelerator of a step, handles of cutting planes.

const inkOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function drawOverlay(pane) {
  if (!state.camera || !isShown(pane)) return;
  const size = sizeOf(pane);
  if (pane.overlay.width !== size[0] || pane.overlay.height !== size[1]) {
    Object.assign(pane.overlay, { width: size[0], height: size[1] });
  }
  const context = pane.overlay.getContext("2d");
  context.clearRect(0, 0, ...size);
  const pen = { context, size, scale: size[0] / Math.max(1, pane.figure.clientWidth) };
  drawAxes(pen);
  for (const plane of state.planes) drawPlane(pen, plane);
  if (state.ray) drawRay(pen, state.ray);
  if (state.step !== null) drawStep(pen);
}

const drawOverlays = () => panes.forEach(drawOverlay);

function stroke({ context, size, scale }, line, color, width, dash = []) {
  context.beginPath();
  for (let i = 0; i + 1 < line.length; i += 1) {
    const part = visiblePart(state.camera, line[i], line[i + 1]);
    if (!part) continue;
    const [a, b] = part.map((p) => project(state.camera, size, p));
    if (!a || !b) continue;
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0], b[1]);
  }
  context.setLineDash(dash.map((d) => d * scale));
  context.strokeStyle = color;
  context.lineWidth = width * scale;
  context.stroke();
  context.setLineDash([]);
}

// The axes, in the lower left corner.
function drawAxes({ context, size, scale }) {
  const { right, up } = basis(state.camera);
  const [x, y, reach] = [38 * scale, size[1] - 38 * scale, 24 * scale];
  context.font = `${12 * scale}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  [["x", "#d6336c"], ["y", "#2f9e44"], ["z", "#1c7ed6"]].forEach(([name, color], i) => {
    const axis = [0, 1, 2].map((j) => (i === j ? 1 : 0));
    const [dx, dy] = [dot(axis, right) * reach, -dot(axis, up) * reach];
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = 2 * scale;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + dx, y + dy);
    context.stroke();
    context.fillText(name, x + dx * 1.35, y + dy * 1.35);
  });
}

function drawDot({ context, size, scale }, point, color, text, radius = 5) {
  const at = project(state.camera, size, point);
  if (!at) return;
  context.beginPath();
  context.arc(at[0], at[1], radius * scale, 0, 2 * Math.PI);
  context.fillStyle = color;
  context.fill();
  context.lineWidth = 1.5 * scale;
  context.strokeStyle = "#fff";
  context.stroke();
  if (!text) return;
  context.font = `600 ${12 * scale}px system-ui, sans-serif`;
  context.textAlign = "left";
  context.textBaseline = "bottom";
  context.lineWidth = 3 * scale;
  context.strokeText(text, at[0] + 7 * scale, at[1] - 4 * scale);
  context.fillText(text, at[0] + 7 * scale, at[1] - 4 * scale);
}

// The distance along the ray at which it has left the scene.
function farAlong({ origin }) {
  const [min, max] = state.scene.bounds ?? [state.camera.eye, state.camera.target];
  const centre = times(add(min, max), 0.5);
  return length(subtract(max, min)) + length(subtract(centre, origin));
}

function drawRay(pen, ray) {
  const at = (t) => add(ray.origin, times(ray.direction, t));
  stroke(pen, [ray.origin, at(farAlong(ray))], "#fff", 4);
  stroke(pen, [ray.origin, at(farAlong(ray))], "#c2410c", 1.5, [6, 4]);
  // Inside objects the line is thick.
  let depth = 0;
  ray.crossings.forEach((crossing, i) => {
    depth += crossing.entering ? 1 : -1;
    const next = ray.crossings[i + 1];
    if (depth > 0 && next && next.t !== null) stroke(pen, [at(crossing.t), at(next.t)], "#c2410c", 4);
  });
  ray.crossings.forEach((crossing, i) => {
    if (!crossing.point) return;
    const isChosen = ray.chosen === i;
    drawDot(pen, crossing.point, crossing.entering ? "#2f9e44" : "#c92a2a", String(i + 1), isChosen ? 8 : 5);
  });
  drawDot(pen, ray.origin, "#343a40", "", 4);
}

function drawStep(pen) {
  // The steps before stay faint, so that the way is seen.
  const first = Math.max(0, state.step - 40);
  for (let i = first; i < state.step; i += 1) {
    for (const line of state.steps[i].lines) stroke(pen, line, "rgb(66 99 235 / 28%)", 1);
  }
  const { lines, t } = state.steps[state.step];
  for (const line of lines) stroke(pen, line, "#fff", 5);
  for (const line of lines) stroke(pen, line, "#4263eb", 2.5);
  if (t !== null && state.ray) drawDot(pen, add(state.ray.origin, times(state.ray.direction, t)), "#4263eb", "", 4);
}

// The rectangle of a cutting plane, and its handle.
function drawPlane(pen, plane) {
  const corners = planeCorners(plane);
  if (!corners) return;
  stroke(pen, [...corners, corners[0]], "rgb(194 65 12 / 80%)", 1.5, [8, 5]);
  drawDot(pen, planeHandle(plane), "#c2410c", "", 7);
}

function planeCorners({ axis, height }) {
  if (!state.scene.bounds) return null;
  const [min, max] = state.scene.bounds;
  const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
  return [[min, min], [max, min], [max, max], [min, max]].map(([a, b]) => {
    const corner = [0, 0, 0];
    corner[axis] = height;
    corner[u] = a[u];
    corner[v] = b[v];
    return corner;
  });
}

// Where a plane is dragged: a corner of it, for its middle is within the scene.
const planeHandle = (plane) => planeCorners(plane)[2];
