// The pictures: asked for step by step, from coarse to fine, while nothing else is asked.

const panes = [0, 1].map((number) => {
  const figure = byId(`pane-${number}`);
  const picture = figure.querySelector(".picture");
  return {
    number,
    figure,
    picture,
    overlay: figure.querySelector(".overlay"),
    caption: figure.querySelector("figcaption"),
    wanted: "", // the picture that was asked for last
    isFinal: false,
    coarse: 4, // how coarse a picture must be to be made at once
    scratch: new OffscreenCanvas(1, 1),
    frames: 0,
  };
});
// The server makes no larger pictures.
const MOST_PIXELS = 4e6;
const isShown = (pane) => !pane.figure.hidden;

// The size of the pictures in pixels of the screen.
function sizeOf(pane) {
  const { clientWidth, clientHeight } = pane.figure;
  const fitting = Math.sqrt(MOST_PIXELS / Math.max(1, clientWidth * clientHeight));
  const ratio = Math.min(window.devicePixelRatio || 1, 2, fitting);
  return [Math.max(1, Math.round(clientWidth * ratio)), Math.max(1, Math.round(clientHeight * ratio))];
}

function pictureOf(pane) {
  const isCompared = state.versus !== null;
  return {
    camera: state.camera,
    size: sizeOf(pane),
    look: isCompared ? "cost" : state.look,
    accel: isCompared && pane.number === 1 ? state.versus : state.accel,
    counter: state.counter,
    shown: shown(),
    clip: clipPlanes(),
  };
}

// The next step of a picture that is not final, the panes in turn.
function nextPicture() {
  if (!state.camera || document.hidden) return null;
  const open = panes.filter(isShown).sort((a, b) => (a.lastAsked ?? 0) - (b.lastAsked ?? 0));
  for (const pane of open) {
    const picture = pictureOf(pane);
    const wanted = JSON.stringify([picture, state.scene.version]);
    if (pane.isFinal && wanted === pane.wanted) continue;
    if (wanted !== pane.wanted) Object.assign(pane, { wanted, isFinal: false, begun: performance.now() });
    pane.lastAsked = performance.now();
    return {
      question: { ask: "draw", pane: pane.number, picture, coarse: pane.coarse },
      resolve: (answer) => drawn(pane, answer),
      reject: (error) => { pane.isFinal = true; setTrouble(error.message); },
    };
  }
  return null;
}

// How coarse the first passes should be, after one that took some time, so that turning is smooth.
const MS_OF_FIRST_PASS = 30;
function coarseFor({ coarse, ms, done }) {
  const factor = ms / Math.max(done, 0.01) / MS_OF_FIRST_PASS;
  // Within a factor of 1.5 it stays, so that it does not change all the time.
  if (factor > 0.67 && factor < 1.5) return coarse;
  return Math.min(12, Math.max(1, Math.round(coarse * Math.sqrt(factor))));
}

function drawn(pane, { head, bytes }) {
  pane.isFinal = head.is_final;
  if (head.version !== state.scene.version) reload();
  if (head.size) show(pane, head, bytes);
  if (head.pass === 0) pane.coarse = coarseFor(head);
  const drawing = panes.some((other) => isShown(other) && !other.isFinal);
  document.body.dataset.state = drawing ? "drawing" : "final";
  setStatus(drawing && !state.isMoving ? `${head.samples} of 16 samples` : "");
}

// Puts a picture, or its upper rows, on the canvas.
function show(pane, { size: [width, height], rows }, bytes) {
  const [across, down] = sizeOf(pane);
  if (pane.picture.width !== across || pane.picture.height !== down) {
    Object.assign(pane.picture, { width: across, height: down });
  }
  Object.assign(pane.scratch, { width, height });
  pane.scratch.getContext("2d").putImageData(new ImageData(bytes, width, height), 0, 0);
  const context = pane.picture.getContext("2d");
  context.imageSmoothingEnabled = width < across;
  const target = (rows / height) * down;
  if (rows > 0) context.drawImage(pane.scratch, 0, 0, width, rows, 0, 0, across, target);
  pane.frames += 1;
  drawOverlay(pane);
}

function captionPanes() {
  const isCompared = state.versus !== null;
  byId("pane-1").hidden = !isCompared;
  panes[0].caption.textContent = isCompared ? state.accel : "";
  panes[1].caption.textContent = isCompared ? state.versus : "";
}
