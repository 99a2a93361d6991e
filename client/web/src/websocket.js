// A model over a WebSocket: carries the bytes of the session in the module (wasm/link.h), and does what it says.

import { MvwError } from './module.js';

const Step = {
  Connect: 1, Send: 2, Timer: 3, Disconnect: 4, Opened: 5, Received: 6, Satisfied: 7, Broken: 8, Resumed: 9,
  Restarted: 10, Failed: 11,
};

/** As streamHttp(); eye.camera, where it is set, tells which tiles come first: eye.moved() once it has changed. url: ws://host:port/model or wss://, as the other clients have it. */
export function streamWebSocket(url, decoder, pace, tell, signal, token = '', eye = {}) {
  const { module, door } = decoder;
  const at = new URL(url);
  const name = decodeURIComponent(at.pathname.slice(1));
  const address = `${at.protocol}//${at.host}/stream`;
  const encode = (text) => new TextEncoder().encode(text);
  const seed = (Math.random() * 2 ** 32) >>> 0;
  const link = module.with(encode(name), (n, nl) =>
    module.with(encode(token), (t, tl) => door.mvw_link_new(decoder.model, n, nl, t, tl, seed)));
  let socket = null;
  let timer = 0;
  let incoming = Promise.resolve();

  return new Promise((resolve, reject) => {
    const now = () => performance.now();
    const end = (finish, value) => {
      delete eye.moved;
      clearTimeout(timer);
      drop();
      finish(value);
    };
    function drop() {
      const old = socket;
      socket = null;
      old?.close();
    }
    function connect() {
      const mine = new WebSocket(address);
      socket = mine;
      mine.binaryType = 'arraybuffer';
      mine.onopen = () => mine === socket && step(() => door.mvw_link_connected(link, now()));
      mine.onclose = () => {
        if (mine !== socket) return;
        socket = null;
        step(() => door.mvw_link_disconnected(link, now()));
      };
      mine.onmessage = ({ data }) => {
        incoming = incoming.then(() => pace.spread(new Uint8Array(data), (slice) => {
          if (mine === socket)
            step(() => module.with(slice, (p, n) => door.mvw_link_bytes(link, p, n, now())));
        }, signal));
      };
    }
    function step(happen) {
      happen();
      for (;;) {
        const next = door.mvw_link_next(link, now());
        if (next === 0) return;
        const number = module.numbers()[0];
        if (next === Step.Connect) connect();
        else if (next === Step.Send) socket?.send(module.bytes());
        else if (next === Step.Disconnect) drop();
        else if (next === Step.Timer) {
          clearTimeout(timer);
          timer = setTimeout(() => step(() => door.mvw_link_timer(link, now())), Math.max(0, number));
        } else if (next === Step.Opened || next === Step.Received) tell({ kind: 'data' });
        else if (next === Step.Broken) tell({ kind: 'lost', message: module.text(), retryIn: number });
        else if (next === Step.Resumed) tell({ kind: 'resumed' });
        else if (next === Step.Restarted) tell({ kind: 'restarted' });
        else if (next === Step.Satisfied) return end(resolve);
        else if (next === Step.Failed) return end(reject, new MvwError('io', module.text()));
      }
    }
    eye.moved = () => {
      const { fromModel, scaleX, scaleY, nearest, height } = eye.camera;
      const numbers = new Float32Array([...fromModel, scaleX, scaleY, nearest, height]);
      step(() => module.with(new Uint8Array(numbers.buffer), (at) => door.mvw_link_look(link, at, now())));
    };
    if (eye.camera) eye.moved();
    signal.addEventListener('abort', () => end(resolve));
    step(() => door.mvw_link_start(link, now()));
  }).finally(() => door.mvw_link_delete(link));
}
