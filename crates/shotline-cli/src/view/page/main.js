// Begins, and begins again when the scene changes.

const connection = new Connection(reload, () => setTrouble("The program has ended. Start it again, and open the address that it prints."));
connection.idle = nextPicture;

async function load() {
  const { head } = await connection.ask({ ask: "scene" });
  const isFirst = state.scene === null;
  state.scene = head.answer;
  if (isFirst) {
    state.accel = state.scene.accel;
    state.counter = state.scene.counters[0];
    // What encloses everything would hide it.
    state.hidden = new Set(state.scene.enclosures);
    if (innerWidth <= 700) document.body.classList.add("no-side");
  }
  setTrouble(null);
  fillControls();
  if (!state.camera) await showView();
  await fillTree();
  if (state.ray) await shoot({ origin: state.ray.origin, direction: state.ray.direction });
  if (slice.isOpen) askSlice();
  changed();
}

// Loads the scene again, once however often its change is noticed.
function reload() {
  if (reload.isRunning) return;
  reload.isRunning = true;
  load().catch((error) => setTrouble(error.message)).finally(() => { reload.isRunning = false; });
}

whenChanged(showControls);
panes.forEach(connectPointer);
connectControls();
connectRay();
connectSlice();
new ResizeObserver(() => { drawOverlays(); connection.next(); }).observe(byId("stage"));
document.addEventListener("visibilitychange", () => connection.next());
reload();
