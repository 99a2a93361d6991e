// Draws one model with WebGL 2: the surface, its triangles' edges, the base mesh's edges. Draws only when asked to.

const SURFACE = [`#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 color;
uniform mat4 view, projection;
uniform float further;
out vec3 at, way;
out vec3 tint;
void main() {
  vec4 p = view * vec4(position, 1.0);
  at = p.xyz;
  way = mat3(view) * normal;
  tint = pow(color.rgb, vec3(2.2));
  gl_Position = projection * p;
  if (further > 0.0 && gl_Position.w > 0.0) {
    p.z -= further;
    p = projection * p;
    gl_Position.z = p.z * gl_Position.w / p.w;
  }
}`, `#version 300 es
precision highp float;
in vec3 at, way, tint;
uniform vec3 clay, inside;
uniform bool flatly;
out vec4 pixel;
void main() {
  vec3 facet = normalize(cross(dFdx(at), dFdy(at)));
  vec3 n = dot(way, way) > 0.0 ? normalize(way) : facet;
  vec3 base = clay * tint;
  if (!gl_FrontFacing) { n = -n; base = inside; }
  if (dot(facet, at) > 0.0) facet = -facet;
  // Along a sharp edge the averaged normal is no side's: the facet's own is right.
  if (flatly || dot(n, facet) < 0.72) n = facet;
  vec3 eye = normalize(-at);
  vec3 key = normalize(vec3(-0.45, 0.65, 0.6)), rim = normalize(vec3(0.75, 0.25, -0.35));
  vec3 light = mix(vec3(0.17, 0.15, 0.15), vec3(0.42, 0.44, 0.48), 0.5 * n.y + 0.5)
             + vec3(1.15, 1.08, 0.98) * max(dot(n, key), 0.0) + vec3(0.20, 0.24, 0.32) * max(dot(n, rim), 0.0);
  float shine = pow(max(dot(n, normalize(key + eye)), 0.0), 36.0);
  float graze = pow(1.0 - max(dot(n, eye), 0.0), 3.0);
  vec3 lit = base * light + vec3(0.10) * shine + base * graze * 0.22;
  pixel = vec4(pow(lit / (1.0 + 0.25 * lit), vec3(1.0 / 2.2)), 1.0);
}`];

const LINES = [`#version 300 es
layout(location = 0) in vec3 position;
uniform mat4 view, projection;
uniform float nearer;
void main() {
  gl_Position = projection * (view * vec4(position, 1.0));
  gl_Position.z -= nearer * gl_Position.w;
}`, `#version 300 es
precision highp float;
uniform vec4 ink;
out vec4 pixel;
void main() { pixel = vec4(ink.rgb * ink.a, ink.a); }`];

function build(gl, [vertex, fragment]) {
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const uniforms = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const { name } = gl.getActiveUniform(program, i);
    uniforms[name] = gl.getUniformLocation(program, name);
  }
  return { program, uniforms };
}

/** Linear light of a CSS colour #rrggbb. */
const linear = (hex) => [1, 3, 5].map((k) => (parseInt(hex.slice(k, k + 2), 16) / 255) ** 2.2);

export class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = (this.gl = canvas.getContext('webgl2', { antialias: true, alpha: true, preserveDrawingBuffer: false }));
    if (!gl) throw new Error('this browser has no WebGL 2');
    this.surface = build(gl, SURFACE);
    this.lines = build(gl, LINES);
    this.buffers = {};
    for (const name of ['positions', 'normals', 'colors', 'triangles', 'edges', 'baseEdges']) this.buffers[name] = gl.createBuffer();
    this.held = {};
    this.array = gl.createVertexArray();
    this.options = { flat: false, edges: false, baseEdges: false, colors: true };
    this.palette = { clay: linear('#d3c8b8'), inside: linear('#b5523f'), edge: [0, 0, 0, 0.4], base: [0.9, 0.5, 0.2, 1] };
  }

  /** Takes a drawable (src/module.js); only what is new goes to the card. */
  take(drawable) {
    if (drawable === this.held) return;
    const { gl } = this;
    gl.bindVertexArray(this.array);
    for (const [slot, name, size, type, unit] of [[0, 'positions', 3, gl.FLOAT, false], [1, 'normals', 3, gl.FLOAT, false],
      [2, 'colors', 4, gl.UNSIGNED_BYTE, true]]) {
      if (!drawable[name]) continue;
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
      if (this.held[name] !== drawable[name]) gl.bufferData(gl.ARRAY_BUFFER, drawable[name], gl.DYNAMIC_DRAW);
      gl.vertexAttribPointer(slot, size, type, unit, 0, 0);
    }
    gl.enableVertexAttribArray(0);
    gl.enableVertexAttribArray(1);
    for (const name of ['triangles', 'edges', 'baseEdges']) {
      if (!drawable[name] || this.held[name] === drawable[name]) continue;
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers[name]);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, drawable[name], gl.STATIC_DRAW);
    }
    this.held = drawable;
  }

  clear() {
    this.held = {};
  }

  draw(camera) {
    const { gl, canvas, held, options } = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (!held.triangles) return;
    const { view, projection, away } = camera.matrices(canvas.width / canvas.height);
    gl.bindVertexArray(this.array);
    gl.enable(gl.DEPTH_TEST);
    const use = ({ program, uniforms }) => {
      gl.useProgram(program);
      gl.uniformMatrix4fv(uniforms.view, false, view);
      gl.uniformMatrix4fv(uniforms.projection, false, projection);
      return uniforms;
    };
    const colored = options.colors && held.colors;
    if (colored) gl.enableVertexAttribArray(2);
    else {
      gl.disableVertexAttribArray(2);
      gl.vertexAttrib4f(2, 1, 1, 1, 1);
    }
    let uniforms = use(this.surface);
    gl.uniform3fv(uniforms.clay, colored ? [1, 1, 1] : this.palette.clay);
    gl.uniform3fv(uniforms.inside, this.palette.inside);
    gl.uniform1i(uniforms.flatly, options.flat);
    // Folds of coarse levels are not to be seen: of solids no backs are drawn from outside, and those of other surfaces half
    // a percent of the diagonal further away than they lie (client/viewer/sides.h).
    gl.enable(gl.CULL_FACE);
    this.side(gl.BACK, uniforms.further, 0);
    if (!held.solid || away <= camera.radius) this.side(gl.FRONT, uniforms.further, 0.01 * camera.radius);
    gl.disable(gl.CULL_FACE);
    gl.disableVertexAttribArray(2);
    if (!options.edges && !options.baseEdges) return;
    uniforms = use(this.lines);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    if (options.edges && held.edges) this.ink(uniforms, this.palette.edge, 1e-4, 'edges');
    if (options.baseEdges && held.baseEdges) this.ink(uniforms, this.palette.base, 3e-4, 'baseEdges');
    gl.disable(gl.BLEND);
  }

  /** Triangles whose `culled` side does not look at the eye. */
  side(culled, place, further) {
    this.gl.cullFace(culled);
    this.gl.uniform1f(place, further);
    this.elements(this.gl.TRIANGLES, 'triangles');
  }

  ink(uniforms, ink, nearer, name) {
    this.gl.uniform4fv(uniforms.ink, ink);
    this.gl.uniform1f(uniforms.nearer, nearer);
    this.elements(this.gl.LINES, name);
  }

  elements(mode, name) {
    this.gl.bindBuffer(this.gl.ELEMENT_ARRAY_BUFFER, this.buffers[name]);
    this.gl.drawElements(mode, this.held[name].length, this.gl.UNSIGNED_INT, 0);
  }
}
