// What the page shows. Everything that changes it calls `changed`.

const byId = (id) => document.getElementById(id);

const state = {
  scene: null,
  camera: null,
  look: "lit",
  accel: null,
  counter: null,
  versus: null, // the second accelerator while costs are compared
  hidden: new Set(),
  only: null, // the one object that is shown with its contents
  planes: [], // { axis, height, side }: what is beyond the height is cut away
  ray: null, // { origin, direction, crossings }
  step: null, // the step of the trace that is drawn
  steps: [],
  isMoving: false,
};

const listeners = [];
const whenChanged = (listener) => listeners.push(listener);
function changed() {
  for (const listener of listeners) listener();
  connection.next();
}

const cutNormal = ({ axis, side }) => [0, 1, 2].map((i) => (i === axis ? side : 0));
const clipPlanes = () => state.planes.map((plane) => [...cutNormal(plane), plane.height * plane.side]);
const shown = () => (state.only ? { only: [state.only] } : { hide: [...state.hidden] });
const unitOf = () => state.scene?.units ?? "";
// "mm" behind a number, if the scene has units.
const withUnit = (text) => (unitOf() ? `${text} ${unitOf()}` : text);

function setStatus(text) {
  byId("status").textContent = text;
  byId("status").hidden = !text;
}

// Shows what is wrong; without a text, what is wrong with the file of the scene, if anything is.
function setTrouble(text) {
  const shown = text ?? state.scene?.trouble ?? "";
  byId("trouble").textContent = shown;
  byId("trouble").hidden = !shown;
}
