// What the tests read: the module that client/web/build.sh made, the golden files of the C++ tests.
import { readdirSync, readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import path from 'node:path';

export const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../..');
export const built = process.env.MVW_WEB ?? path.join(root, 'build/web');
export const wasm = readFileSync(path.join(built, 'mvw/src/mvw.wasm'));

const data = path.join(root, 'tests/data');
export const golden = readdirSync(data)
  .filter((file) => /^golden_.*\.digest$/.test(file))
  .map((file) => {
    const name = path.parse(file).name;
    const read = (extension) => readFileSync(path.join(data, name + extension));
    return { name, bytes: new Uint8Array(read('.mvw')), digest: String(read('.digest')).trim(), off: String(read('.off')) };
  });

/** Triangles and vertices of an OFF file as mvw writes it. */
export function readOff(text) {
  const words = text.split(/\s+/).filter(Boolean);
  const [vertices, faces] = [Number(words[1]), Number(words[2])];
  const each = words[0] === 'COFF' ? 7 : 3; // colours follow the position
  const numbers = words.slice(4, 4 + each * vertices).map(Number);
  const positions = numbers.filter((_, i) => i % each < 3);
  const triangles = [];
  for (let f = 0, at = 4 + each * vertices; f < faces; f++, at += 4)
    triangles.push(...words.slice(at + 1, at + 4).map(Number));
  return { positions, triangles };
}
