// Simplifies a mesh to several sizes, moving vertices for the best fit (meshoptimizer's simplifyWithUpdate).
//
//   node simplify.mjs INPUT.raw OUTPUT_PREFIX SHARE...      SHARE: of the faces, 0 to 1
//
// Writes OUTPUT_PREFIX0.raw, OUTPUT_PREFIX1.raw and so on, one per share. A .raw file is, little-endian: u32 vertices,
// u32 faces, three f32 per vertex, three u32 per face.
import { readFileSync, writeFileSync } from 'node:fs';
import { MeshoptSimplifier } from 'meshoptimizer';

function readRaw(path) {
  const bytes = readFileSync(path);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  const [vertices, faces] = new Uint32Array(buffer, 0, 2);
  return {
    positions: new Float32Array(buffer, 8, 3 * vertices),
    indices: new Uint32Array(buffer, 8 + 12 * vertices, 3 * faces),
  };
}

function writeRaw(path, indices, positions) {
  const compact = indices.slice();
  const [remap, vertices] = MeshoptSimplifier.compactMesh(compact);
  const kept = new Float32Array(3 * vertices);
  remap.forEach((to, from) => {
    if (to < vertices) kept.set(positions.subarray(3 * from, 3 * from + 3), 3 * to);
  });
  const head = new Uint32Array([vertices, compact.length / 3]);
  writeFileSync(path, Buffer.concat([head, kept, compact].map((a) => Buffer.from(a.buffer, a.byteOffset, a.byteLength))));
}

const [input, prefix, ...shares] = process.argv.slice(2);
const mesh = readRaw(input);
await MeshoptSimplifier.ready;
shares.forEach((share, k) => {
  const indices = mesh.indices.slice();
  const positions = mesh.positions.slice();
  const target = Math.max(1, Math.round((share * indices.length) / 3)) * 3;
  const noAttributes = new Float32Array(0);
  const [count] = MeshoptSimplifier.simplifyWithUpdate(indices, positions, 3, noAttributes, 0, [], null, target, 1e9);
  writeRaw(`${prefix}${k}.raw`, indices.subarray(0, count), positions);
});
