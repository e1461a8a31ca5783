// The page's half of a picture in a notebook: it tells Python what the user does, and shows the pictures that come back.

const STILL_AFTER = 250; // milliseconds without a move until the picture is made fine
const KEYS = {
  ArrowLeft: { turn: [-20, 0] },
  ArrowRight: { turn: [20, 0] },
  ArrowUp: { turn: [0, -20] },
  ArrowDown: { turn: [0, 20] },
  "+": { zoom: 1.2 },
  "-": { zoom: 1 / 1.2 },
};

function render({ model, el }) {
  const picture = document.createElement("img");
  Object.assign(picture, { tabIndex: 0, draggable: false, alt: "a picture of the scene; drag it to turn it" });
  Object.assign(picture.style, { width: `${model.get("width")}px`, maxWidth: "100%", cursor: "grab", touchAction: "none" });
  el.append(picture);

  const nothing = () => ({ turn: [0, 0], shift: [0, 0], zoom: 1, moving: true });
  let next = null; // the next message
  let isWaiting = false; // for the picture of what was told last
  let still = 0;

  const tell = () => {
    if (isWaiting || !next) return;
    isWaiting = true;
    model.send(next);
    next = null;
  };
  const move = ({ turn = [0, 0], shift = [0, 0], zoom = 1 }) => {
    next ??= nothing();
    next.turn = [next.turn[0] + turn[0], next.turn[1] + turn[1]];
    next.shift = [next.shift[0] + shift[0], next.shift[1] + shift[1]];
    next.zoom *= zoom;
    next.moving = true;
    clearTimeout(still);
    still = setTimeout(() => {
      next = { ...(next ?? nothing()), moving: false };
      tell();
    }, STILL_AFTER);
    tell();
  };

  let url = "";
  const show = () => {
    URL.revokeObjectURL(url);
    url = URL.createObjectURL(new Blob([model.get("picture")], { type: "image/png" }));
    picture.src = url;
  };
  const answered = (message) => {
    if (message.kind !== "drawn") return;
    isWaiting = false;
    tell();
  };

  picture.addEventListener("pointerdown", (event) => {
    picture.setPointerCapture(event.pointerId);
    picture.focus();
  });
  picture.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    const by = [event.movementX, event.movementY];
    const isShift = event.shiftKey || event.buttons > 1;
    if (by[0] || by[1]) move(isShift ? { shift: by } : { turn: by });
  });
  picture.addEventListener("contextmenu", (event) => event.preventDefault());
  picture.addEventListener("wheel", (event) => {
    event.preventDefault();
    move({ zoom: Math.exp(-event.deltaY * 0.001) });
  }, { passive: false });
  picture.addEventListener("keydown", (event) => {
    const by = KEYS[event.key];
    if (!by || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    move(by);
  });

  model.on("change:picture", show);
  model.on("msg:custom", answered);
  show();
  return () => {
    clearTimeout(still);
    model.off("change:picture", show);
    model.off("msg:custom", answered);
    URL.revokeObjectURL(url);
  };
}

export default { render };
