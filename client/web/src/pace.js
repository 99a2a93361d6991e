// Gives bytes on no faster than a link of some speed would bring them.

const TICK = 40; // ms

export class Pace {
  /** bytesPerSecond: Infinity for no limit; may change at any time. */
  constructor(bytesPerSecond = Infinity) {
    this.bytesPerSecond = bytesPerSecond;
  }
  /** Calls take(slice) for all of `bytes`, in order; ends early once `signal` aborts. */
  async spread(bytes, take, signal) {
    for (let at = 0; at < bytes.length && !signal?.aborted; ) {
      if (this.bytesPerSecond === Infinity) {
        take(bytes.subarray(at));
        return;
      }
      const size = Math.max(1, Math.round((this.bytesPerSecond * TICK) / 1000));
      take(bytes.subarray(at, at + size));
      at += size;
      await new Promise((resolve) => setTimeout(resolve, TICK));
    }
  }
}
