// Error against bytes: the whole curve as the index tells it, the present point on it, and a handle to go back in time.

import { bytesText } from './text.js';

const decibel = (error) => -20 * Math.log10(Math.max(error, 1e-7));

export class Plot {
  /** chosen(bytes): someone wants no more than these, or all (null). */
  constructor(canvas, chosen) {
    Object.assign(this, { canvas, chosen, curve: [], seen: [], fileBytes: 0, present: null, choice: null });
    const pick = (event) => this.pick(this.bytesAt(event.clientX - canvas.getBoundingClientRect().left));
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      pick(event);
    });
    canvas.addEventListener('pointermove', (event) => event.buttons && pick(event));
    canvas.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: 0.8, ArrowDown: 0.8, ArrowRight: 1.25, ArrowUp: 1.25 }[event.key];
      if (event.key === 'End') this.pick(null);
      else if (event.key === 'Home') this.pick(this.range()[0]);
      else if (step) this.pick((this.choice ?? this.present?.bytes ?? 1) * step);
      else return;
      event.preventDefault();
    });
  }

  clear() {
    Object.assign(this, { curve: [], seen: [], fileBytes: 0, present: null, choice: null });
  }
  /** points: [bytes, error] pairs, of the whole file or as far as they are known. */
  setCurve(points, fileBytes) {
    this.curve = [];
    for (let i = 0; i < points.length; i += 2) this.curve.push([points[i], decibel(points[i + 1])]);
    this.fileBytes = fileBytes;
  }
  /** What is on screen, and how much has arrived. */
  setPresent(bytes, error, arrived) {
    this.present = { bytes, level: decibel(error) };
    this.arrived = arrived;
    if (this.choice === null) this.seen.push([bytes, decibel(error)]);
  }
  pick(bytes) {
    const [low, high] = this.range();
    this.choice = bytes === null || bytes >= Math.min(this.arrived ?? high, high) ? null : Math.max(bytes, low);
    this.chosen(this.choice);
  }

  range() {
    const points = this.curve.length ? this.curve : this.seen;
    const low = points.length ? points[0][0] : 500;
    return [low, Math.max(this.fileBytes, low * 4)];
  }
  frame() {
    const points = this.curve.length ? this.curve : this.seen;
    const [left, right] = this.range();
    const levels = points.map((p) => p[1]);
    const low = Math.floor((levels.length ? Math.min(...levels) : 40) / 10) * 10;
    const high = Math.ceil(((levels.length ? Math.max(...levels) : 80) + 1) / 10) * 10;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const pad = { left: 44, right: 14, top: 6, bottom: 18 };
    const wide = Math.log(right / left);
    return {
      points, left, right, low, high, width, height, pad,
      x: (bytes) => pad.left + (Math.log(Math.max(bytes, left) / left) / wide) * (width - pad.left - pad.right),
      y: (level) => height - pad.bottom - ((level - low) / (high - low)) * (height - pad.top - pad.bottom),
    };
  }
  bytesAt(x) {
    const { left, right, width, pad } = this.frame();
    return left * (right / left) ** ((x - pad.left) / (width - pad.left - pad.right));
  }

  draw() {
    const { canvas } = this;
    const style = getComputedStyle(canvas);
    const color = (name) => style.getPropertyValue(name);
    const ratio = devicePixelRatio;
    const f = this.frame();
    if (canvas.width !== Math.round(f.width * ratio) || canvas.height !== Math.round(f.height * ratio)) {
      canvas.width = Math.round(f.width * ratio);
      canvas.height = Math.round(f.height * ratio);
    }
    const c = canvas.getContext('2d');
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, f.width, f.height);
    this.drawGrid(c, f, color);
    const line = (points) => {
      c.beginPath();
      points.forEach(([bytes, level], i) => c[i ? 'lineTo' : 'moveTo'](f.x(bytes), f.y(level)));
    };
    c.lineJoin = 'round';
    c.strokeStyle = color('--line');
    c.lineWidth = 2;
    line(f.points);
    c.stroke();
    const { present } = this;
    if (!present) return;
    const done = [...f.points.filter(([bytes]) => bytes < present.bytes), [present.bytes, present.level]];
    c.strokeStyle = c.fillStyle = color('--accent');
    line(done);
    c.stroke();
    c.lineTo(f.x(present.bytes), f.height - f.pad.bottom);
    c.lineTo(f.x(done[0][0]), f.height - f.pad.bottom);
    c.globalAlpha = 0.16;
    c.fill();
    c.globalAlpha = 0.3;
    c.beginPath();
    c.arc(f.x(present.bytes), f.y(present.level), 9, 0, 7);
    c.fill();
    c.globalAlpha = 1;
    c.beginPath();
    c.arc(f.x(present.bytes), f.y(present.level), 4.5, 0, 7);
    c.fill();
  }

  drawGrid(c, f, color) {
    c.font = `11px ${getComputedStyle(this.canvas).fontFamily}`;
    c.fillStyle = color('--soft');
    c.strokeStyle = color('--line');
    c.lineWidth = 1;
    const step = f.high - f.low > 40 ? 20 : 10;
    for (let level = f.low; level <= f.high; level += step) {
      c.beginPath();
      c.moveTo(f.pad.left, f.y(level));
      c.lineTo(f.width - f.pad.right, f.y(level));
      c.stroke();
      c.textAlign = 'right';
      c.fillText(level === f.low || f.height > 90 ? `${level} dB` : `${level}`, f.pad.left - 6, f.y(level) + 4);
    }
    c.textAlign = 'center';
    let free = -Infinity;
    for (let power = 256; power < f.right * 2; power *= 2) {
      const x = f.x(power);
      if (power < f.left || power > f.right || x < free || x > f.width - 24) continue;
      free = x + 64;
      c.fillText(bytesText(power), x, f.height - 4);
    }
  }
}
