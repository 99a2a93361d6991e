// The page that `mvw serve` offers at /, used as a person would.
import assert from 'node:assert/strict';
import { after, afterEach, before, beforeEach, test } from 'node:test';
import { beginsAnew, changes, complete, eventually, figure, isAgain, launch, looksLike, makeBacks, makeModels, makePainted, makeToken, openTab, Server, settle, stagePixels } from './browser.mjs';

const size = makeModels();
const server = new Server();
let browser;
let tab;

before(async () => {
  browser = await launch();
  await server.start();
});
after(async () => {
  await browser.close();
  await server.kill();
});
beforeEach(async () => {
  tab = await openTab(browser);
});
afterEach(async () => {
  assert.deepEqual(tab.faults, []);
  assert.deepEqual(await tab.evaluate(() => globalThis.violations), []);
  await tab.context().close();
});

const open = async (name, whole = true) => {
  await tab.goto(`${server.url}#${name}`);
  if (whole) await complete(tab);
};

test('the policy allows our own scripts and WebAssembly, and nothing looser', async () => {
  const response = await tab.goto(server.url);
  const policy = response.headers()['content-security-policy'];
  assert.match(policy, /(^|; )default-src 'none'/);
  assert.match(policy, /(^|; )script-src 'self' 'wasm-unsafe-eval'(;|$)/);
  assert.doesNotMatch(policy, /'unsafe-inline'|'unsafe-eval'|\*/);
});

test('the page and its module come packed: at most 150 KB over the network', async () => {
  const sizes = [];
  tab.on('requestfinished', async (request) => {
    if (!request.url().includes('/models')) sizes.push(request.sizes().then((size) => [request.url(), size.responseBodySize]));
  });
  await open('ball');
  const bytes = (await Promise.all(sizes)).reduce((sum, [, size]) => sum + size, 0);
  assert.ok(bytes > 20000 && bytes <= 150 * 1024, `${bytes} bytes: ${JSON.stringify(await Promise.all(sizes))}`);
  const { headers } = await fetch(`${server.url}mvw.wasm`, { headers: { 'Accept-Encoding': 'gzip' } });
  assert.equal(headers.get('content-encoding'), 'gzip');
});

test('behind tokens the page shows what its own one opens, and without one nothing', async () => {
  const { keys, token } = makeToken('golden');
  const guarded = await new Server().start(['--tokens', keys]);
  try {
    const list = tab.waitForResponse((response) => response.url().endsWith('/models'));
    await tab.goto(guarded.url);
    assert.deepEqual((await (await list).json()).models, []);
    assert.equal(await tab.locator('.card').count(), 0);
    await tab.goto(`${guarded.url}?token=${token}`);
    await tab.waitForFunction(() => document.querySelectorAll('.card[data-bytes]').length === 1);
    assert.deepEqual(await tab.locator('.card strong').allInnerTexts(), ['golden']);
    await tab.locator('.card').click();
    await complete(tab);
    assert.equal((await fetch(`${guarded.url}models/golden.mvw`)).status, 401);
    assert.equal((await fetch(`${guarded.url}models/ball.mvw?token=${token}`)).status, 403);
  } finally {
    await guarded.kill();
  }
});

test('the gallery shows each model, drawn from the first 4 KB of its file', async () => {
  const ranges = [];
  tab.on('request', (request) => {
    if (request.url().includes('.mvw')) ranges.push(request.headers().range);
  });
  await tab.goto(server.url);
  await tab.waitForFunction(() => document.querySelectorAll('.card[data-bytes]').length === 2);
  assert.deepEqual(ranges, ['bytes=0-4095', 'bytes=0-4095']);
  assert.deepEqual(await tab.locator('.card strong').allInnerTexts(), ['ball', 'golden']);
  await settle(tab);
  await looksLike(tab, 'gallery');
});

test('a model refines to its end: less and less error, all of the file', async () => {
  await tab.goto(server.url);
  await tab.waitForSelector('.card');
  await tab.evaluate(() => {
    globalThis.seen = [];
    new MutationObserver(() => {
      const read = (name) => document.querySelector(`[data-stat="${name}"] dd`)?.firstChild.data;
      if (read('Triangles')) globalThis.seen.push(parseFloat(read('Error')));
    }).observe(document.querySelector('#stats'), { childList: true });
    document.querySelector('[data-choice=speed] [value="128"]').click();
  });
  await tab.locator('.card', { hasText: 'ball' }).click();
  await complete(tab);
  const seen = await tab.evaluate(() => globalThis.seen);
  assert.ok(seen.every((error, i) => i === 0 || error <= seen[i - 1]), `errors seen: ${seen}`);
  assert.ok(seen.length >= 6, `${seen.length} refinements`);
  assert.match(await figure(tab, 'Bytes'), new RegExp(`of ${(size / 1024).toFixed(size < 10240 ? 1 : 0)} KB`));
  await settle(tab);
  await looksLike(tab, 'viewer');
});

test('the limiter makes the link as slow as it says', async () => {
  await open('ball');
  const begun = Date.now();
  await tab.click('[data-choice=speed] [value="128"]');
  await tab.click('#again');
  await tab.waitForSelector('#status[data-kind=streaming]');
  await complete(tab);
  const least = (size / (128000 / 8)) * 1000;
  assert.ok(Date.now() - begun > 0.8 * least, `${Date.now() - begun} ms for ${size} bytes`);
});

test('sliders of level and layer choose what is drawn', async () => {
  await open('ball');
  const whole = await stagePixels(tab);
  await tab.fill('#level', '0');
  await tab.waitForFunction(() => document.querySelector('[data-stat="Level"] dd').firstChild.data === '0');
  const base = await figure(tab, 'Triangles');
  assert.ok(parseFloat(base) < 2000, base);
  await changes(tab, whole, 0.005);
  await tab.fill('#level', await tab.getAttribute('#level', 'max'));
  const error = await figure(tab, 'Error');
  await tab.fill('#layer', '2');
  await tab.waitForFunction((before) => document.querySelector('[data-stat="Error"] dd').innerText !== before, error);
  assert.ok(parseFloat(await figure(tab, 'Error')) > parseFloat(error));
  await tab.fill('#layer', await tab.getAttribute('#layer', 'max'));
  await tab.waitForFunction((before) => document.querySelector('[data-stat="Error"] dd').innerText === before, error);
  await isAgain(tab, whole);
});

test('the plot goes back to any number of bytes, by pointer and by key', async () => {
  await open('ball');
  const error = parseFloat(await figure(tab, 'Error'));
  const plot = await tab.locator('#plot').boundingBox();
  await tab.mouse.click(plot.x + 0.3 * plot.width, plot.y + 0.5 * plot.height);
  await tab.waitForFunction((before) => parseFloat(document.querySelector('[data-stat="Error"] dd').innerText) > before, error);
  assert.ok(parseFloat(await figure(tab, 'Bytes')) < size / 1024);
  await looksLike(tab.locator('#plotBox'), 'plot', 0.06);
  await tab.focus('#plot');
  await tab.keyboard.press('End');
  await tab.waitForFunction((before) => parseFloat(document.querySelector('[data-stat="Error"] dd').innerText) === before, error);
});

test('backs are seen unless a front is close behind them', async () => {
  const other = await new Server(makeBacks()).start();
  try {
    await tab.goto(`${other.url}#backs`);
    await complete(tab);
    const pixels = await stagePixels(tab);
    let [backs, fronts] = [0, 0];
    for (let i = 0; i < pixels.length; i += 4) {
      const [r, g, b] = pixels.subarray(i, i + 3);
      if (r > 80 && r > 1.4 * g && r > 1.4 * b) backs++;
      else if (r > 100 && r > b) fronts++;
    }
    assert.ok(backs + fronts > 0.1 * (pixels.length / 4), `${backs} and ${fronts} pixels`);
    assert.ok(Math.abs(backs - fronts) < 0.1 * (backs + fronts), `${backs} and ${fronts} pixels`);
  } finally {
    await other.kill();
  }
});

test('wireframe, base edges and flat shading show, by button and by key', async () => {
  await open('ball');
  const plain = await stagePixels(tab);
  await tab.click('[data-toggle=edges]');
  await changes(tab, plain, 0.05);
  await tab.keyboard.press('b');
  await tab.fill('#level', '1');
  await tab.waitForFunction(() => document.querySelector('[data-stat="Level"] dd').firstChild.data === '1');
  await tab.waitForTimeout(1000);
  await looksLike(tab, 'wireframe');
  await tab.keyboard.press('w');
  await tab.keyboard.press('b');
  await tab.fill('#level', await tab.getAttribute('#level', 'max'));
  await isAgain(tab, plain);
  await tab.click('[data-choice=shading] [value=flat]');
  await changes(tab, plain, 0.02);
});

test('mouse, wheel and keys turn, move and bring nearer; a double click puts it back', async () => {
  await open('ball');
  const stage = await tab.locator('#stage').boundingBox();
  const [x, y] = [stage.x + 300, stage.y + 250];
  const home = await stagePixels(tab);
  const drag = async (options) => {
    await tab.mouse.move(x, y);
    await tab.mouse.down(options);
    await tab.mouse.move(x + 120, y + 40, { steps: 4 });
    await tab.mouse.up(options);
  };
  for (const act of [() => drag(), () => drag({ button: 'right' }), () => tab.mouse.wheel(0, -400),
    () => tab.keyboard.press('ArrowLeft'), () => tab.keyboard.press('Shift+ArrowUp'), () => tab.keyboard.press('+')]) {
    await tab.mouse.move(x, y);
    await act();
    await changes(tab, home, 0.01, String(act));
    await tab.mouse.dblclick(x, y);
    await isAgain(tab, home, `after ${act}`);
  }
});

test('two fingers bring it nearer', async () => {
  await open('ball');
  const home = await stagePixels(tab);
  const cdp = await tab.context().newCDPSession(tab);
  const touch = (type, ...points) =>
    cdp.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  await touch('touchStart', [300, 300], [360, 300]);
  for (let i = 1; i <= 5; i++) await touch('touchMove', [300 - 12 * i, 300], [360 + 12 * i, 300]);
  await touch('touchEnd');
  await changes(tab, home, 0.02);
});

for (const via of ['http', 'ws'])
  test(`killed in the middle and started again, the server goes on where it was (${via})`, async () => {
    const ranges = [];
    tab.on('request', (request) => ranges.push(request.headers().range));
    await tab.goto(server.url);
    await tab.evaluate((v) => {
      document.querySelector('[data-choice=speed] [value="128"]').click();
      document.querySelector(`[data-choice=via] [value="${v}"]`).click();
    }, via);
    await tab.goto(`${server.url}#ball`);
    await tab.waitForSelector('[data-stat="Triangles"]');
    const lost = '#banner[data-kind=lost]:not([hidden])';
    let held;
    try {
      // On a busy machine all of it may have come before the server is dead: then once more.
      for (let tries = 5; ; --tries) {
        await server.kill();
        await tab.waitForSelector(`${lost}, #status[data-kind=complete]`, { timeout: 20000 });
        held = parseFloat(await figure(tab, 'Bytes'));
        if (tries === 0 || ((await tab.locator(lost).count()) > 0 && held > 0 && held < size / 1024)) break;
        await server.start();
        await beginsAnew(tab, () => tab.click('#again'));
        await eventually(async () => parseFloat(await figure(tab, 'Bytes')) > 0, 'bytes should come');
      }
      assert.match(await tab.innerText('#banner'), /server is away/);
      assert.ok(held > 0 && held < size / 1024);
    } finally {
      await server.start(); // the tests after this one need it, too
    }
    await complete(tab);
    if (via === 'http') assert.ok(ranges.some((range) => /^bytes=[1-9]\d*-/.test(range ?? '')), String(ranges));
    assert.equal(await tab.locator(lost).count(), 0);
  });

test('over a WebSocket the same model arrives', async () => {
  await open('ball');
  const triangles = await figure(tab, 'Triangles');
  const error = await figure(tab, 'Error');
  await beginsAnew(tab, () => tab.click('[data-choice=via] [value=ws]'));
  await complete(tab);
  assert.equal(await figure(tab, 'Triangles'), triangles);
  assert.equal(await figure(tab, 'Error'), error);
});

test('a model in colours shows them; over a WebSocket what the camera sees is asked for first', async () => {
  const painted = await new Server(makePainted()).start();
  try {
    await tab.goto(painted.url);
    await tab.evaluate(() => {
      document.querySelector('[data-choice=speed] [value="128"]').click();
      document.querySelector('[data-choice=via] [value="ws"]').click();
    });
    await tab.goto(`${painted.url}#painted`);
    await tab.waitForSelector('[data-stat="Triangles"]');
    await tab.locator('#stage').hover();
    for (let i = 0; i < 4; i++) await tab.mouse.wheel(0, -400); // near enough that not all is in view
    await tab.waitForTimeout(600);
    await tab.locator('#stage').dblclick();
    await tab.evaluate(() => document.querySelector('[data-choice=speed] [value="full"]').click());
    await complete(tab);
    await settle(tab);
    await looksLike(tab, 'painted');
    const colored = await stagePixels(tab);
    await tab.keyboard.press('c');
    await changes(tab, colored, 0.1);
    await tab.evaluate(() => (location.hash = ''));
    await eventually(async () => {
      const metrics = await (await fetch(`${painted.url}metrics`)).text();
      const requests = Number(/^mvw_requests_total (\d+)/m.exec(metrics)[1]);
      return requests >= 2 || `${requests} requests`; // the first, and one for a view at least
    }, 'the camera should be heard by the server');
  } finally {
    await painted.kill();
  }
});

test('the gallery says that the server is away, and comes back with it', async () => {
  await tab.goto(server.url);
  await tab.waitForSelector('.card');
  await tab.goto(`${server.url}#ball`);
  await server.kill();
  try {
    await tab.evaluate(() => (location.hash = ''));
    await tab.waitForSelector('#nothing:not([hidden])');
    assert.match(await tab.innerText('#nothing'), /does not answer/);
  } finally {
    await server.start();
  }
  await tab.waitForSelector('#nothing', { state: 'hidden', timeout: 20000 });
});

test('a model that is not there is said to be so', async () => {
  await tab.goto(`${server.url}#no/such`);
  await tab.waitForSelector('#banner[data-kind=failed]:not([hidden])');
  assert.match(await tab.innerText('#banner'), /cannot be shown.*404/);
  tab.faults.length = 0; // the browser reports the 404 as well
});

test('on a phone nothing sticks out, and the controls fold', async () => {
  await tab.context().close();
  tab = await openTab(browser, { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true });
  await open('ball');
  const widths = () => tab.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.deepEqual(await widths(), [390, 390]);
  assert.equal(await tab.isVisible('#controls'), false);
  await settle(tab);
  await looksLike(tab, 'phone');
  await tab.tap('#fold');
  assert.equal(await tab.isVisible('#controls'), true);
  assert.deepEqual(await widths(), [390, 390]);
  await tab.tap('#home');
  await tab.waitForSelector('.card');
  assert.deepEqual(await widths(), [390, 390]);
});

test('light and dark: by the system, then by choice, which is remembered', async () => {
  await tab.goto(server.url);
  assert.equal(await tab.getAttribute('html', 'data-theme'), 'dark');
  await tab.click('#theme');
  await tab.reload();
  assert.equal(await tab.getAttribute('html', 'data-theme'), 'light');
  await open('ball');
  await settle(tab);
  await looksLike(tab, 'light');
});

test('our own work holds the main thread for at most 16 ms at a time', async () => {
  await open('ball', false);
  await complete(tab);
  for (let i = 0; i < 10; i++) await tab.keyboard.press('ArrowRight');
  await tab.fill('#level', '2');
  await settle(tab);
  const work = await tab.evaluate(async () => (await import('./work.js')).work);
  const late = work.times.filter((time) => time > 16);
  assert.ok(work.times.length > 20);
  // On a machine that does other things, a moment's absence is not our work: it hits one task, not several.
  assert.ok(late.length <= 1, `${late.length} of ${work.times.length} over 16 ms, the longest ${work.longest} (${work.name})`);
});
