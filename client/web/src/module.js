// The WebAssembly module and what stands behind its door (wasm/door.cpp): numbers and bytes in, typed arrays out.
// Runs in pages, workers and node alike; nothing here waits, fetches or knows of threads.

const utf8 = new TextDecoder();
const ERRORS = ['need-more-data', 'malformed', 'unsupported', 'limit-exceeded', 'invalid-argument', 'io'];

/** A fault that the decoder found: `code` is one of ERRORS. */
export class MvwError extends Error {
  constructor(code, message) {
    super(message);
    this.name = 'MvwError';
    this.code = code;
  }
}

/** source: the bytes of mvw.wasm, a Response (or a promise of one), or a compiled WebAssembly.Module. */
export async function createModule(source) {
  const imports = {
    env: { emscripten_notify_memory_growth() {} },
    wasi_snapshot_preview1: {
      proc_exit(code) {
        throw new MvwError('limit-exceeded', `the decoder ran out of memory (${code})`);
      },
    },
  };
  source = await source;
  let instance;
  if (source instanceof WebAssembly.Module) instance = await WebAssembly.instantiate(source, imports);
  else if (typeof Response !== 'undefined' && source instanceof Response)
    ({ instance } = await WebAssembly.instantiate(await source.arrayBuffer(), imports));
  else ({ instance } = await WebAssembly.instantiate(source, imports));
  instance.exports._initialize?.();
  return new Module(instance.exports);
}

class Module {
  constructor(door) {
    this.door = door;
  }
  /** The text or bytes that the last call left; a copy. */
  bytes() {
    const at = this.door.mvw_text();
    return new Uint8Array(this.door.memory.buffer).slice(at, at + this.door.mvw_text_length());
  }
  text() {
    return utf8.decode(this.bytes());
  }
  numbers() {
    return new Float64Array(this.door.memory.buffer, this.door.mvw_numbers(), 8);
  }
  /** Calls work(place, length) with `bytes` in the module's memory. */
  with(bytes, work) {
    const place = this.door.mvw_allocate(bytes.length || 1);
    new Uint8Array(this.door.memory.buffer).set(bytes, place);
    try {
      return work(place, bytes.length);
    } finally {
      this.door.mvw_release(place);
    }
  }
  check(result) {
    if (result !== 0) throw new MvwError(ERRORS[result - 1], this.text());
  }
}

const ARRAYS = {
  positions: [0, Float32Array],
  normals: [1, Float32Array],
  colors: [2, Uint8Array],
  triangles: [3, Uint32Array],
  edges: [4, Uint32Array],
  baseEdges: [5, Uint32Array],
  points: [6, Float64Array],
};

/** One model's decoder. Delete it when done: its memory is the module's. */
export class Decoder {
  constructor(module, memoryBytes = 1 << 30) {
    this.module = module;
    this.door = module.door;
    this.model = this.door.mvw_model_new(memoryBytes);
  }
  delete() {
    this.door.mvw_model_delete(this.model);
    this.model = 0;
  }
  /** The next bytes of the file, from its beginning. */
  feed(bytes) {
    this.module.check(this.module.with(bytes, (at, n) => this.door.mvw_model_feed(this.model, at, n)));
  }
  /** The file's index (description().indexOffset to its end), fetched apart. */
  feedIndex(bytes) {
    this.module.check(this.module.with(bytes, (at, n) => this.door.mvw_model_index(this.model, at, n)));
  }
  /** What the header says; null before it is there. */
  description() {
    return this.door.mvw_model_describe(this.model) ? JSON.parse(this.module.text()) : null;
  }
  state() {
    this.door.mvw_model_state(this.model);
    const [bytes, level, error, chunks, damaged, complete, revision] = this.module.numbers();
    return { bytes, level, error, chunks, damaged, complete: complete !== 0, revision };
  }
  digest() {
    this.door.mvw_model_digest(this.model);
    return this.module.text();
  }
  /** [bytes, error] after each chunk that is known, one after the other. */
  points() {
    return this.array('points');
  }
  /**
   * The mesh of what has come, or null where no base mesh has. level, layer, bytes: no more than that is used.
   * have: a drawable whose triangles and lines the caller still holds; they come again only where they differ.
   */
  draw(view = {}, have = null) {
    const { level, layer, bytes, edges, baseEdges } = view;
    const lines = (edges ? 1 : 0) | (baseEdges ? 2 : 0);
    const result = this.door.mvw_model_draw(this.model, level ?? 255, layer ?? 255, Math.min(bytes ?? Infinity, 1e300), lines);
    if (ERRORS[result - 1] === 'need-more-data') return null;
    this.module.check(result);
    const [used, , error, , , drawnLevel, parts, solid] = this.module.numbers();
    this.door.mvw_model_array(this.model, ARRAYS.triangles[0]);
    const connectivity = `${drawnLevel}/${parts}/${this.door.mvw_array_bytes()}`;
    const out = { level: drawnLevel, error, bytes: used, solid: solid !== 0, connectivity };
    out.positions = this.array('positions');
    out.normals = this.array('normals');
    const colors = this.array('colors');
    if (colors.length) out.colors = colors;
    const same = have !== null && have.connectivity === out.connectivity;
    if (!same) out.triangles = this.array('triangles');
    if (edges && !(same && have.edges)) out.edges = this.array('edges');
    if (baseEdges && !(same && have.baseEdges)) out.baseEdges = this.array('baseEdges');
    return out;
  }
  array(name) {
    const [which, Type] = ARRAYS[name];
    const at = this.door.mvw_model_array(this.model, which);
    return new Type(this.door.memory.buffer.slice(at, at + this.door.mvw_array_bytes()));
  }
}

/** Decodes a whole file, or any beginning of one. */
export function decode(module, bytes, view) {
  const decoder = new Decoder(module);
  try {
    decoder.feed(bytes);
    const mesh = decoder.draw(view);
    if (mesh === null) throw new MvwError('need-more-data', 'the data ends before the first mesh');
    return mesh;
  } finally {
    decoder.delete();
  }
}
