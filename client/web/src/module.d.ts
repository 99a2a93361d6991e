import type { Description, Drawable, State, View } from './mvw.js';
export { MvwError } from './mvw.js';

export interface Module {
  readonly __module: unique symbol;
}

/** source: the bytes of mvw.wasm, a Response (or a promise of one), or a compiled WebAssembly.Module. */
export function createModule(
  source: BufferSource | Response | WebAssembly.Module | Promise<BufferSource | Response | WebAssembly.Module>,
): Promise<Module>;

/** One model's decoder, without worker or network. Delete it when done. */
export class Decoder {
  constructor(module: Module, memoryBytes?: number);
  delete(): void;
  /** The next bytes of the file, from its beginning. Throws MvwError. */
  feed(bytes: Uint8Array): void;
  /** The file's index, fetched apart. */
  feedIndex(bytes: Uint8Array): void;
  description(): Description | null;
  state(): State;
  /** Sixteen hexadecimal digits: the same for the same chunks in every build of the decoder. */
  digest(): string;
  /** [bytes, error] after each chunk that is known, one after the other. */
  points(): Float64Array;
  /** Null until a base mesh is there. `have`: triangles and lines that are the same as its own are left out. */
  draw(view?: View, have?: Drawable | null): Drawable | null;
}

/** Decodes a whole file, or any beginning of one. */
export function decode(module: Module, bytes: Uint8Array, view?: View): Drawable & { triangles: Uint32Array };
