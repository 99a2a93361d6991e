/** A fault that the decoder, the protocol or the server found. */
export class MvwError extends Error {
  readonly code: 'need-more-data' | 'malformed' | 'unsupported' | 'limit-exceeded' | 'invalid-argument' | 'io';
}

/** What a file's header says. */
export interface Description {
  version: number;
  transform: string | null;
  parts: number;
  levels: number;
  layers: number;
  headerBytes: number;
  indexOffset: number;
  fileBytes: number;
  /** Of each level, 0 to `levels`. */
  vertices: number[];
  faces: number[];
}

/** What has arrived. */
export interface State {
  bytes: number;
  /** Finest for which any detail is there. */
  level: number;
  /** RMS surface error left, a fraction of the diagonal. */
  error: number;
  chunks: number;
  damaged: number;
  complete: boolean;
  revision: number;
}

/** No more than this is drawn; null or absent: no such bound. */
export interface View {
  level?: number | null;
  layer?: number | null;
  bytes?: number | null;
  edges?: boolean;
  baseEdges?: boolean;
}

/** A mesh as a graphics card takes it; positions are relative to the middle of the model's box. */
export interface Drawable {
  level: number;
  /** Of what is drawn. */
  error: number;
  bytes: number;
  /** Whether the parts that have come bound solids: from outside no back need be drawn, as with three.js's FrontSide. */
  solid: boolean;
  /** Drawables with the same text here have the same triangles and lines. */
  connectivity: string;
  positions: Float32Array;
  normals: Float32Array;
  /** RGBA of each vertex. */
  colors?: Uint8Array;
  triangles?: Uint32Array;
  /** Vertex pairs: each triangle's edges, once, but where two materials' colours meet. */
  edges?: Uint32Array;
  /** Vertex pairs along the base mesh's edges. */
  baseEdges?: Uint32Array;
}

/** One that openModel() gives: its triangles are always there. */
export interface StreamedDrawable extends Drawable {
  triangles: Uint32Array;
  state: State;
  complete: boolean;
  /** Milliseconds that the worker has decoded so far, and that this drawable took. */
  decodeMs: number;
  drawMs: number;
}

export interface OpenOptions {
  view?: View;
  /** No faster than this. */
  bytesPerSecond?: number;
  /** Only the file's first bytes (more where they hold no mesh): for thumbnails. */
  prefix?: number;
  /** For servers that ask for one. */
  token?: string;
  /** As by setCamera(). */
  camera?: Eye;
  /** The decoder stops at the level that fits. */
  memoryBytes?: number;
}

/** A camera that looks along -z; drawables are relative to the same origin. */
export interface Eye {
  /** Rigid, column-major. */
  fromModel: ArrayLike<number>;
  /** 1 / tangent of half the angle of view, across and up. */
  scaleX: number;
  scaleY: number;
  /** Nothing counts as nearer than this. */
  nearest: number;
  /** Of the picture, in pixels. */
  height: number;
}

export type Status = 'opening' | 'streaming' | 'lost' | 'resumed' | 'restarted' | 'complete' | 'failed';
export type ModelEvent =
  | 'about' | 'points' | 'refined' | 'progress' | 'complete' | 'lost' | 'resumed' | 'restarted' | 'failed';

export class Model extends EventTarget {
  readonly url: string;
  readonly about: Description | null;
  readonly points: Float64Array | null;
  readonly drawable: StreamedDrawable | null;
  readonly state: State | null;
  readonly status: Status;
  readonly message: string;
  /** Milliseconds, while the connection is lost. */
  readonly retryIn?: number;
  setView(view: View): void;
  /** Over a WebSocket: tiles come in the order of what is left of their error on the screen. */
  setCamera(camera: Eye): void;
  setPace(bytesPerSecond: number): void;
  close(): void;
  first(): Promise<this>;
  completed(): Promise<this>;
  addEventListener(type: ModelEvent, listener: (event: Event) => void, options?: AddEventListenerOptions): void;
}

/** url: of a .mvw file (http:, https:) or of a model on a server of mvw's (ws:, wss:). */
export function openModel(url: string | URL, options?: OpenOptions): Model;
