// One model on screen: what the page's controls do, what its figures say. Decoding is the worker's (worker.js), drawing
// the scene's; everything else here is timed (work.js).

import { openModel } from './mvw.js';
import { Camera, steer } from './camera.js';
import { Plot } from './plot.js';
import { Scene } from './scene.js';
import { bytesText, countText, errorText } from './text.js';
import { token } from './token.js';
import { timed, work } from './work.js';

const INKS = {
  dark: { edge: [0.02, 0.03, 0.05, 0.55], base: [1, 0.66, 0.25, 1] },
  light: { edge: [0.05, 0.07, 0.1, 0.5], base: [0.72, 0.28, 0.02, 1] },
};
const KEYS = { w: 'edges', b: 'baseEdges', c: 'colors' };

export class Viewer {
  constructor(element) {
    this.find = (selector) => element.querySelector(selector);
    this.stage = this.find('#stage');
    this.scene = new Scene(this.stage);
    this.camera = new Camera();
    this.view = { level: null, layer: null, bytes: null, edges: false, baseEdges: false };
    this.choices = { shading: 'smooth', up: 'y', speed: 'full', via: 'http' };
    this.plot = new Plot(this.find('#plot'), timed('scrub', (bytes) => this.setView({ bytes })));
    steer(this.stage, this.camera, timed('steer', () => (this.paint(), this.look())));
    this.listen(element);
    new ResizeObserver(timed('resize', () => this.resize())).observe(this.stage);
    addEventListener('theme', () => this.themed());
    if (matchMedia('(max-width: 760px)').matches) this.find('#fold').setAttribute('aria-expanded', false);
    this.themed();
    for (const [name, value] of Object.entries(this.choices)) this.choose(name, value);
  }

  listen(element) {
    for (const group of element.querySelectorAll('[data-choice]'))
      for (const button of group.children) {
        button.setAttribute('role', 'radio');
        button.addEventListener('click', timed('choose', () => this.choose(group.dataset.choice, button.value)));
      }
    for (const button of element.querySelectorAll('[data-toggle]'))
      button.addEventListener('click', timed('toggle', () => this.toggle(button.dataset.toggle)));
    for (const name of ['level', 'layer'])
      this.find(`#${name}`).addEventListener('input', timed(name, ({ target }) =>
        this.setView({ [name]: target.value === target.max ? null : Number(target.value) })));
    this.find('#live').addEventListener('click', () => this.plot.pick(null));
    this.find('#again').addEventListener('click', () => this.reopen());
    this.find('#fold').addEventListener('click', ({ currentTarget: fold }) =>
      fold.setAttribute('aria-expanded', fold.getAttribute('aria-expanded') !== 'true'));
    addEventListener('keydown', timed('key', (event) => {
      if (!this.name || event.ctrlKey || event.metaKey || event.altKey) return;
      if (KEYS[event.key]) this.toggle(KEYS[event.key]);
      else if (event.key === 'f') this.choose('shading', this.choices.shading === 'flat' ? 'smooth' : 'flat');
    }));
  }

  open(name) {
    this.name = name;
    this.camera.reset();
    this.camera.middle = null;
    this.view.bytes = this.view.level = this.view.layer = null;
    this.reopen();
    document.activeElement?.blur();
  }

  /** Loads it from the first byte, over the transport and at the speed chosen. */
  reopen() {
    this.model?.close();
    this.scene.clear();
    this.plot.clear();
    this.view.bytes = null;
    const path = this.name.split("/").map(encodeURIComponent).join("/");
    const url = this.choices.via === 'ws' ? new URL(path, location.href.replace(/^http/, 'ws')) : `models/${path}.mvw`;
    const model = openModel(url, { view: { ...this.view }, bytesPerSecond: this.pace(), token });
    this.model = model;
    const hear = (kind, task) =>
      model.addEventListener(kind, timed(kind, () => model === this.model && task()));
    hear('about', () => this.describe());
    hear('points', () => this.plot.setCurve(model.points, this.curveBytes()));
    hear('refined', () => this.refine());
    hear('progress', () => this.tellStats());
    for (const kind of ['complete', 'lost', 'resumed', 'failed', 'restarted']) hear(kind, () => this.tellStatus(kind));
    this.tellStatus('opening');
    this.find('#opening').hidden = false;
    this.paint();
  }

  leave() {
    this.model?.close();
    this.model = this.name = null;
    this.tellStatus('');
  }

  curveBytes() {
    return this.model.about?.fileBytes ?? 0;
  }
  pace() {
    return this.choices.speed === 'full' ? Infinity : (Number(this.choices.speed) * 1000) / 8;
  }

  describe() {
    const { about } = this.model;
    this.plot.fileBytes = this.curveBytes();
    this.slider('level', about.levels);
    this.slider('layer', about.layers - 1);
  }
  slider(name, most) {
    const input = this.find(`#${name}`);
    input.max = most;
    input.value = this.view[name] ?? most;
    input.disabled = most <= 0;
    this.find(`#${name}Out`).textContent = this.view[name] === null ? 'all' : `${this.view[name]} of ${most}`;
  }

  setView(change) {
    Object.assign(this.view, change);
    this.model?.setView(change);
    if (this.model?.about) this.describe();
    this.find('#live').hidden = this.view.bytes === null;
    this.paint();
  }

  choose(name, value) {
    const before = this.choices[name];
    this.choices[name] = value;
    for (const button of this.find(`[data-choice="${name}"]`).children)
      button.setAttribute('aria-checked', button.value === value);
    if (name === 'shading') this.scene.options.flat = value === 'flat';
    else if (name === 'up') this.camera.up = value;
    else if (name === 'speed') this.model?.setPace(this.pace());
    else if (this.model && before !== value) this.reopen();
    this.paint();
  }

  toggle(name) {
    const button = this.find(`[data-toggle="${name}"]`);
    if (button.disabled) return;
    const on = button.getAttribute('aria-pressed') !== 'true';
    button.setAttribute('aria-pressed', on);
    this.scene.options[name] = on;
    if (name === 'colors') this.paint();
    else this.setView({ [name]: on });
  }

  refine() {
    const { model, camera } = this;
    const { drawable } = model;
    if (!camera.middle) {
      camera.fit(drawable.positions);
      this.look();
    }
    this.find('#opening').hidden = true;
    this.find('[data-toggle="colors"]').disabled = !drawable.colors;
    if (model.status === 'streaming') this.tellStatus('streaming');
    this.plot.setPresent(drawable.bytes, drawable.error, model.state.bytes);
    this.tellStats();
    this.paint();
  }

  tellStatus(kind) {
    const status = document.getElementById('status');
    const words = { opening: 'Connecting', streaming: 'Refining', complete: 'Complete', lost: 'No connection', failed: 'Failed', resumed: 'Refining', restarted: 'Loading anew' };
    status.textContent = words[kind] ?? '';
    if (kind) status.dataset.kind = kind === 'resumed' ? 'streaming' : kind;
    else delete status.dataset.kind;
    const arrived = bytesText(this.model?.state?.bytes ?? 0);
    this.banner(kind, {
      lost: `The server is away. What has arrived stays; trying again in ${((this.model?.retryIn ?? 0) / 1000).toFixed(1)} s.`,
      resumed: `Connected again: going on from ${arrived}.`,
      restarted: 'The model has changed on the server. Loading the new one.',
      failed: `This model cannot be shown: ${this.model?.message}`,
    }[kind]);
    if (kind === 'failed') this.find('#opening').hidden = true;
  }
  banner(kind, message) {
    const banner = this.find('#banner');
    if (!message && kind === 'streaming' && banner.dataset.kind === 'resumed') return; // for as long as its time says
    clearTimeout(this.bannerTimer);
    banner.hidden = !message;
    banner.textContent = message ?? '';
    banner.dataset.kind = kind;
    if (kind === 'resumed' || kind === 'restarted') this.bannerTimer = setTimeout(() => (banner.hidden = true), 3000);
  }

  tellStats() {
    const { model } = this;
    const { drawable, state, about } = model;
    if (!state) return;
    const rows = [['Bytes', bytesText(drawable ? drawable.bytes : state.bytes), about && `of ${bytesText(about.fileBytes)}`]];
    if (drawable) {
      rows.push(['Error', errorText(drawable.error), '']);
      rows.push(['Vertices', countText(drawable.positions.length / 3), '']);
      rows.push(['Triangles', countText(drawable.triangles.length / 3), '']);
      rows.push(['Level', String(drawable.level), about && `of ${about.levels}`]);
      rows.push(['Decoding', `${Math.round(drawable.decodeMs)} ms`, 'in all']);
      rows.push(['Frames', this.rate ? `${Math.round(this.rate)} /s` : '–', '']);
      rows.push(['Main thread', `${work.longest.toFixed(1)} ms`, 'longest']);
    }
    this.find('#stats').replaceChildren(...rows.map(([name, value, more]) => {
      const row = document.createElement('div');
      const [dt, dd] = [document.createElement('dt'), document.createElement('dd')];
      dt.textContent = name;
      dd.textContent = value;
      if (more) dd.append(' ', Object.assign(document.createElement('small'), { textContent: more }));
      row.dataset.stat = name;
      row.append(dt, dd);
      return row;
    }));
    if (!drawable) return;
    this.find('#brief').textContent = `${bytesText(drawable.bytes)} · ${countText(drawable.triangles.length / 3)} triangles`;
    const text = `${bytesText(drawable.bytes)} · ${(-20 * Math.log10(drawable.error || 1e-7)).toFixed(1)} dB`;
    this.find('#plotOut').textContent = text;
    const plot = this.find('#plot');
    plot.setAttribute('aria-valuenow', drawable.bytes);
    plot.setAttribute('aria-valuemax', about?.fileBytes ?? 0);
    plot.setAttribute('aria-valuetext', text);
  }

  themed() {
    const theme = document.documentElement.dataset.theme;
    Object.assign(this.scene.palette, INKS[theme]);
    this.paint();
  }
  resize() {
    const ratio = Math.min(devicePixelRatio, 2);
    this.size = [this.stage.clientWidth, this.stage.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    this.camera.free = this.uncovered();
    this.paint();
  }

  /** What panel and plot leave of the picture, as Camera.free. */
  uncovered() {
    const stage = this.stage.getBoundingClientRect();
    const [panel, plot] = ['#panel', '#plotBox'].map((id) => this.find(id).getBoundingClientRect());
    const right = panel.top < stage.bottom && panel.left > stage.left ? (stage.right - panel.left) / stage.width : 0;
    const below = plot.top < stage.bottom - 8 ? (stage.bottom - plot.top) / stage.height : 0;
    return { x: -right, y: below, width: 1 - right, height: 1 - below };
  }

  /** Soon, once: a frame draws whatever is there; nothing is waited for. */
  /** A few times a second: what is in view comes first. */
  look() {
    const { model, camera } = this;
    if (this.looking || !model || this.choices.via !== 'ws') return;
    this.looking = setTimeout(() => {
      this.looking = 0;
      if (model !== this.model || !camera.middle || model.status === 'complete') return;
      const { width, height } = this.stage;
      const { view, projection } = camera.matrices(width / height);
      model.setCamera({ fromModel: view, scaleX: projection[0], scaleY: projection[5], nearest: camera.radius * 0.05, height });
    }, 250);
  }

  paint() {
    if (this.painting) return;
    this.painting = requestAnimationFrame((now) => {
      this.painting = 0;
      if (!this.name) return;
      if (this.size && String(this.size) !== `${this.stage.width},${this.stage.height}`)
        [this.stage.width, this.stage.height] = this.size;
      if (this.model?.drawable) this.scene.take(this.model.drawable);
      this.scene.draw(this.camera);
      this.plot.draw();
      // Of frames in a row only: a picture that nobody moves is not drawn.
      if (now - this.lastFrame < 250) this.rate = 0.8 * (this.rate || 60) + 0.2 * (1000 / (now - this.lastFrame));
      this.lastFrame = now;
      this.tellRate();
    });
  }
  tellRate() {
    const value = this.find('[data-stat="Frames"] dd');
    if (value && this.rate) value.textContent = `${Math.round(this.rate)} /s`;
  }
}
