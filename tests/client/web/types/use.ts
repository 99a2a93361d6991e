// Compiles only while the types say what the library does.
import { Mesh, MeshStandardMaterial, Scene } from 'three';
import { MvwError, openModel, type StreamedDrawable } from 'mvw';
import { createModule, decode, Decoder } from 'mvw/module';
import { MvwLoader } from 'mvw/three';

export async function show(scene: Scene): Promise<void> {
  const geometry = await new MvwLoader().loadAsync('bunny.mvw');
  scene.add(new Mesh(geometry, new MeshStandardMaterial()));
}

export async function plain(): Promise<number> {
  const model = openModel('bunny.mvw', { bytesPerSecond: 125000, view: { level: 3 } });
  model.addEventListener('refined', () => console.log(model.drawable?.triangles.length));
  model.setView({ level: null, edges: true });
  const drawable: StreamedDrawable | null = (await model.completed()).drawable;
  return drawable === null ? 0 : drawable.positions.length;
}

export async function without(bytes: Uint8Array<ArrayBuffer>): Promise<Uint32Array> {
  const module = await createModule(bytes);
  const decoder = new Decoder(module);
  try {
    decoder.feed(bytes);
  } catch (error) {
    if (error instanceof MvwError && error.code === 'malformed') decoder.delete();
  }
  return decode(module, bytes).triangles;
}

// @ts-expect-error: a view has no such field
openModel('bunny.mvw', { view: { levels: 3 } });
