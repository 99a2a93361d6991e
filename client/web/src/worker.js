// The worker: decodes models and sends their arrays. One worker serves any number of models, each by its id; the page's
// thread only hands over messages (src/mvw.js).

import { createModule, Decoder } from './module.js';
import { bearer, streamHttp } from './http.js';
import { streamWebSocket } from './websocket.js';
import { Pace } from './pace.js';

const models = new Map();
let module;

function compiled() {
  module ??= createModule(fetch(new URL('mvw.wasm', import.meta.url)));
  module.catch(() => (module = undefined)); // the next model asks again
  return module;
}

class Model {
  constructor(id, { url, token, memoryBytes, bytesPerSecond, view, prefix, camera }) {
    Object.assign(this, { id, url, token, memoryBytes, prefix });
    this.eye = { camera };
    this.view = view ?? {};
    this.pace = new Pace(bytesPerSecond ?? Infinity);
    this.stopping = new AbortController();
    this.have = null; // what the page holds: its connectivity and lines come again only where they change
    this.waiting = false; // for the page to take the last drawable
    this.decodeMs = 0;
  }

  send(message, transfer = []) {
    postMessage({ id: this.id, ...message }, transfer);
  }

  async run() {
    const tell = (event) => this.tell(event);
    try {
      this.decoder = this.timed(new Decoder(await compiled(), this.memoryBytes));
      if (this.prefix) await this.fetchPrefix();
      else if (/^wss?:/.test(this.url))
        await streamWebSocket(this.url, this.decoder, this.pace, tell, this.stopping.signal, this.token, this.eye);
      else await streamHttp(this.url, this.decoder, this.pace, tell, this.stopping.signal, this.token);
      this.done = true;
      this.refresh();
    } catch (error) {
      this.send({ kind: 'failed', message: error.message, code: error.code ?? 'io' });
    }
  }

  /** Only the file's beginning, for a thumbnail; further where that holds no mesh. */
  async fetchPrefix() {
    for (let have = 0, want = this.prefix; have < want; ) {
      const headers = { ...bearer(this.token), Range: `bytes=${have}-${want - 1}` };
      const response = await fetch(this.url, { headers, signal: this.stopping.signal });
      if (!response.ok) throw new Error(`the server answers ${response.status}`);
      const bytes = new Uint8Array(await response.arrayBuffer());
      this.decoder.feed(bytes);
      have += bytes.length;
      this.about();
      if (have < want || response.status !== 206) return; // that was all of it
      if (this.decoder.draw({ level: 0 }) === null) want *= 4;
    }
  }

  /** The decoder with its working time measured. */
  timed(decoder) {
    for (const name of ['feed', 'draw']) {
      const plain = decoder[name].bind(decoder);
      decoder[name] = (...args) => {
        const begun = performance.now();
        try {
          return plain(...args);
        } finally {
          this.decodeMs += performance.now() - begun;
        }
      };
    }
    return decoder;
  }

  tell(event) {
    if (event.kind === 'restarted') {
      if (!/^wss?:/.test(this.url)) {
        this.decoder.delete();
        this.decoder = this.timed(new Decoder(this.decoder.module, this.memoryBytes));
      }
      this.described = false;
      this.have = null;
    }
    if (event.kind === 'data' || event.kind === 'index') {
      this.about(event.kind === 'index');
      this.refresh();
    } else {
      this.send(event);
    }
    return this.decoder;
  }

  about(again = false) {
    if (this.described && !again) return;
    const about = this.decoder.description();
    if (about === null) return;
    this.described = true;
    this.send({ kind: 'about', about });
    const points = this.decoder.points();
    if (points.length) this.send({ kind: 'points', points }, [points.buffer]);
  }

  /** Draws soon, once for all that comes until then, and never while the page still has to take the last drawable. */
  refresh() {
    if (this.waiting || this.scheduled) return void (this.stale = true);
    this.scheduled = setTimeout(() => {
      this.scheduled = 0;
      this.stale = false;
      if (!this.stopping.signal.aborted) this.draw();
    }, 30);
  }

  draw() {
    const state = this.decoder.state();
    const view = { ...this.view };
    // While details arrive, one level beyond the finest that has any: finer ones would only be smoother.
    view.level ??= this.done || state.complete ? 255 : state.level + 1;
    const begun = performance.now();
    const drawable = this.decoder.draw(view, this.have);
    if (drawable === null) {
      this.send({ kind: 'progress', state, decodeMs: this.decodeMs });
      return;
    }
    drawable.state = state;
    drawable.drawMs = performance.now() - begun;
    drawable.decodeMs = this.decodeMs;
    drawable.complete = Boolean(this.done);
    const sameAsBefore = this.have?.connectivity === drawable.connectivity;
    this.have = {
      connectivity: drawable.connectivity,
      edges: Boolean(drawable.edges) || (sameAsBefore && this.have.edges),
      baseEdges: Boolean(drawable.baseEdges) || (sameAsBefore && this.have.baseEdges),
    };
    this.waiting = true;
    const arrays = Object.values(drawable).filter((value) => ArrayBuffer.isView(value));
    this.send({ kind: 'drawable', drawable }, arrays.map((array) => array.buffer));
    if (this.points !== state.chunks && /^wss?:/.test(this.url)) {
      this.points = state.chunks;
      const points = this.decoder.points();
      this.send({ kind: 'points', points }, [points.buffer]);
    }
  }

  taken() {
    this.waiting = false;
    if (this.stale) this.refresh();
  }

  close() {
    this.stopping.abort();
    clearTimeout(this.scheduled);
    this.finished.then(() => this.decoder?.delete());
  }
}

addEventListener('message', ({ data }) => {
  if (data.kind === 'open') {
    const model = new Model(data.id, data.options);
    models.set(data.id, model);
    model.finished = model.run();
    return;
  }
  const model = models.get(data.id);
  if (!model) return;
  if (data.kind === 'taken') model.taken();
  else if (data.kind === 'camera') {
    model.eye.camera = data.camera;
    model.eye.moved?.();
  } else if (data.kind === 'view') {
    Object.assign(model.view, data.view);
    if (model.decoder) model.refresh();
  } else if (data.kind === 'pace') model.pace.bytesPerSecond = data.bytesPerSecond;
  else if (data.kind === 'close') {
    models.delete(data.id);
    model.close();
  }
});
