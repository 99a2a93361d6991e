import { BufferGeometry, Loader } from 'three';
import type { OpenOptions } from './mvw.js';

/**
 * The geometry refines in place as its bytes arrive, and dispatches 'refined'; its buffers are made once, for the finest
 * level. geometry.userData.mvw is the Model. Positions are relative to the middle of the model's box.
 */
export class MvwLoader extends Loader<BufferGeometry> {
  options: OpenOptions;
}
