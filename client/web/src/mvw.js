// The library's front door for pages: a URL in, a model that refines as its bytes arrive out. No framework; decoding is
// a worker's work.
//
//   const model = openModel('https://host/models/bunny.mvw');
//   model.addEventListener('refined', () => draw(model.drawable));

export { MvwError } from './module.js';

let shared = null;
let lastId = 0;

/** The page's one worker; made when first needed. */
function worker() {
  if (shared) return shared;
  shared = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
  shared.models = new Map();
  shared.addEventListener('message', ({ data }) => shared.models.get(data.id)?.hear(data));
  return shared;
}

/**
 * A model on its way. Events: 'about' (the header is there), 'points', 'refined' (drawable is new), 'progress',
 * 'complete', 'lost' and 'resumed' (the connection), 'restarted' (the file has changed on the server), 'failed'.
 */
export class Model extends EventTarget {
  about = null; // what the header says
  points = null; // Float64Array of [bytes, error] pairs, as far as they are known
  drawable = null; // the mesh now
  state = null; // what has arrived
  status = 'opening'; // then 'streaming', 'lost', 'complete' or 'failed'
  message = '';

  constructor(url, options = {}) {
    super();
    this.url = new URL(url, globalThis.location?.href).href;
    this.id = ++lastId;
    this.worker = worker();
    this.worker.models.set(this.id, this);
    this.post({ kind: 'open', options: { ...options, url: this.url } });
  }

  /** level, layer, bytes: no more than that is drawn (null: no such bound); edges, baseEdges: whether lines are. */
  setView(view) {
    this.post({ kind: 'view', view });
  }
  /** Over a WebSocket: tiles come in the order of what is left of their error on the screen. Of no use more often than a few times a second. */
  setCamera(camera) {
    this.post({ kind: 'camera', camera });
  }
  /** Infinity: as fast as it comes. */
  setPace(bytesPerSecond) {
    this.post({ kind: 'pace', bytesPerSecond });
  }
  close() {
    this.post({ kind: 'close' });
    this.worker.models.delete(this.id);
  }
  /** Resolves once there is something to draw. */
  first() {
    return this.until('refined', () => this.drawable);
  }
  /** Resolves once all of it is drawn. */
  completed() {
    return this.until('complete', () => this.status === 'complete');
  }

  post(message, transfer) {
    this.worker.postMessage({ id: this.id, ...message }, transfer);
  }
  until(event, there) {
    return new Promise((resolve, reject) => {
      if (there()) return resolve(this);
      this.addEventListener(event, () => resolve(this), { once: true });
      this.addEventListener('failed', () => reject(new Error(this.message)), { once: true });
    });
  }

  hear(data) {
    if (data.kind === 'about') this.about = data.about;
    else if (data.kind === 'points') this.points = data.points;
    else if (data.kind === 'progress') this.state = data.state;
    else if (data.kind === 'drawable') return this.take(data.drawable);
    else if (data.kind === 'restarted') Object.assign(this, { about: null, points: null, drawable: null });
    else if (data.kind !== 'index') {
      this.status = data.kind === 'resumed' ? 'streaming' : data.kind;
      this.message = data.message ?? '';
      this.retryIn = data.retryIn;
    }
    this.tell(data.kind);
  }

  take(drawable) {
    const old = this.drawable;
    if (old?.connectivity === drawable.connectivity)
      for (const name of ['triangles', 'edges', 'baseEdges']) drawable[name] ??= old[name];
    this.drawable = drawable;
    this.state = drawable.state;
    if (this.status === 'opening') this.status = 'streaming';
    this.tell('refined');
    this.post({ kind: 'taken' });
    if (drawable.complete && this.status !== 'complete') {
      this.status = 'complete';
      this.tell('complete');
    }
  }

  tell(kind) {
    this.dispatchEvent(new Event(kind));
  }
}

/** url: of a .mvw file (http:, https:) or of a model on a server of mvw's (ws:, wss:). */
export function openModel(url, options) {
  return new Model(url, options);
}
