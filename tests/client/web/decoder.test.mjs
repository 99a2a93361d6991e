// The browser's decoder against the golden files of the C++ tests: the same coefficients bit for bit, the same mesh.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createModule, decode, Decoder, MvwError } from '../../../client/web/src/module.js';
import { golden, readOff, wasm } from './files.mjs';

const module = await createModule(wasm);

function feedAll(bytes) {
  const decoder = new Decoder(module);
  decoder.feed(bytes);
  return decoder;
}

/// Number of each vertex, copies that stand between two colours (the last ones of a mesh) having that of their original.
function originals({ positions }) {
  const place = (v) => positions.subarray(3 * v, 3 * v + 3).join();
  const first = new Map();
  return Array.from({ length: positions.length / 3 }, (_, v) => {
    if (!first.has(place(v))) first.set(place(v), v);
    return first.get(place(v));
  });
}

for (const { name, bytes, digest, off } of golden) {
  const hasCopies = name.includes('materials');

  test(`${name}: the coefficients are those of the C++ decoder, bit for bit`, () => {
    const decoder = feedAll(bytes);
    assert.equal(decoder.digest(), digest);
    assert.equal(decoder.state().complete, true);
    decoder.delete();
  });

  test(`${name}: the triangles are the same integers, the vertices the same to a millionth`, () => {
    const expected = readOff(off);
    const mesh = decode(module, bytes);
    assert.deepEqual(Array.from(mesh.triangles), expected.triangles);
    assert.equal(mesh.positions.length, expected.positions.length);
    const low = [0, 1, 2].map((k) => Math.min(...expected.positions.filter((_, i) => i % 3 === k)));
    const high = [0, 1, 2].map((k) => Math.max(...expected.positions.filter((_, i) => i % 3 === k)));
    const diagonal = Math.hypot(...high.map((h, k) => h - low[k]));
    // Positions are relative to a middle of the box that only the header knows exactly: the offset is the same for all.
    const offset = [0, 1, 2].map((k) => expected.positions[k] - mesh.positions[k]);
    for (let i = 0; i < mesh.positions.length; i++)
      assert.ok(Math.abs(mesh.positions[i] + offset[i % 3] - expected.positions[i]) < 1e-6 * diagonal, `number ${i}`);
  });

  test(`${name}: it is solid where each of its edges has two faces and they enclose something`, () => {
    const mesh = decode(module, bytes);
    const { positions, solid } = mesh;
    const original = originals(mesh);
    const triangles = hasCopies ? mesh.triangles.map((v) => original[v]) : mesh.triangles;
    const sides = new Set();
    let volume = 0;
    for (let t = 0; t < triangles.length; t += 3) {
      const [a, b, c] = triangles.subarray(t, t + 3);
      for (const side of [[a, b], [b, c], [c, a]]) sides.add(side.join());
      const [p, q, r] = [a, b, c].map((v) => positions.subarray(3 * v, 3 * v + 3));
      volume += p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) + p[2] * (q[0] * r[1] - q[1] * r[0]);
    }
    const closed = [...sides].every((side) => sides.has(side.split(',').reverse().join()));
    assert.equal(solid, closed && volume > 0);
  });

  test(`${name}: a byte at a time gives the same as all at once`, () => {
    const decoder = new Decoder(module);
    for (const byte of bytes) decoder.feed(Uint8Array.of(byte));
    assert.equal(decoder.digest(), digest);
    decoder.delete();
  });

  test(`${name}: every beginning is a model or too short, and more bytes state no larger error`, () => {
    let error = 1;
    const decoder = new Decoder(module);
    for (let n = 0; n < bytes.length; n += 7) {
      decoder.feed(bytes.subarray(n, n + 7));
      const mesh = decoder.draw();
      if (mesh === null) continue;
      assert.ok(mesh.triangles.every((v) => v < mesh.positions.length / 3));
      assert.ok(mesh.error <= error);
      error = mesh.error;
    }
    decoder.delete();
  });

  test(`${name}: the index gives every chunk's place and error; a view of few layers or bytes is a coarser model`, () => {
    const decoder = feedAll(bytes);
    const points = decoder.points();
    assert.ok(points.length >= 4);
    for (let i = 2; i < points.length; i += 2) assert.ok(points[i] > points[i - 2] && points[i + 1] <= points[i - 1]);
    const about = decoder.description();
    assert.equal(about.fileBytes, bytes.length);
    assert.ok(points.at(-2) <= about.indexOffset);

    const whole = decoder.draw();
    const early = decoder.draw({ bytes: points[0] });
    assert.ok(early.error >= whole.error && early.bytes < whole.bytes);
    const bases = decoder.draw({ level: 0 });
    assert.equal(hasCopies ? new Set(originals(bases)).size : bases.positions.length / 3, about.vertices[0]);
    assert.equal(bases.triangles.length / 3, about.faces[0]);
    const lowLayer = decoder.draw({ layer: 0 });
    assert.ok(lowLayer.bytes < whole.bytes);
    assert.deepEqual(decoder.draw().positions, whole.positions);
    decoder.delete();
  });

  test(`${name}: edges are each triangle's, once; base edges lie among them`, () => {
    const decoder = feedAll(bytes);
    const mesh = decoder.draw({ edges: true, baseEdges: true });
    const original = originals(mesh);
    const named = (v) => (hasCopies ? original[v] : v);
    const key = (...ends) => ends.map(named).sort((a, b) => a - b).join(' ');
    const edges = new Set();
    for (let t = 0; t < mesh.triangles.length; t += 3)
      for (let k = 0; k < 3; k++) edges.add(key(mesh.triangles[t + k], mesh.triangles[t + ((k + 1) % 3)]));
    const drawn = [];
    for (let i = 0; i < mesh.edges.length; i += 2) drawn.push(key(mesh.edges[i], mesh.edges[i + 1]));
    // Those at copies may come as often as they have faces.
    if (!hasCopies) assert.equal(new Set(drawn).size, drawn.length);
    assert.deepEqual(new Set(drawn), edges);
    for (let i = 0; i < mesh.baseEdges.length; i += 2)
      assert.ok(edges.has(key(mesh.baseEdges[i], mesh.baseEdges[i + 1])));
    decoder.delete();
  });

  test(`${name}: a changed byte of a chunk is noticed, and nothing but an MvwError is ever thrown`, () => {
    const { headerBytes, indexOffset } = feedAll(bytes).description();
    for (let at = 0; at < bytes.length; at += 23) {
      const damaged = Uint8Array.from(bytes);
      damaged[at] ^= 0x55;
      const decoder = new Decoder(module);
      try {
        decoder.feed(damaged);
        decoder.draw();
        const isChunk = at >= headerBytes && at < indexOffset;
        if (isChunk) assert.notEqual(`${decoder.digest()} ${decoder.state().damaged}`, `${digest} 0`, `byte ${at}`);
      } catch (error) {
        assert.ok(error instanceof MvwError, String(error));
      }
      decoder.delete();
    }
  });
}

test('a drawable of the same triangles does not send them again', () => {
  const { bytes } = golden[0];
  const decoder = feedAll(bytes);
  const first = decoder.draw({ edges: true });
  const second = decoder.draw({ edges: true }, first);
  assert.equal(second.triangles, undefined);
  assert.equal(second.edges, undefined);
  assert.ok(decoder.draw({ level: 0, edges: true }, first).triangles.length > 0);
  decoder.delete();
});
