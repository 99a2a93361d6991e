// A file over HTTP: one request for all of it (over a limited link, for a piece at a time), another for the index at its
// end, and after a break a Range request for what is missing. Any server will do, with or without Range.

import { MvwError } from './module.js';

const FIRST_DELAY = 250; // ms, doubled with each try in a row
const LONGEST_DELAY = 4000;

/** The header fields that an access token asks for. */
export const bearer = (token) => (token ? { Authorization: `Bearer ${token}` } : {});

/** A fault that trying again will not mend. */
const final = (status, url) => new MvwError('io', `${url}: the server answers ${status}`);

/**
 * Streams `url` into `decoder` until all is there. tell({kind, ...}): 'data' after new bytes, 'lost' with `message` and
 * `retryIn`, 'resumed', 'restarted' once the file on the server is another one (then `decoder` must be new).
 */
export async function streamHttp(url, decoder, pace, tell, signal, token) {
  let have = 0;
  let etag = null;
  let failures = 0;
  let index = null;
  let lost = false;

  async function request() {
    // A slow link is asked for little at a time: what has been asked for comes whether or not there is time for it.
    const end = pace.bytesPerSecond === Infinity ? '' : have + Math.max(4096, Math.ceil(pace.bytesPerSecond / 4)) - 1;
    const headers = { ...bearer(token), ...((have > 0 || end) && { Range: `bytes=${have}-${end}` }) };
    if (have > 0 && etag) headers['If-Range'] = etag;
    const response = await fetch(url, { headers, signal });
    if (response.status >= 400 && response.status < 500 && response.status !== 429) throw final(response.status, url);
    if (!response.ok) throw new Error(`the server answers ${response.status}`);
    return response;
  }

  function readIndex() {
    const about = decoder.description();
    if (index !== null || about === null || about.fileBytes === have) return;
    const headers = { ...bearer(token), Range: `bytes=${about.indexOffset}-${about.fileBytes - 1}` };
    index = fetch(url, { headers, signal })
      .then(async (response) => {
        if (response.status !== 206) return response.body?.cancel();
        decoder.feedIndex(new Uint8Array(await response.arrayBuffer()));
        tell({ kind: 'index' });
      })
      .catch(() => {}); // it comes with the file's end at the latest
  }

  async function read(response) {
    let skip = response.status === 206 ? 0 : have; // a server without Range begins anew
    const reader = response.body.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      const fresh = value.subarray(Math.min(skip, value.length));
      skip -= value.length - fresh.length;
      await pace.spread(fresh, (slice) => {
        decoder.feed(slice);
        have += slice.length;
        failures = 0;
        readIndex();
        tell({ kind: 'data' });
      }, signal);
    }
  }

  while (!signal.aborted) {
    try {
      const response = await request();
      const changed = have > 0 && response.status === 200 && response.headers.get('ETag') !== etag;
      if (changed) {
        await response.body?.cancel();
        have = 0;
        index = null;
        decoder = tell({ kind: 'restarted' });
        continue;
      }
      etag = response.headers.get('ETag');
      if (lost) tell({ kind: 'resumed' });
      lost = false;
      const due = have + Number(response.status === 206 ? response.headers.get('Content-Length') : Infinity);
      await read(response);
      if (decoder.state().complete) break;
      if (have < due) throw new Error('the connection ended early');
    } catch (error) {
      if (signal.aborted) return;
      if (error instanceof MvwError) throw error;
      lost = true;
      const retryIn = Math.min(FIRST_DELAY * 2 ** failures++, LONGEST_DELAY);
      tell({ kind: 'lost', message: error.message, retryIn });
      await new Promise((resolve) => setTimeout(resolve, retryIn));
    }
  }
  await index;
}
