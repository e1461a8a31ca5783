// The slice: what owns the points of a plane across an axis.

const slice = { isOpen: false, isAsked: false, url: null };

function sliceHeight() {
  const [min, max] = state.scene.bounds;
  const axis = Number(byId("slice-axis").value);
  return min[axis] + ((max[axis] - min[axis]) * Number(byId("slice-range").value)) / 1000;
}

// Asks for the slice as it is chosen now; while one is asked for, the latest choice waits.
async function askSlice() {
  if (!slice.isOpen || !state.scene.bounds) return;
  if (slice.isAsked) { slice.isStale = true; return; }
  slice.isAsked = true;
  slice.isStale = false;
  const axis = Number(byId("slice-axis").value);
  const height = Number(byId("slice-height").value);
  const normal = [0, 1, 2].map((i) => (i === axis ? 1 : 0));
  const [min, max] = state.scene.bounds;
  // As slices choose their axes: y and z for x, x and z for y, x and y for z.
  const [u, v] = axis === 0 ? [1, 2] : axis === 1 ? [0, 2] : [0, 1];
  const margin = [u, v].map((i) => (max[i] - min[i]) * 0.03 || 1);
  const area = [min[u] - margin[0], min[v] - margin[1], max[u] + margin[0], max[v] + margin[1]];
  const across = Math.round(byId("slice").clientWidth * Math.min(window.devicePixelRatio || 1, 2) * 0.75);
  const down = Math.max(1, Math.min(across * 3, Math.round((across * (area[3] - area[1])) / (area[2] - area[0]))));
  try {
    const { bytes } = await connection.ask({ ask: "slice", plane: [...normal, height], size: [across, down], area, by: byId("slice-by").value });
    const picture = byId("slice-picture");
    if (slice.url) URL.revokeObjectURL(slice.url);
    slice.url = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
    picture.src = slice.url;
    setTrouble(null);
  } catch (error) {
    setTrouble(error.message);
  }
  slice.isAsked = false;
  if (slice.isStale) askSlice();
}

function openSlice(isOpen) {
  slice.isOpen = isOpen && Boolean(state.scene.bounds);
  byId("slice").hidden = !slice.isOpen;
  byId("slice-button").setAttribute("aria-pressed", String(slice.isOpen));
  if (!slice.isOpen) return;
  byId("slice-height").value = short(sliceHeight());
  askSlice();
}

function connectSlice() {
  byId("slice-button").addEventListener("click", () => openSlice(!slice.isOpen));
  byId("slice-close").addEventListener("click", () => openSlice(false));
  byId("slice-by").addEventListener("change", askSlice);
  byId("slice-range").addEventListener("input", () => { byId("slice-height").value = short(sliceHeight()); askSlice(); });
  byId("slice-axis").addEventListener("change", () => { byId("slice-height").value = short(sliceHeight()); askSlice(); });
  byId("slice-height").addEventListener("change", askSlice);
}
