// A person at the page: headless Chromium before the real server, with models made for the purpose.
import { spawn, spawnSync } from 'node:child_process';
import { once } from 'node:events';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import pixelmatch from 'pixelmatch';
import { chromium } from 'playwright-core';
import { PNG } from 'pngjs';
import { root } from './files.mjs';

const program = process.env.MVW_PROGRAM ?? path.join(root, 'build/mvw');
const page = process.env.MVW_PAGE ?? path.join(root, 'build/page');
export const folder = mkdtempSync(path.join(tmpdir(), 'mvw-web-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));

/** A ball with hills: closed, smooth, some thousand triangles; with stripes of colour, if asked for. */
function ball(rings = 56, striped = false) {
  const lines = [];
  const at = (i, k) => {
    const [a, b] = [(Math.PI * i) / rings, (2 * Math.PI * k) / (2 * rings)];
    const r = 1 + 0.12 * Math.sin(5 * a) * Math.cos(4 * b) + 0.03 * Math.sin(17 * a) * Math.sin(13 * b);
    return [r * Math.sin(a) * Math.cos(b), r * Math.cos(a), -r * Math.sin(a) * Math.sin(b)];
  };
  const paint = ([x, y, z]) => [0.5 + 0.5 * Math.sin(4 * y), 0.35 + 0.3 * Math.sin(3 * x), 0.5 - 0.5 * Math.sin(4 * z)];
  const point = (p) => lines.push(`v ${[...p, ...(striped ? paint(p) : [])].map((x) => x.toFixed(6)).join(' ')}`);
  point(at(0, 0));
  for (let i = 1; i < rings; i++) for (let k = 0; k < 2 * rings; k++) point(at(i, k));
  point(at(rings, 0));
  const n = 2 * rings;
  const id = (i, k) => (i === 0 ? 1 : i === rings ? 2 + (rings - 1) * n : 2 + (i - 1) * n + (k % n));
  for (let i = 0; i < rings; i++)
    for (let k = 0; k < n; k++) {
      if (i > 0) lines.push(`f ${id(i, k)} ${id(i + 1, k)} ${id(i, k + 1)}`);
      if (i < rings - 1) lines.push(`f ${id(i, k + 1)} ${id(i + 1, k)} ${id(i + 1, k + 1)}`);
    }
  return lines.join('\n');
}

/** Encodes the models into `folder`. */
export function makeModels() {
  writeFileSync(path.join(folder, 'ball.obj'), ball());
  const made = spawnSync(program, ['encode', path.join(folder, 'ball.obj'), path.join(folder, 'ball.mvw')]);
  if (made.status !== 0) throw new Error(String(made.stderr));
  writeFileSync(path.join(folder, 'golden.mvw'), readFileSync(path.join(root, 'tests/data/golden_mixed.mvw')));
  return readFileSync(path.join(folder, 'ball.mvw')).length;
}

/** A folder with a model in colours and many tiles. */
export function makePainted() {
  const other = path.join(folder, '.painted');
  mkdirSync(other);
  writeFileSync(path.join(other, 'painted.obj'), ball(56, true));
  const made = spawnSync(program, ['encode', path.join(other, 'painted.obj'), path.join(other, 'painted.mvw'), '--tile-count', '16']);
  if (made.status !== 0) throw new Error(String(made.stderr));
  return other;
}

/** A folder with a square of backs and fronts behind it: 0.2 % of the diagonal away on the left, 2 % on the right. */
export function makeBacks() {
  const other = path.join(folder, '.backs');
  mkdirSync(other);
  const lines = [];
  const add = (from, to, z, front) => {
    const first = lines.filter((line) => line[0] === 'v').length + 1;
    for (const [x, y] of [[from, -0.5], [to, -0.5], [to, 0.5], [from, 0.5]]) lines.push(`v ${x} ${y} ${z}`);
    const corners = [first, first + 1, first + 2, first + 3];
    lines.push(`f ${(front ? corners : corners.reverse()).join(' ')}`);
  };
  add(-0.5, 0.5, 0, false);
  add(-0.5, 0, -0.002 * Math.SQRT2, true);
  add(0, 0.5, -0.02 * Math.SQRT2, true);
  writeFileSync(path.join(other, 'backs.obj'), lines.join('\n'));
  const made = spawnSync(program, ['encode', path.join(other, 'backs.obj'), path.join(other, 'backs.mvw')]);
  if (made.status !== 0) throw new Error(String(made.stderr));
  return other;
}

/** A file of keys for `mvw serve --tokens`, and a token of it that opens one model. */
export function makeToken(model) {
  const keys = path.join(folder, 'keys');
  writeFileSync(keys, 'a key of more than sixteen bytes\n');
  const made = spawnSync(program, ['token', '--key', keys, '--models', model]);
  if (made.status !== 0) throw new Error(String(made.stderr));
  return { keys, token: String(made.stdout).trim() };
}

/** `mvw serve` as a process that can be killed and started again at the same place. */
export class Server {
  port = 0;
  constructor(place = folder) {
    this.folder = place;
  }
  async start(more = []) {
    const args = ['serve', this.folder, '--tcp', '127.0.0.1:0', '--http', `127.0.0.1:${this.port}`, '--page', page, ...more];
    this.process = spawn(program, args, { stdio: ['ignore', 'pipe', 'inherit'] });
    this.wanted = true;
    this.process.once('exit', (code, signal) => this.wanted && console.error(`mvw serve ended by itself: ${code} ${signal}`));
    const [line] = await once(this.process.stdout, 'data');
    this.port = Number(/https?:\/\/[^\s]*:(\d+)/.exec(String(line))[1]);
    return this;
  }
  get url() {
    return `http://127.0.0.1:${this.port}/`;
  }
  async kill() {
    this.wanted = false;
    const gone = once(this.process, 'exit');
    this.process.kill('SIGKILL');
    await gone;
  }
}

export function launch() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--enable-unsafe-swiftshader', '--font-render-hinting=none'],
  });
}

/** A tab whose errors and violations of the content security policy are collected. */
export async function openTab(browser, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1200, height: 760 }, colorScheme: 'dark', ...options });
  const tab = await context.newPage();
  tab.faults = [];
  tab.on('pageerror', (error) => tab.faults.push(error.message));
  tab.on('console', (message) => {
    // A browser reports the server's absence itself: that is what some tests are about.
    if (message.type() === 'error' && !/ERR_CONNECTION|WebSocket connection|net::ERR/.test(message.text()))
      tab.faults.push(message.text());
  });
  await tab.addInitScript(() => {
    globalThis.violations = [];
    addEventListener('securitypolicyviolation', (event) => globalThis.violations.push(event.violatedDirective));
  });
  return tab;
}

const references = path.join(root, 'tests/data/web');
const wrong = path.join(root, 'build/web/wrong');

/** Compares a screenshot with tests/data/web/NAME.png: at most `share` of the pixels may differ. */
export async function looksLike(target, name, share = 0.04) {
  let shot = PNG.sync.read(await target.screenshot({ animations: 'disabled' }));
  const file = path.join(references, `${name}.png`);
  if (process.env.MVW_UPDATE_PICTURES) {
    mkdirSync(references, { recursive: true });
    writeFileSync(file, PNG.sync.write(shot));
    return;
  }
  const reference = PNG.sync.read(readFileSync(file));
  const pixels = shot.width * shot.height;
  let differ = pixels;
  for (let attempt = 0; attempt < 20; attempt++) {
    const same = shot.width === reference.width && shot.height === reference.height;
    if (same) differ = pixelmatch(shot.data, reference.data, null, shot.width, shot.height, { threshold: 0.2 });
    if (differ <= share * pixels) return;
    await new Promise((resolve) => setTimeout(resolve, 250)); // the last frames may still be on their way
    shot = PNG.sync.read(await target.screenshot({ animations: 'disabled' }));
  }
  if (!existsSync(wrong)) mkdirSync(wrong, { recursive: true });
  writeFileSync(path.join(wrong, `${name}.png`), PNG.sync.write(shot));
  throw new Error(`${name}: ${((100 * differ) / pixels).toFixed(1)} % of the pixels differ; see build/web/wrong/${name}.png`);
}

/** The stage's own pixels, to see whether something changed. */
export async function stagePixels(tab) {
  await settle(tab);
  const { x, y, width, height } = await tab.locator('#stage').boundingBox();
  const clip = { x: x + 8, y: y + 8, width: width - 330, height: height - 190 }; // without panel, plot, mark of the focus
  return PNG.sync.read(await tab.screenshot({ clip })).data;
}
/** Returns once frames that were asked for are drawn. */
export async function settle(tab) {
  await tab.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  await tab.waitForTimeout(60);
}
/** Returns once `holds` does, or says what it last gave. */
export async function eventually(holds, what) {
  let last;
  for (let i = 0; i < 60; i++) {
    if ((last = await holds()) === true) return;
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  throw new Error(`${what}: ${last}`);
}
/** Returns once the stage differs from `before` by more than `share` of its pixels. */
export const changes = (tab, before, share, what) => eventually(async () => {
  const part = differs(before, await stagePixels(tab));
  return part > share || part;
}, `${what ?? 'the picture'} should change`);
/** Returns once the stage is as it was. */
export const isAgain = (tab, before, what) => eventually(async () => {
  const part = differs(before, await stagePixels(tab));
  return part < 0.002 || part;
}, `${what ?? 'the picture'} should be as before`);
export function differs(a, b) {
  let count = 0;
  for (let i = 0; i < a.length; i += 4)
    if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 24) count++;
  return count / (a.length / 4);
}
/** A figure of the statistics, as text. */
export const figure = (tab, name) => tab.locator(`[data-stat="${name}"] dd`).innerText();
export const complete = (tab, timeout = 60000) => tab.waitForSelector('#status[data-kind=complete]', { timeout });

/** Does what starts a model anew, and waits until it has: all of it may be there again before anyone looks. */
export async function beginsAnew(tab, act) {
  await tab.evaluate(() => {
    const status = document.querySelector('#status');
    const options = { attributeFilter: ['data-kind'], attributeOldValue: true };
    window.anew = new Promise((begun) => {
      const observer = new MutationObserver((records) => {
        const kinds = [status.dataset.kind, ...records.map((record) => record.oldValue)];
        if (kinds.every((kind) => kind === 'complete')) return;
        observer.disconnect();
        begun();
      });
      observer.observe(status, options);
    });
  });
  await act();
  await tab.evaluate(() => window.anew);
}
