// How long our own work holds the page's thread: everything but drawing runs through here.

export const work = { longest: 0, name: '', times: [] };

/** A function that does the same as `task`, timed. */
export function timed(name, task) {
  return (...args) => {
    const begun = performance.now();
    const result = task(...args);
    const took = performance.now() - begun;
    work.times.push(took);
    if (work.times.length > 4096) work.times.splice(0, 2048);
    if (took > work.longest) Object.assign(work, { longest: took, name });
    return result;
  };
}
