// MvwLoader for three.js: an ordinary BufferGeometry that refines in place.
//
//   import { Mesh, MeshStandardMaterial } from 'three';
//   import { MvwLoader } from 'mvw/three';
//   const geometry = await new MvwLoader().loadAsync('bunny.mvw');   // the first mesh; it refines by itself
//   scene.add(new Mesh(geometry, new MeshStandardMaterial()));
//
// A surface that is no solid's wants a material of `side: DoubleSide`: geometry.userData.mvw.drawable.solid, which may turn
// false while parts come ('refined').

import { BufferAttribute, BufferGeometry, Loader, Sphere, Vector3 } from 'three';
import { openModel } from './mvw.js';

/**
 * Buffers are made for the finest level; refinements fill them and move the draw range. Where more comes (vertices
 * between two colours are there once for each, and a file may end with more triangles), larger ones take their place.
 */
class Refiner {
  constructor(model, geometry) {
    this.model = model;
    this.geometry = geometry;
    geometry.userData.mvw = model;
    model.addEventListener('refined', () => this.refine());
  }

  refine() {
    const { geometry, model } = this;
    const { drawable, about } = model;
    const vertices = drawable.positions.length / 3;
    if (!geometry.attributes.position) this.make(Math.max(about.vertices.at(-1), vertices), about.faces.at(-1));
    this.fill('position', drawable.positions);
    this.fill('normal', drawable.normals);
    if (drawable.colors) this.fill('color', drawable.colors);
    if (this.connectivity !== drawable.connectivity) {
      this.connectivity = drawable.connectivity;
      if (drawable.triangles.length > geometry.index.array.length)
        geometry.setIndex(new BufferAttribute(new Uint32Array(drawable.triangles.length), 1));
      update(geometry.index, drawable.triangles);
      geometry.setDrawRange(0, drawable.triangles.length);
    }
    this.bound(drawable.positions);
    geometry.dispatchEvent({ type: 'refined', model });
  }

  make(vertices, faces) {
    const { geometry } = this;
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(3 * vertices), 3));
    geometry.setAttribute('normal', new BufferAttribute(new Float32Array(3 * vertices), 3));
    geometry.setIndex(new BufferAttribute(new Uint32Array(3 * faces), 1));
  }

  fill(name, values) {
    const { geometry } = this;
    if (name === 'color' && !geometry.attributes.color)
      geometry.setAttribute('color', new BufferAttribute(new Uint8Array((geometry.attributes.position.count) * 4), 4, true));
    const old = geometry.attributes[name];
    if (values.length > old.array.length)
      geometry.setAttribute(name, new BufferAttribute(new values.constructor(values.length), old.itemSize, old.normalized));
    update(geometry.attributes[name], values);
  }

  /** Picking and culling ask the sphere; the buffers' unused ends must not count. */
  bound(positions) {
    const sphere = (this.geometry.boundingSphere ??= new Sphere(new Vector3(), 0));
    let radius = 0;
    for (let i = 0; i < positions.length; i += 3)
      radius = Math.max(radius, positions[i] ** 2 + positions[i + 1] ** 2 + positions[i + 2] ** 2);
    sphere.radius = Math.sqrt(radius);
  }
}

function update(attribute, values) {
  attribute.array.set(values);
  attribute.clearUpdateRanges();
  attribute.addUpdateRange(0, values.length);
  attribute.needsUpdate = true;
}

/**
 * load(url, onLoad) calls onLoad(geometry) with the first mesh; loadAsync() resolves with it. From then on the geometry
 * refines by itself and dispatches 'refined'; geometry.userData.mvw is the Model (setView, setPace, completed, close).
 * Positions are relative to the middle of the model's box.
 */
export class MvwLoader extends Loader {
  /** Options for openModel(). */
  options = {};

  load(url, onLoad, onProgress, onError) {
    const path = this.path ? new URL(url, new URL(this.path, location.href)).href : url;
    const model = openModel(path, this.options);
    const geometry = new BufferGeometry();
    new Refiner(model, geometry);
    const close = geometry.dispose;
    geometry.dispose = () => {
      model.close();
      close.call(geometry);
    };
    this.manager.itemStart(path);
    model.first().then(
      () => {
        onLoad(geometry);
        this.manager.itemEnd(path);
      },
      (error) => {
        onError?.(error);
        this.manager.itemError(path);
        this.manager.itemEnd(path);
      },
    );
    if (onProgress)
      model.addEventListener('refined', () =>
        onProgress({ lengthComputable: true, loaded: model.state.bytes, total: model.about.fileBytes }));
  }
}
