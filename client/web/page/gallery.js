// The models that the server has, each with a picture that the page draws from its first 4 KB.

import { openModel } from './mvw.js';
import { Camera } from './camera.js';
import { Scene } from './scene.js';
import { bytesText, countText } from './text.js';
import { token } from './token.js';

const PREFIX = 4096;
const AT_ONCE = 4; // thumbnails on their way
const AGAIN = 2000; // ms between questions to a server that does not answer

export class Gallery {
  constructor(element) {
    this.cards = element.querySelector('#cards');
    this.nothing = element.querySelector('#nothing');
    this.waiting = [];
    this.busy = 0;
    addEventListener('theme', () => this.pictures?.forEach((draw) => draw()));
  }

  async enter() {
    this.here = true;
    clearTimeout(this.timer);
    let models;
    try {
      const response = await fetch('models', { headers: token ? { Authorization: `Bearer ${token}` } : {} });
      if (!response.ok) throw new Error(`it answers ${response.status}`);
      ({ models } = await response.json());
    } catch {
      this.say('The server does not answer. Trying again every two seconds.');
      if (this.here) this.timer = setTimeout(() => this.enter(), AGAIN);
      return;
    }
    this.say(models.length ? '' : 'No models here yet. Put .mvw files into the served folder and they appear.');
    this.show(models);
  }
  leave() {
    this.here = false;
    clearTimeout(this.timer);
  }
  say(message) {
    this.nothing.textContent = message;
    this.nothing.hidden = !message;
  }

  show(models) {
    const key = JSON.stringify(models);
    if (key === this.shown) return;
    this.shown = key;
    this.pictures = [];
    this.cards.replaceChildren(...models.map((model) => this.card(model)));
  }

  card({ name, url, bytes, faces, levels }) {
    const item = document.createElement('li');
    const link = document.createElement('a');
    link.className = 'card';
    link.href = `#${encodeURIComponent(name)}`;
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [480, 360];
    const text = document.createElement('div');
    const title = document.createElement('strong');
    title.textContent = name;
    const about = document.createElement('small');
    about.textContent = `${countText(faces)} triangles · ${levels + 1} level${levels ? 's' : ''} · ${bytesText(bytes)}`;
    text.append(title, about);
    link.append(canvas, text);
    item.append(link);
    this.waiting.push({ url, canvas, link });
    this.next();
    return item;
  }

  next() {
    while (this.busy < AT_ONCE && this.waiting.length) {
      this.busy++;
      this.thumbnail(this.waiting.shift()).finally(() => {
        this.busy--;
        this.next();
      });
    }
  }

  async thumbnail({ url, canvas, link }) {
    const model = openModel(url, { prefix: PREFIX, view: { level: 4 }, token });
    try {
      await model.first();
    } catch (error) {
      link.title = error.message;
      return;
    } finally {
      model.close();
    }
    const { drawable } = model;
    const draw = () => {
      this.scene ??= new Scene(Object.assign(document.createElement('canvas'), { width: 480, height: 360 }));
      const camera = new Camera();
      camera.fit(drawable.positions);
      this.scene.take(drawable);
      this.scene.draw(camera);
      const c = canvas.getContext('2d');
      c.clearRect(0, 0, canvas.width, canvas.height);
      c.drawImage(this.scene.canvas, 0, 0);
    };
    draw();
    link.dataset.bytes = drawable.state.bytes;
    this.pictures.push(draw);
  }
}
