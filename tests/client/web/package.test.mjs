// The npm package and the page as they are shipped.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { brotliDecompressSync, gunzipSync } from 'node:zlib';
import { built, root } from './files.mjs';

// Browsers that can run the module take brotli from any secure origin; gzip is for plain HTTP between machines.
for (const [ending, unpack, most] of [['.br', brotliDecompressSync, 150], ['.gz', gunzipSync, 175]])
  test(`page and module together take at most ${most} KB as they are sent (${ending})`, () => {
    const page = process.env.MVW_PAGE ?? path.join(root, 'build/page');
    let bytes = 0;
    for (const name of readdirSync(page).filter((file) => !/\.(br|gz)$/.test(file))) {
      const packed = readFileSync(path.join(page, name + ending));
      assert.ok(unpack(packed).equals(readFileSync(path.join(page, name))), name);
      bytes += packed.length;
    }
    assert.ok(bytes > 80000 && bytes <= most * 1024, `${bytes} bytes`);
  });

test('the types describe the library', () => {
  const tsc = path.join(root, 'tests/client/web/node_modules/typescript/bin/tsc');
  const ran = spawnSync(process.execPath, [tsc, '-p', path.join(root, 'tests/client/web/types')], { encoding: 'utf8' });
  assert.equal(ran.status, 0, ran.stdout);
});

test('npm packs what the package names, and node can import it', async () => {
  const folder = path.join(built, 'mvw');
  const about = JSON.parse(readFileSync(path.join(folder, 'package.json'), 'utf8'));
  const names = Object.values(about.exports).flatMap((entry) => (typeof entry === 'string' ? [entry] : Object.values(entry)));
  for (const name of names) readFileSync(path.join(folder, name));
  const { createModule } = await import(path.join(folder, about.exports['./module'].default));
  const module = await createModule(readFileSync(path.join(folder, about.exports['./mvw.wasm'])));
  assert.ok(module);
});

test('nothing in it makes code from text', () => {
  for (const file of readdirSync(path.join(built, 'mvw/src')).filter((name) => name.endsWith('.js')))
    assert.doesNotMatch(readFileSync(path.join(built, 'mvw/src', file), 'utf8'), /\beval\(|new Function\(/);
});
