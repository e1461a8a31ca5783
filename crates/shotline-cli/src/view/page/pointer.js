// Mouse, touch and keys on the pictures.

const CLICK = 4; // a pointer that moves less, in pixels, clicks
const views = ["front", "back", "left", "right", "top", "bottom", "iso"];

const KEYS = [
  ["drag", "turn"], ["Shift drag, right drag, two fingers", "move"], ["wheel, pinch", "zoom"], ["click", "crossings of the ray"],
  ["← → ↑ ↓", "turn; with Shift move"], ["+ −", "zoom"], ["1 … 7", "front, back, left, right, top, bottom, iso"],
  ["f", "show everything"], ["o", "objects"], ["c", "cut"], ["s", "slice"], ["t", "steps of the ray"], [", .", "step back, forward"],
  ["Esc", "close what is open"], ["?", "these keys"],
];

function setCamera(camera) {
  state.camera = camera;
  state.isMoving = true;
  clearTimeout(setCamera.rest);
  setCamera.rest = setTimeout(() => { state.isMoving = false; }, 200);
  drawOverlays();
  changed();
}

// Looks from a standard direction, or without a name as the scene says, so that everything is in the picture.
async function showView(name) {
  try {
    const { head } = await connection.ask({ ask: "view", name, size: sizeOf(panes[0]) });
    setCamera(turnable(head.answer));
  } catch (error) {
    setTrouble(error.message);
  }
}

function connectPointer(pane) {
  const { overlay } = pane;
  const down = new Map(); // pointers that are down, by number
  let drag = null;

  const at = (event) => {
    const box = overlay.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const spread = () => {
    const [a, b] = [...down.values()];
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], distance: Math.hypot(a[0] - b[0], a[1] - b[1]) };
  };

  overlay.addEventListener("pointerdown", (event) => {
    overlay.setPointerCapture(event.pointerId);
    overlay.focus({ preventScroll: true });
    down.set(event.pointerId, at(event));
    const handle = down.size === 1 ? handleAt(pane, at(event)) : null;
    drag = { moved: 0, handle, isPan: event.button !== 0 || event.shiftKey, pinch: down.size === 2 ? spread() : null };
    event.preventDefault();
  });
  overlay.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before || !drag) return;
    const now = at(event);
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    down.set(event.pointerId, now);
    drag.moved += Math.hypot(dx, dy);
    if (down.size === 2) pinch();
    else if (drag.handle) dragPlane(drag.handle, dx, dy, overlay.clientWidth, overlay.clientHeight);
    else if (drag.moved < CLICK) return;
    else if (drag.isPan) setCamera(panned(state.camera, dx, dy, overlay.clientHeight));
    else setCamera(orbited(state.camera, dx, dy));
  });
  const up = (event) => {
    const isClick = drag && drag.moved < CLICK && down.size === 1 && event.type === "pointerup" && !drag.handle && event.button === 0;
    down.delete(event.pointerId);
    if (isClick) shootThrough(pane, at(event));
    if (down.size === 0) drag = null;
    else drag = { moved: CLICK, isPan: true };
  };
  overlay.addEventListener("pointerup", up);
  overlay.addEventListener("pointercancel", up);
  overlay.addEventListener("contextmenu", (event) => event.preventDefault());
  overlay.addEventListener("wheel", (event) => {
    event.preventDefault();
    setCamera(zoomed(state.camera, Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.04 : 0.0015))));
  }, { passive: false });

  function pinch() {
    const now = spread();
    const before = drag.pinch ?? now;
    drag.pinch = now;
    const [dx, dy] = [now.middle[0] - before.middle[0], now.middle[1] - before.middle[1]];
    const camera = zoomed(state.camera, now.distance / (before.distance || 1));
    setCamera(panned(camera, dx, dy, overlay.clientHeight));
  }
}

// The cutting plane whose handle is at a position.
function handleAt(pane, [x, y]) {
  const size = [pane.overlay.clientWidth, pane.overlay.clientHeight];
  return state.planes.find((plane) => {
    const handle = planeCorners(plane) && project(state.camera, size, planeHandle(plane));
    return handle && Math.hypot(handle[0] - x, handle[1] - y) < 14;
  });
}

// Moves a plane along its normal as far as the pointer moves along the normal's image.
function dragPlane(plane, dx, dy, width, height) {
  const handle = planeHandle(plane);
  const step = pixelSize(state.camera, height) * 10;
  const normal = [0, 1, 2].map((i) => (i === plane.axis ? step : 0));
  const [a, b] = [handle, add(handle, normal)].map((p) => project(state.camera, [width, height], p));
  if (!a || !b) return;
  const [nx, ny] = [b[0] - a[0], b[1] - a[1]];
  const square = nx * nx + ny * ny;
  if (square < 1) return;
  setPlane(plane, { height: plane.height + (step * (dx * nx + dy * ny)) / square });
}

function onKey(event) {
  if (event.target.matches("input, select, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const arrow = arrows[event.key];
  const height = panes[0].overlay.clientHeight;
  if (arrow && event.target.closest("#tree")) return;
  if (arrow && event.shiftKey) setCamera(panned(state.camera, arrow[0] * 30, arrow[1] * 30, height));
  else if (arrow) setCamera(orbited(state.camera, arrow[0] * 12, arrow[1] * 12));
  else if (event.key === "+" || event.key === "=") setCamera(zoomed(state.camera, 1.15));
  else if (event.key === "-") setCamera(zoomed(state.camera, 1 / 1.15));
  else if (event.key >= "1" && event.key <= "7") showView(views[Number(event.key) - 1]);
  else if (event.key === "f") showView();
  else if (event.key === "o") byId("tree-button").click();
  else if (event.key === "c") byId("clip-add").click();
  else if (event.key === "s") byId("slice-button").click();
  else if (event.key === "t" && state.ray) byId("trace-button").click();
  else if (event.key === "," && state.step !== null) showStep(state.step - 1);
  else if (event.key === "." && state.step !== null) showStep(state.step + 1);
  else if (event.key === "?") byId("help-button").click();
  else if (event.key === "Escape") closeOpen();
  else return;
  event.preventDefault();
}
