// A small renderer: lit triangles, thick lines, a shadow on the floor. Plain WebGL, no library. Matrices are column by column.

const BODY_VERTEX = `
attribute vec3 p, n; uniform mat4 eye, place; varying vec3 at, out_;
void main() { vec4 w = place * vec4(p, 1.0); at = w.xyz; out_ = mat3(place[0].xyz, place[1].xyz, place[2].xyz) * n; gl_Position = eye * w; }`;
const BODY_PIXEL = `
precision mediump float; uniform vec4 colour; uniform vec3 from, key; uniform float lit; varying vec3 at, out_;
void main() {
  vec3 n = normalize(out_), v = normalize(from - at);
  if (dot(n, v) < 0.0) n = -n;
  float day = 0.62 + 0.16 * n.z + 0.36 * max(dot(n, key), 0.0), edge = pow(1.0 - max(dot(n, v), 0.0), 3.0);
  float shine = 0.22 * pow(max(dot(n, normalize(key + v)), 0.0), 36.0);
  gl_FragColor = vec4(mix(colour.rgb, colour.rgb * day * (1.0 - 0.28 * edge) + shine, lit), colour.a);
}`;
const LINE_VERTEX = `
attribute vec3 p, q; attribute vec2 corner; attribute vec4 paint; uniform mat4 eye; uniform vec2 size; uniform float width; varying vec4 ink;
void main() {
  vec4 a = eye * vec4(p, 1.0), b = eye * vec4(q, 1.0);
  if (a.w < 0.01 || b.w < 0.01) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  vec2 d = (b.xy / b.w - a.xy / a.w) * size; d = length(d) > 0.0001 ? normalize(d) : vec2(1.0, 0.0);
  vec4 c = corner.x < 0.5 ? a : b; vec2 cap = d * (corner.x < 0.5 ? -1.0 : 1.0) * 0.35 * step(1.5, width);
  c.xy += (vec2(-d.y, d.x) * corner.y + cap) * width / size * c.w; ink = paint; gl_Position = c;
}`;
const LINE_PIXEL = "precision mediump float; uniform float veil; varying vec4 ink; void main() { gl_FragColor = vec4(ink.rgb, ink.a * veil); }";

const glPose = (pose) => new Float32Array([pose[0], pose[4], pose[8], 0, pose[1], pose[5], pose[9], 0, pose[2], pose[6], pose[10], 0, pose[3], pose[7], pose[11], 1]);

function glTimes(a, b) {
  const out = new Float32Array(16);
  for (let c = 0; c < 4; c += 1) for (let r = 0; r < 4; r += 1) for (let k = 0; k < 4; k += 1) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
  return out;
}

/** A renderer on a canvas; null where the browser has none. */
function makeRenderer(canvas) {
  const gl = canvas.getContext("webgl", { antialias: true, alpha: true, premultipliedAlpha: true, stencil: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const program = (vertex, pixel) => {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, pixel]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) return null;
    const names = (count, read) => Object.fromEntries(Array.from({ length: gl.getProgramParameter(made, count) }, (_, i) => read(i).name).map((name) => [name, null]));
    const spots = Object.keys(names(gl.ACTIVE_ATTRIBUTES, (i) => gl.getActiveAttrib(made, i)));
    const values = Object.keys(names(gl.ACTIVE_UNIFORMS, (i) => gl.getActiveUniform(made, i)));
    return { made, at: Object.fromEntries(spots.map((name) => [name, gl.getAttribLocation(made, name)])), set: Object.fromEntries(values.map((name) => [name, gl.getUniformLocation(made, name)])) };
  };
  const [body, line] = [program(BODY_VERTEX, BODY_PIXEL), program(LINE_VERTEX, LINE_PIXEL)];
  if (!body || !line) return null;
  const buffer = (data) => {
    const made = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return made;
  };
  const feed = (kind, name, data, width) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, data);
    gl.enableVertexAttribArray(kind.at[name]);
    gl.vertexAttribPointer(kind.at[name], width, gl.FLOAT, false, 0, 0);
  };

  const mesh = ({ joint, part, name, corners, normals }) => ({ joint, part, name, p: buffer(corners), n: buffer(normals), count: corners.length / 3 });

  /** Lines from segments [[x, y, z], [x, y, z], colour, colour], colours of four numbers. */
  const lines = (segments) => {
    const parts = { p: [], q: [], corner: [], paint: [] };
    for (const [a, b, from, to] of segments) {
      for (const [end, side] of [[0, -1], [0, 1], [1, 1], [0, -1], [1, 1], [1, -1]]) {
        parts.p.push(...a);
        parts.q.push(...b);
        parts.corner.push(end, side);
        parts.paint.push(...(end ? to : from));
      }
    }
    return { ...Object.fromEntries(Object.entries(parts).map(([name, values]) => [name, buffer(new Float32Array(values))])), count: segments.length * 6 };
  };

  const drop = (thing) => ["p", "n", "q", "corner", "paint"].forEach((name) => thing[name] && gl.deleteBuffer(thing[name]));

  const begin = (camera) => {
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(body.made);
    gl.uniformMatrix4fv(body.set.eye, false, camera.eye);
    gl.uniform3fv(body.set.from, camera.from);
    gl.uniform3fv(body.set.key, camera.key);
    gl.useProgram(line.made);
    gl.uniformMatrix4fv(line.set.eye, false, camera.eye);
    gl.uniform2f(line.set.size, canvas.width / 2, canvas.height / 2);
  };

  const show = (meshes, poses, colourOf, flat) => {
    gl.useProgram(body.made);
    gl.uniform1f(body.set.lit, flat ? 0 : 1);
    for (const part of meshes) {
      feed(body, "p", part.p, 3);
      feed(body, "n", part.n, 3);
      const pose = glPose(poses[part.joint] || STILL);
      gl.uniformMatrix4fv(body.set.place, false, flat ? glTimes(flat, pose) : pose);
      gl.uniform4fv(body.set.colour, colourOf(part));
      gl.drawArrays(gl.TRIANGLES, 0, part.count);
    }
  };

  /** Links in full, or with `alpha` below 1 as one even veil. */
  const bodies = (meshes, poses, colourOf, alpha = 1) => {
    if (alpha < 1) {
      gl.colorMask(false, false, false, false);
      show(meshes, poses, colourOf, null);
      gl.colorMask(true, true, true, true);
    }
    show(meshes, poses, (one) => [...colourOf(one).slice(0, 3), alpha], null);
  };

  /** What the links take of the light on the floor; `flat` lays them on it. */
  const shadow = (meshes, poses, colour, flat) => {
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.EQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
    gl.depthMask(false);
    show(meshes, poses, () => colour, flat);
    gl.depthMask(true);
    gl.disable(gl.STENCIL_TEST);
  };

  const stroke = (thing, width, veil = 1, through = false) => {
    if (!thing.count) return;
    gl.useProgram(line.made);
    if (through) gl.disable(gl.DEPTH_TEST);
    gl.depthMask(!through && veil === 1);
    for (const [name, size] of [["p", 3], ["q", 3], ["corner", 2], ["paint", 4]]) feed(line, name, thing[name], size);
    gl.uniform1f(line.set.width, width);
    gl.uniform1f(line.set.veil, veil);
    gl.drawArrays(gl.TRIANGLES, 0, thing.count);
    gl.depthMask(true);
    gl.enable(gl.DEPTH_TEST);
  };

  return { mesh, lines, drop, begin, bodies, shadow, stroke };
}
