// MvwLoader with three.js itself: an ordinary geometry, from a server that knows nothing but GET.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { launch, openTab } from './browser.mjs';
import { built, golden, root } from './files.mjs';

const PAGE = `<!doctype html><link rel="icon" href="data:,"><canvas id="view" width="300" height="300"></canvas>
<script type="importmap">{"imports": {"three": "/three/three.module.js", "mvw/three": "/mvw/three.js"}}</script>
<script type="module">
  import * as THREE from 'three';
  import { MvwLoader } from 'mvw/three';
  const scene = new THREE.Scene().add(new THREE.HemisphereLight(0xffffff, 0x444444, 3));
  const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 100);
  camera.position.set(0, 0, 16);
  const renderer = new THREE.WebGLRenderer({ canvas: view, preserveDrawingBuffer: true });
  const geometry = await new MvwLoader().loadAsync('/' + (location.search.slice(1) || 'mixed') + '.mvw');
  const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial());
  scene.add(mesh);
  renderer.setAnimationLoop(() => renderer.render(scene, camera));
  Object.assign(globalThis, { THREE, geometry, mesh, camera });
</script>`;

const types = { '.js': 'text/javascript', '.wasm': 'application/wasm' };
let server;
let browser;

before(async () => {
  server = createServer(async (request, response) => {
    const folder = { three: path.join(root, 'tests/client/web/node_modules/three/build'), mvw: path.join(built, 'mvw/src') };
    const [route] = request.url.split('?');
    const [, place, file] = route.split('/');
    if (route === '/') return response.setHeader('Content-Type', 'text/html').end(PAGE);
    const model = golden.find(({ name }) => route === `/${name.replace('golden_', '')}.mvw`);
    if (!model) {
      if (!folder[place]) return response.writeHead(404).end();
      response.setHeader('Content-Type', types[path.extname(file)]);
      return response.end(readFileSync(path.join(folder[place], file)));
    }
    response.setHeader('Content-Type', 'model/vnd.mvw');
    for (let at = 0; at < model.bytes.length; at += 60) {
      response.write(model.bytes.subarray(at, at + 60));
      await new Promise((resolve) => setTimeout(resolve, 120));
    }
    response.end();
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  browser = await launch();
});
after(async () => {
  await browser.close();
  server.closeAllConnections();
  server.close();
});

test('ten lines give a mesh that refines in place, is drawn, and can be picked', async () => {
  const tab = await openTab(browser);
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  await tab.waitForFunction(() => globalThis.mesh);
  const seen = await tab.evaluate(async () => {
    const { attributes, index } = geometry;
    const counts = [geometry.drawRange.count];
    geometry.addEventListener('refined', () => counts.push(geometry.drawRange.count));
    await geometry.userData.mvw.completed();
    await new Promise((done) => setTimeout(done, 300));
    const ray = new THREE.Raycaster();
    const middle = new THREE.Vector3().fromBufferAttribute(geometry.attributes.position, geometry.index.getX(0));
    ray.setFromCamera(middle.clone().project(camera), camera);
    const gl = view.getContext('webgl2');
    const pixels = new Uint8Array(300 * 300 * 4);
    gl.readPixels(0, 0, 300, 300, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return {
      counts,
      same: geometry.attributes.position === attributes.position && geometry.index === index,
      hits: ray.intersectObject(mesh).length,
      drawn: pixels.filter((value, i) => i % 4 === 0 && value > 40).length,
      triangles: geometry.userData.mvw.drawable.triangles.length,
      capacity: geometry.index.count,
    };
  });
  assert.deepEqual(tab.faults, []);
  assert.equal(seen.same, true);
  assert.ok(seen.counts.length >= 3, String(seen.counts));
  assert.ok(seen.counts.at(-1) > seen.counts[0], String(seen.counts));
  assert.equal(seen.counts.at(-1), seen.triangles);
  assert.equal(seen.capacity, seen.triangles);
  assert.ok(seen.hits >= 1);
  assert.ok(seen.drawn > 500, `${seen.drawn} pixels`);
  await tab.context().close();
});

for (const name of ['materials', 'closing'])
  test(`buffers grow where more comes than the finest level has: ${name}`, async () => {
    const tab = await openTab(browser);
    await tab.goto(`http://127.0.0.1:${server.address().port}/?${name}`);
    await tab.waitForFunction(() => globalThis.mesh);
    const seen = await tab.evaluate(async () => {
      const model = geometry.userData.mvw;
      await model.completed();
      await new Promise((done) => setTimeout(done, 300));
      const { positions, triangles } = model.drawable;
      const held = geometry.attributes.position.array.subarray(0, positions.length);
      return {
        same: held.length === positions.length && held.every((x, i) => x === positions[i]),
        most: Math.max(...triangles) < geometry.attributes.normal.count,
        drawn: geometry.drawRange.count === triangles.length && geometry.index.count >= triangles.length,
        colored: !model.drawable.colors || geometry.attributes.color.count === geometry.attributes.position.count,
      };
    });
    assert.deepEqual(seen, { same: true, most: true, drawn: true, colored: true });
    assert.deepEqual(tab.faults, []);
    await tab.context().close();
  });
