// The camera: the same projection as that of the engine, so that lines lie on the picture.

function basis(camera) {
  const forward = unit(subtract(camera.target, camera.eye));
  const right = unit(cross(forward, camera.up));
  return { forward, right, up: cross(right, forward) };
}

// Half the height of the picture, at distance 1 in perspective.
const halfHeight = (camera) => (camera.height ? camera.height / 2 : Math.tan((camera.fov * Math.PI) / 360));

// Where a point is in a picture of a size, and its depth; null behind the eye.
function project(camera, [width, height], point) {
  const { forward, right, up } = basis(camera);
  const p = subtract(point, camera.eye);
  const depth = dot(p, forward);
  const scale = (height / 2) / (halfHeight(camera) * (camera.height ? 1 : depth));
  if (!camera.height && depth <= 1e-9 * length(p)) return null;
  return [width / 2 + dot(p, right) * scale, height / 2 - dot(p, up) * scale, depth];
}

// The part of a line that is before the eye.
function visiblePart(camera, a, b) {
  if (camera.height) return [a, b];
  const { forward } = basis(camera);
  const near = 1e-4 * length(subtract(camera.target, camera.eye));
  const [da, db] = [a, b].map((p) => dot(subtract(p, camera.eye), forward) - near);
  if (da < 0 && db < 0) return null;
  const at = () => add(a, times(subtract(b, a), da / (da - db)));
  return [da < 0 ? at() : a, db < 0 ? at() : b];
}

// World units for a pixel, at the target.
function pixelSize(camera, height) {
  const distance = camera.height ? 1 : length(subtract(camera.target, camera.eye));
  return (2 * halfHeight(camera) * distance) / height;
}

// The camera after a drag by pixels: it turns about its target. The upright stays upright.
function orbited(camera, dx, dy) {
  const { forward, right } = basis(camera);
  const upright = unit(camera.up);
  let back = subtract(camera.eye, camera.target);
  // Not over the pole.
  const lift = Math.asin(Math.max(-1, Math.min(1, -dot(forward, upright))));
  const most = (89.5 * Math.PI) / 180;
  const tilt = Math.max(-most, Math.min(most, lift + dy * 0.008)) - lift;
  back = turned(back, right, -tilt);
  back = turned(back, upright, -dx * 0.008);
  return { ...camera, eye: add(camera.target, back) };
}

function panned(camera, dx, dy, height) {
  const { right, up } = basis(camera);
  const size = pixelSize(camera, height);
  const move = add(times(right, -dx * size), times(up, dy * size));
  return { ...camera, eye: add(camera.eye, move), target: add(camera.target, move) };
}

// Comes nearer by a factor; parallel pictures become larger.
function zoomed(camera, factor) {
  if (camera.height) return { ...camera, height: camera.height / factor };
  const back = times(subtract(camera.eye, camera.target), 1 / factor);
  return { ...camera, eye: add(camera.target, back) };
}

// A camera whose up is not along its direction, so that it can be turned: views from above look up along y.
function turnable(camera) {
  const { forward } = basis(camera);
  return Math.abs(dot(forward, unit(camera.up))) > 0.9999 ? { ...camera, up: basis(camera).up } : camera;
}
