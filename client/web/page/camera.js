// A camera on a turntable: where it looks, from where, and what pointers, wheels and keys do to it.

const FIELD = (28 * Math.PI) / 180;
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

export class Camera {
  constructor() {
    this.up = 'y';
    this.free = { x: 0, y: 0, width: 1, height: 1 }; // of the picture, what nothing covers: middle (-1 .. 1) and size (0 .. 1)
    this.radius = 1;
    this.reset();
  }
  reset() {
    Object.assign(this, { yaw: 0.52, pitch: 0.26, zoom: 1, pan: [0, 0] });
  }
  /** Fits what lies in `positions`: a sphere around their box's middle. */
  fit(positions) {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < positions.length; i++) {
      const k = i % 3;
      if (positions[i] < low[k]) low[k] = positions[i];
      if (positions[i] > high[k]) high[k] = positions[i];
    }
    this.middle = low.map((x, k) => (x + high[k]) / 2);
    this.radius = Math.hypot(...high.map((x, k) => x - low[k])) / 2 || 1;
  }

  turn(dx, dy) {
    this.yaw += dx;
    this.pitch = clamp(this.pitch + dy, -1.55, 1.55);
  }
  /** By parts of the picture's height. */
  move(dx, dy) {
    this.pan[0] += dx / this.zoom;
    this.pan[1] += dy / this.zoom;
  }
  nearer(factor) {
    this.zoom = clamp(this.zoom * factor, 0.2, 60);
  }

  /** Column-major, for WebGL; away: the eye from the model's middle. */
  matrices(aspect) {
    const tangent = Math.tan(FIELD / 2);
    const { free } = this;
    const fit = (0.82 * this.radius) / Math.sin(FIELD / 2) / Math.min(free.height, free.width * aspect);
    const distance = Math.max(fit / this.zoom, this.radius * 0.02);
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    // Rows of the turn: right, up, towards the eye; the model's up axis is brought to y first.
    let rows = [[cy, 0, -sy], [-sy * sp, cp, -cy * sp], [sy * cp, sp, cy * cp]];
    if (this.up === 'z') rows = rows.map(([x, y, z]) => [x, -z, y]);
    const height = 2 * fit * tangent;
    const shift = [this.pan[0] * height, this.pan[1] * height, -distance];
    const middle = this.middle ?? [0, 0, 0];
    const view = new Float32Array(16);
    rows.forEach((row, r) => {
      for (let c = 0; c < 3; c++) view[4 * c + r] = row[c];
      view[12 + r] = shift[r] - row.reduce((sum, x, c) => sum + x * middle[c], 0);
    });
    view[15] = 1;
    const near = Math.max(distance - 2.5 * this.radius, distance * 0.01);
    const far = distance + 2.5 * this.radius;
    const projection = new Float32Array(16);
    projection[0] = 1 / (tangent * aspect);
    projection[5] = 1 / tangent;
    projection[8] = -free.x;
    projection[9] = -free.y;
    projection[10] = -(far + near) / (far - near);
    projection[11] = -1;
    projection[14] = (-2 * far * near) / (far - near);
    return { view, projection, away: Math.hypot(...shift) };
  }
}

/** Lets people steer `camera` on `element`; changed() after each step. */
export function steer(element, camera, changed) {
  const fingers = new Map();
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) || 1 };
  };
  element.addEventListener('pointerdown', (event) => {
    element.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  element.addEventListener('pointermove', (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const height = element.clientHeight || 1;
    const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
    const two = fingers.size === 2 ? spread() : null;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (two) {
      const now = spread();
      camera.nearer(now.apart / two.apart);
      camera.move((now.x - two.x) / height, (two.y - now.y) / height);
    } else if (event.shiftKey || event.buttons & 6) camera.move(dx / height, -dy / height);
    else camera.turn((-dx / height) * 4, (dy / height) * 4);
    changed();
  });
  for (const end of ['pointerup', 'pointercancel']) element.addEventListener(end, (event) => fingers.delete(event.pointerId));
  element.addEventListener('contextmenu', (event) => event.preventDefault());
  element.addEventListener('wheel', (event) => {
    event.preventDefault();
    camera.nearer(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)));
    changed();
  }, { passive: false });
  element.addEventListener('dblclick', () => {
    camera.reset();
    changed();
  });
  addEventListener('keydown', (event) => {
    if (event.target !== element && event.target !== document.body) return; // sliders and the plot have keys of their own
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (arrow && event.shiftKey) camera.move(arrow[0] * 0.05, arrow[1] * 0.05);
    else if (arrow) camera.turn(arrow[0] * 0.12, arrow[1] * 0.12);
    else if (event.key === '+' || event.key === '=') camera.nearer(1.15);
    else if (event.key === '-') camera.nearer(1 / 1.15);
    else if (event.key === '0' || event.key === 'Home') camera.reset();
    else return;
    event.preventDefault();
    changed();
  });
}
