/* WebGL 2: what three.js draws (lit.js) and, over it, lines, marks, and values as colours. Programs are made of the texts of norma.glsl and src/render/shaders, the same as natively, and of web/page/shaders; light is computed in view space, so that it stays with the camera. */
import { makeLit } from "./lit.js";
import { meetsPicture, multiply, multiply3, upper } from "./matrix.js";

const SURFACES = { gouraud: "SHADING_GOURAUD", phong: "SHADING_PHONG", normals: "SHOW_NORMALS", winding: "SHOW_WINDING", error: "SHOW_ERROR", deviation: "SHOW_ERROR", distance: "SHOW_ERROR", matcap: "SHOW_MATCAP", zebra: "SHOW_ZEBRA", tangents: "SHOW_TANGENTS" };
const POSITION = 0, NORMAL = 1, COLOUR = 2, VALUE = 3, TANGENT = 5;
const LIGHTS = [{ from: [-0.66, 0.62, 0.42], strength: 1.05 }, { from: [0.9, 0, 0.3], strength: 0.1 }];
/* WebGL's longest stride, in floats. */
const MOST_STRIDE = 63;
/* More edges than these are drawn a pixel wide. */
const MOST_WIDE = 50000;
/* Bytes that are handed over at once; of a model that is opened, and waited for. */
const SLICE = 1 << 19, LARGE_SLICE = 1 << 20;
/* More places than these that are marked are drawn with all that lies between. */
const MOST_RUNS = 200;
/* Pixels of a shadow each way. */
const SHADOW = 256;
/* Phong's model: ambient, diffuse, specular, exponent. */
const PHONG = [0.06, 0.94, 0.16, 26];
/* Of the lesson's patches; their lights; half of what a picture of one spans, in metres. */
const MATT = [0.03, 0.97, 0, 1], BRIGHT = 0.6, HALF = 0.45;
/* Where a surface with one side is not drawn from behind; errors, winding and findings are looked for on either. */
const HAS_SIDES = new Set(["lit", "normals", "matcap", "zebra", "tangents"]);
/* In narrower pictures arrows are thinner. */
const WIDE = 480;

/* Begins a program; nothing is asked of the card until it is used first, as every question would wait for all that was drawn before. */
function begin(gl, texts, stage, defines) {
  const head = ["#version 300 es", "precision highp float; precision highp int;", ...defines.map((name) => `#define ${name}`), texts["norma.glsl"], texts["colour.glsl"], texts["light.glsl"]].join("\n");
  const program = gl.createProgram(), shaders = [[gl.VERTEX_SHADER, "vert"], [gl.FRAGMENT_SHADER, "frag"]].map(([kind, ending]) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, `${head}\n${texts[`${stage}.${ending}`]}`);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    return shader;
  });
  gl.linkProgram(program);
  return { program, shaders, place: null };
}

function finish(gl, made) {
  if (!gl.getProgramParameter(made.program, gl.LINK_STATUS) && !gl.isContextLost())
    throw new Error(`Shaders do not compile: ${made.shaders.map((shader) => gl.getShaderInfoLog(shader)).join(" ")} ${gl.getProgramInfoLog(made.program)}`);
  const uniforms = new Map([["local_to_world", gl.getUniformLocation(made.program, "local_to_world")]]);
  made.place = (name) => {
    if (!uniforms.has(name)) uniforms.set(name, gl.getUniformLocation(made.program, name));
    return uniforms.get(name);
  };
}

export function makeGraphics(canvas, texts) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
  if (!gl) return null;
  const programs = new Map();
  const prepare = (stage, ...defines) => {
    const key = [stage, ...defines].join(" ");
    if (!programs.has(key)) programs.set(key, begin(gl, texts, stage, defines));
    return programs.get(key);
  };
  const programOf = (stage, ...defines) => {
    const made = prepare(stage, ...defines);
    if (!made.place) finish(gl, made);
    gl.useProgram(made.program);
    return made.place;
  };
  for (const define of Object.values(SURFACES)) prepare("surface", "LIGHT_IN_VIEW", define);
  for (const [stage, ...defines] of [["angle"], ["marked", "MARKED_ONLY"], ["marked", "COUNT"], ["marked", "COUNT", "MARKED_ONLY"], ["line"], ["line", "HEDGEHOG"], ["line", "THIN"], ["outline"], ["patch"], ["shadow", "CAST"], ["shadow", "BLUR"], ["shadow"]]) prepare(stage, ...defines);

  const lit = makeLit(canvas, gl);

  /* ---- buffers */
  const makeBuffer = (data, usage = gl.STATIC_DRAW, target = gl.ARRAY_BUFFER) => {
    const buffer = gl.createBuffer();
    gl.bindVertexArray(null);
    gl.bindBuffer(target, buffer);
    gl.bufferData(target, data, usage);
    return buffer;
  };
  const fillBuffer = (buffer, data) => {
    gl.bindVertexArray(null);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, data);
  };
  const passed = (sync) => new Promise((done, fail) => {
    const look = () => {
      const state = gl.clientWaitSync(sync, 0, 0);
      if (state === gl.WAIT_FAILED || gl.isContextLost()) fail(new Error("The graphics card lost the picture."));
      else if (state === gl.TIMEOUT_EXPIRED) setTimeout(look, 4);
      else { gl.deleteSync(sync); done(); }
    };
    look();
  });
  /* The same bit by bit, one after the other: the page goes on meanwhile. isWanted(): whether there still is such a buffer. */
  let behind = 0;
  const fillSlowly = async (buffer, data, slice = SLICE, isWanted = () => true) => {
    const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
    for (let at = 0; at < bytes.length && isWanted(); at += slice) {
      gl.bindVertexArray(null);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferSubData(gl.ARRAY_BUFFER, at, bytes, at, Math.min(slice, bytes.length - at));
      behind += Math.min(slice, bytes.length - at);
      if (behind < slice) continue;
      behind = 0;
      await drained();
    }
  };
  const reserve = (size) => {
    const buffer = gl.createBuffer();
    gl.bindVertexArray(null);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, size, gl.DYNAMIC_DRAW);
    return buffer;
  };
  /* Into a surface's buffer of that name, four bytes a corner; and where those lie that are marked, if that is in few places: of a large surface a few triangles are drawn then. */
  const runsOf = new WeakMap();
  const fillMarks = async (surface, name, list) => {
    const colours = new Uint32Array(list.buffer, list.byteOffset, list.length / 4), runs = [];
    for (let i = 0; i < colours.length && runs.length <= MOST_RUNS; i += 3) {
      if (!(colours[i] | colours[i + 1] | colours[i + 2])) continue;
      const last = runs.at(-1);
      if (last && last[0] + last[1] === i) last[1] += 3;
      else runs.push([i, 3]);
    }
    const buffer = (surface[name] ??= reserve(list.byteLength));
    await fillSlowly(buffer, list);
    runsOf.set(buffer, runs.length > MOST_RUNS ? null : runs);
  };
  /* When all is done that the card was told so far. */
  const drained = () => {
    const sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    return passed(sync);
  };
  const attribute = (index, buffer, size, stride = 0, offset = 0, divisor = 0, kind = gl.FLOAT) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(index);
    gl.vertexAttribPointer(index, size, kind, kind !== gl.FLOAT, stride, offset);
    gl.vertexAttribDivisor(index, divisor);
  };

  /* A surface on the card: { positions, normals, indices? } as arrays, count of what is drawn. That of a model has no indices, and is empty until it is filled. */
  const makeSurface = ({ positions, normals, indices }) => {
    const buffer = (list) => (indices ? makeBuffer(list, gl.DYNAMIC_DRAW) : reserve(list.byteLength));
    const surface = {
      positions: buffer(positions), normals: buffer(normals), isFree: false,
      values: null, marks: null, trial: null, tint: null, colours: null, texcoords: [null, null], tangents: null, lit: new Map(), indexArray: indices, indices: indices && makeBuffer(indices, gl.STATIC_DRAW, gl.ELEMENT_ARRAY_BUFFER), count: indices ? indices.length : positions.length / 3, points: positions.length / 3,
    };
    const arrays = new Map();
    surface.use = (normalsBuffer) => {
      if (!arrays.has(normalsBuffer)) {
        const array = gl.createVertexArray();
        arrays.set(normalsBuffer, array);
        gl.bindVertexArray(array);
        attribute(POSITION, surface.positions, 3);
        attribute(NORMAL, normalsBuffer, 3);
        if (surface.indices) gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, surface.indices);
      }
      gl.bindVertexArray(arrays.get(normalsBuffer));
      if (surface.values) attribute(VALUE, surface.values, 1);
      if (surface.tangents) attribute(TANGENT, surface.tangents, 4);
    };
    /* Colours of the corners, or none; of the array that is in use. */
    surface.colour = (buffer) => {
      if (buffer) { attribute(COLOUR, buffer, 4, 0, 0, 0, gl.UNSIGNED_BYTE); return; }
      gl.disableVertexAttribArray(COLOUR);
      gl.vertexAttrib4f(COLOUR, 1, 1, 1, buffer === null ? 1 : 0);
    };
    surface.fill = async () => {
      surface.fill = null;      /* which holds the arrays */
      for (const [to, list] of [[surface.positions, positions], [surface.normals, normals]]) await fillSlowly(to, list, LARGE_SLICE, () => !surface.isFree);
    };
    surface.free = () => {
      surface.isFree = true;
      for (const name of ["positions", "normals", "values", "marks", "trial", "tint", "colours", "tangents", "indices"]) if (surface[name]) gl.deleteBuffer(surface[name]);
      for (const buffer of surface.texcoords) if (buffer) gl.deleteBuffer(buffer);
      surface.lit.forEach((geometry) => geometry.dispose());
      arrays.forEach((array) => gl.deleteVertexArray(array));
    };
    return surface;
  };

  const lines = gl.createVertexArray(), nothing = gl.createVertexArray();
  /* Where it is drawn: null is the canvas. */
  let into = null;
  /* The part of the picture that is drawn into, in pixels from below. */
  let box = { x: 0, y: 0, width: canvas.width, height: canvas.height }, seen = box;

  /* ---- drawing */
  const setCamera = (place, camera) => {
    gl.uniformMatrix4fv(place("world_to_view"), false, camera.worldToView);
    gl.uniformMatrix4fv(place("view_to_clip"), false, camera.viewToClip);
  };

  const setLight = (place) => {
    gl.uniform4f(place("eye"), 0, 0, 0, 1);
    gl.uniform1i(place("light_count"), LIGHTS.length);
    gl.uniform3fv(place("light_direction"), LIGHTS.flatMap(({ from }) => from.map((x) => x / Math.hypot(...from))));
    gl.uniform3fv(place("light_colour"), LIGHTS.flatMap(({ strength }) => [strength, strength, strength]));
  };

  /* runs: which corners, [first, count], where it is not all of them. */
  const drawTriangles = (item, colours, runs = null) => {
    gl.frontFace(item.mirrored ? gl.CW : gl.CCW);
    item.surface.use(item.normals);
    item.surface.colour(colours);
    if (runs) for (const run of runs) gl.drawArrays(gl.TRIANGLES, ...run);
    else if (item.surface.indices) gl.drawElements(gl.TRIANGLES, item.surface.count, gl.UNSIGNED_INT, 0);
    else gl.drawArrays(gl.TRIANGLES, 0, item.surface.count);
  };

  /* item: { surface, normals (a buffer), localToWorld, normalMatrix, plain, right (to world space), mirrored, clay, material }; look: { colours, shading, materials, errorTop, angleTop, through, dim } */
  const drawSurface = (item, camera, look) => {
    if (look.colours === "angle") { drawAngle(item, camera, look); return; }
    const place = programOf("surface", "LIGHT_IN_VIEW", SURFACES[look.colours === "lit" ? look.shading : look.colours]);
    setCamera(place, camera);
    setLight(place);
    gl.uniformMatrix4fv(place("local_to_world"), false, item.localToWorld);
    gl.uniformMatrix3fv(place("normal_matrix"), false, multiply3(upper(camera.worldToView), item.normalMatrix));
    const isSided = item.isDoubleSided === false && HAS_SIDES.has(look.colours);
    gl.uniform3fv(place("base_colour"), item.clay);
    gl.uniform4f(place("phong"), ...PHONG);
    gl.uniform4f(place("maps"), 0, 0, 0, 0);
    gl.uniform1f(place("two_sided"), isSided ? 0 : 1);
    gl.uniform1f(place("scale_top"), look.errorTop);
    if (isSided) gl.enable(gl.CULL_FACE);
    drawTriangles(item, null);
    gl.disable(gl.CULL_FACE);
  };

  /* Those that may be in the picture: what a close view leaves out costs nothing. The surface that moves fills no ball. */
  const inPicture = (items, { viewToClip, worldToView }) => {
    const toClip = multiply(viewToClip, worldToView);
    return items.filter(({ surface, localToWorld }) => surface.indices || meetsPicture(multiply(toClip, localToWorld)));
  };

  /* All of them: in light by three.js, values as colours here. */
  const drawSurfaces = (all, camera, look) => {
    const items = inPicture(all, camera);
    if (look.posed || look.colours === "findings" || (look.colours === "lit" && look.shading !== "gouraud")) lit.draw(items, camera, look, box, seen);
    else for (const item of items) drawSurface(item, camera, look);
    if (look.colours === "findings" && !look.unpainted) drawMarks(items, camera, look.through);
    if (look.tinted && look.colours === "lit") drawMarks(items, camera, false, "tint");
    if (look.outline) drawOutline(items.filter(look.outline), camera, look.outlineColour, look.outlineWidth);
  };

  /* What is marked, over the model; through: also where the rest stands in front of it. marks: which of a surface's buffers says so. */
  const drawMarks = (items, camera, through, marks = "marks") => {
    if (through) gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(-1, -8);
    for (const item of items) if (item.surface[marks]) drawMarked(item, camera, item.surface[marks], "MARKED_ONLY");
    gl.disable(gl.POLYGON_OFFSET_FILL);
  };

  /* A line round these, also where something stands in front of them. */
  const drawOutline = (items, camera, colour, width) => {
    const mask = targetOf("mask", box.width, box.height, false);
    gl.bindFramebuffer(gl.FRAMEBUFFER, mask.frame);
    gl.disable(gl.SCISSOR_TEST);
    gl.viewport(0, 0, box.width, box.height);
    gl.clear(gl.COLOR_BUFFER_BIT);
    for (const item of items) drawMarked(item, camera, null, "COUNT");
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    gl.viewport(box.x, box.y, box.width, box.height);
    gl.enable(gl.SCISSOR_TEST);
    gl.disable(gl.DEPTH_TEST);
    const place = programOf("outline");
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, mask.texture);
    gl.uniform1i(place("mask"), 0);
    gl.uniform2f(place("corner"), box.x, box.y);
    gl.uniform1f(place("width"), width);
    gl.uniform4f(place("colour"), ...colour);
    gl.bindVertexArray(nothing);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindTexture(gl.TEXTURE_2D, null);
    gl.enable(gl.DEPTH_TEST);
  };

  const drawAngle = (item, camera, look) => {
    const place = programOf("angle");
    setCamera(place, camera);
    gl.uniformMatrix4fv(place("local_to_world"), false, item.localToWorld);
    gl.uniformMatrix3fv(place("plain_matrix"), false, item.plain);
    gl.uniformMatrix3fv(place("normal_matrix"), false, item.right);
    gl.uniform1f(place("scale_top"), look.angleTop);
    drawTriangles(item, null);
  };

  /* marks: a buffer; null: all of it; undefined: nothing of it. */
  const drawMarked = (item, camera, marks, ...defines) => {
    const place = programOf("marked", ...defines);
    setCamera(place, camera);
    gl.uniformMatrix4fv(place("local_to_world"), false, item.localToWorld);
    drawTriangles(item, marks, defines.includes("MARKED_ONLY") ? runsOf.get(marks) : null);
  };

  const startLines = (place, camera, width, head, lift = 0.002, rim = 0) => {
    setCamera(place, camera);
    gl.uniform2f(place("viewport"), box.width, box.height);
    gl.uniform1f(place("width"), width);
    gl.uniform1f(place("head"), head);
    gl.uniform1f(place("rim"), rim);
    gl.uniform1f(place("lift"), lift);
    gl.bindVertexArray(lines);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  };

  /* One line from each point along its normal; where there are more than most, evenly chosen ones. */
  const drawHedgehog = (item, camera, { from, to, points, colour, scale, pixels, most }) => {
    const place = programOf("line", "HEDGEHOG");
    startLines(place, camera, 1.3 * pixels, 0);
    gl.uniformMatrix4fv(place("local_to_world"), false, item.localToWorld);
    gl.uniformMatrix3fv(place("normal_matrix"), false, item.normalMatrix);
    gl.uniform1f(place("reach_scale"), scale);
    const step = Math.min(Math.floor(MOST_STRIDE / 3), Math.max(1, Math.ceil(points / most)));
    attribute(0, from, 3, 12 * step, 0, 1);
    attribute(1, to, 3, 12 * step, 0, 1);
    gl.disableVertexAttribArray(2);
    gl.vertexAttrib4f(2, ...colour);
    gl.disableVertexAttribArray(3);
    gl.vertexAttrib1f(3, 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, Math.ceil(points / step));
    gl.disable(gl.BLEND);
  };

  /* Edges: both ends of each (a buffer), count. Many are lines of the card: software draws a million strips of four vertices in 20 s, and lines in 2. */
  const drawWire = (item, camera, { ends, count }, pixels, colour) => {
    const isThin = count > MOST_WIDE, place = isThin ? programOf("line", "THIN") : programOf("line");
    startLines(place, camera, pixels, 0, 0.0015);
    gl.uniformMatrix4fv(place("local_to_world"), false, item.localToWorld);
    attribute(0, ends, 3, isThin ? 12 : 24, 0, isThin ? 0 : 1);
    if (isThin) gl.disableVertexAttribArray(1);
    else attribute(1, ends, 3, 24, 12, 1);
    gl.disableVertexAttribArray(2);
    gl.vertexAttrib4f(2, ...colour);
    gl.disableVertexAttribArray(3);
    if (isThin) gl.drawArrays(gl.LINES, 0, 2 * count);
    else gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    gl.disable(gl.BLEND);
  };

  const strokes = gl.createBuffer();
  /* In world space, ten numbers each: both ends, colour. */
  const drawStrokes = (place, numbers) => {
    gl.uniformMatrix4fv(place("local_to_world"), false, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    gl.bindBuffer(gl.ARRAY_BUFFER, strokes);
    gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(numbers), gl.DYNAMIC_DRAW);
    [[3, 0], [3, 12], [4, 24]].forEach(([size, offset], i) => attribute(i, strokes, size, 40, offset, 1));
    gl.disableVertexAttribArray(3);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, numbers.length / 10);
    gl.disable(gl.BLEND);
  };
  /* Arrows: [{ from, to, colour }]; rim: pixels that they are wider by. */
  const drawArrows = (arrows, camera, pixels, rim = 0) => {
    const place = programOf("line"), size = pixels * Math.max(0.5, Math.min(1, box.width / pixels / WIDE));
    startLines(place, camera, 3 * size, 13 * size, 0.01, rim * size);
    drawStrokes(place, arrows.flatMap(({ from, to, colour }) => [...from, ...to, ...colour]));
  };
  /* One over everything, with an edge: on any model one of the two colours is seen. */
  const drawPointer = (arrow, edge, camera, pixels) => {
    gl.disable(gl.DEPTH_TEST);
    drawArrows([{ ...arrow, colour: edge }], camera, pixels, 2);
    drawArrows([arrow], camera, pixels);
    gl.enable(gl.DEPTH_TEST);
  };
  /* Discs over everything: [x, y, z, ...], of so many pixels. */
  const drawPins = (points, camera, colour, size) => {
    const place = programOf("line"), ends = Array.from({ length: points.length / 3 }, (_, i) => points.slice(3 * i, 3 * i + 3));
    gl.disable(gl.DEPTH_TEST);
    startLines(place, camera, size, 0, 0.01);
    drawStrokes(place, ends.flatMap((end) => [...end, ...end, ...colour]));
    gl.enable(gl.DEPTH_TEST);
  };

  /* ---- pictures that are not shown */
  const targets = new Map();
  const targetOf = (name, width, height, isDeep = true) => {
    const known = targets.get(name);
    if (known?.width === width && known.height === height) return known;
    if (known) { gl.deleteFramebuffer(known.frame); gl.deleteTexture(known.texture); if (known.depth) gl.deleteRenderbuffer(known.depth); }
    const made = { width, height, frame: gl.createFramebuffer(), texture: gl.createTexture(), depth: isDeep ? gl.createRenderbuffer() : null };
    gl.bindFramebuffer(gl.FRAMEBUFFER, made.frame);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, made.texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, width, height);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, made.texture, 0);
    if (isDeep) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, made.depth);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, made.depth);
    }
    gl.bindTexture(gl.TEXTURE_2D, null);      /* surfaces look at this unit as well */
    targets.set(name, made);
    return made;
  };
  /* What draw() leaves, four bytes a pixel, from below. Nothing waits for the card meanwhile. */
  const pictureOf = async (name, width, height, colour, draw) => {
    into = targetOf(name, width, height).frame;
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    gl.viewport(0, 0, width, height);
    gl.disable(gl.SCISSOR_TEST);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(...colour);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.clearColor(0, 0, 0, 0);
    draw();
    const pixels = gl.createBuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, pixels);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, 4 * width * height, gl.STREAM_READ);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, (into = null));
    await drained();
    const read = new Uint8ClampedArray(4 * width * height);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, pixels);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, read);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.deleteBuffer(pixels);
    return read;
  };

  /* The shadow of these on the ground, seen by a camera from below; soft by so much of half of the ground, each way. */
  const castShadow = (items, camera, soft) => {
    const one = targetOf("shadow", SHADOW, SHADOW), other = targetOf("blur", SHADOW, SHADOW, false);
    gl.disable(gl.SCISSOR_TEST);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.clearColor(0, 0, 0, 0);
    gl.enable(gl.DEPTH_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, one.frame);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    for (const item of items) {
      const place = programOf("shadow", "CAST");
      setCamera(place, camera);
      gl.uniformMatrix4fv(place("local_to_world"), false, item.localToWorld);
      drawTriangles(item, null);
    }
    gl.disable(gl.DEPTH_TEST);
    const place = programOf("shadow", "BLUR");
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform1i(place("shadow"), 0);
    gl.bindVertexArray(nothing);
    for (const part of [0.12, 0.05]) for (const [from, to, along] of [[one, other, [1, 0]], [other, one, [0, 1]]]) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, to.frame);
      gl.bindTexture(gl.TEXTURE_2D, from.texture);
      for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
      for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
      gl.uniform2f(place("reach"), along[0] * part * soft[0], along[1] * part * soft[1]);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
    gl.bindTexture(gl.TEXTURE_2D, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    gl.enable(gl.DEPTH_TEST);
  };
  /* On a rectangle of the ground, behind what has been drawn. */
  const drawShadow = (localToWorld, camera, dark) => {
    const place = programOf("shadow");
    setCamera(place, camera);
    gl.uniformMatrix4fv(place("local_to_world"), false, localToWorld);
    gl.uniform2f(place("reach"), dark, 0);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, targetOf("shadow", SHADOW, SHADOW).texture);
    gl.uniform1i(place("shadow"), 0);
    gl.bindVertexArray(nothing);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.bindTexture(gl.TEXTURE_2D, null);
  };

  const TILE = 192, ACROSS = 4;
  /* Of a picture from each camera, which part shows what is marked; through: as if the rest were not there. */
  const countMarked = async (items, cameras, aspect, through, marks = "marks") => {
    const height = Math.max(16, Math.round(TILE / aspect)), width = TILE * Math.min(ACROSS, cameras.length), all = height * Math.ceil(cameras.length / ACROSS), counts = cameras.map(() => 0);
    const read = await pictureOf("count", width, all, [0, 0, 0, 0], () => cameras.forEach((camera, i) => {
      gl.viewport(TILE * (i % ACROSS), height * Math.floor(i / ACROSS), TILE, height);
      for (const item of inPicture(items, camera)) if (item.surface[marks] || !through) drawMarked(item, camera, item.surface[marks] ?? undefined, "COUNT", ...(through ? ["MARKED_ONLY"] : []));
    }));
    for (let y = 0; y < all; y++)
      for (let x = 0; x < width; x++) if (read[4 * (y * width + x)] > 127) counts[ACROSS * Math.floor(y / height) + Math.floor(x / TILE)]++;
    return counts.map((count) => count / (TILE * height));
  };
  /* A small picture in clay, of what a surface's trial marks. */
  const drawSmall = (items, camera, width, height, colour, look, more) => pictureOf("small", width, height, colour, () => within({ x: 0, y: 0, width, height }, () => {
    for (const item of inPicture(items, camera)) drawSurface(item, camera, { colours: "lit", shading: "phong", errorTop: 1 });
    drawMarks(items, camera, look.through, "trial");
    if (look.outline) drawOutline(items.filter(look.outline), camera, look.outlineColour, look.outlineWidth);
    more();
  }));

  /* Patches of the lesson beside each other, each so many pixels wide, in the light of the acid scenes turned about the eye's axis. */
  const drawPatches = (patches, size, turn) => pictureOf(`patches ${patches.length}`, size * patches.length, size, [0, 0, 0, 0], () => patches.forEach(({ surface, keepsLength }, i) => {
    const place = programOf("patch");
    gl.viewport(size * i, 0, size, size);
    gl.uniform4f(place("eye"), 0, 0, 1, 0);
    gl.uniform1i(place("light_count"), 3);
    gl.uniform3fv(place("light_direction"), [0, 1, 2].flatMap((k) => [0.5 * Math.cos(turn + (2 * Math.PI * k) / 3), 0.5 * Math.sin(turn + (2 * Math.PI * k) / 3), Math.sqrt(0.75)]));
    gl.uniform3fv(place("light_colour"), [BRIGHT, 0, 0, 0, BRIGHT, 0, 0, 0, BRIGHT]);
    gl.uniform4f(place("phong"), ...MATT);
    gl.uniform1f(place("half_side"), HALF);
    gl.uniform1f(place("keeps_length"), keepsLength ? 1 : 0);
    drawTriangles({ surface, normals: surface.normals, mirrored: false }, null);
  }));

  /* Asks after all programs. quiet(): a promise, kept when the card has nothing else to do: the answer comes behind all that. */
  const ready = gl.getExtension("KHR_parallel_shader_compile"), isReady = ({ place, program }) => Boolean(place) || !ready || gl.getProgramParameter(program, ready.COMPLETION_STATUS_KHR);
  const warmUp = async (quiet) => {
    for (const made of programs.values()) {
      do await quiet(); while (!isReady(made));
      if (!made.place) finish(gl, made);
    }
  };

  const clear = () => {
    lit.resize();
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.disable(gl.SCISSOR_TEST);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  };
  /* A box for a small picture in the large one. */
  const paint = (colour) => {
    gl.clearColor(...colour, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.clearColor(0, 0, 0, 0);
  };
  /* Draws into a part of the picture: a box in pixels from below; cut: the columns of it that are drawn. */
  const within = (part, draw, cut = { x: part.x, width: part.width }) => {
    if (part.width <= 0 || part.height <= 0 || cut.width <= 0) return;
    box = part;
    seen = cut;
    gl.viewport(part.x, part.y, part.width, part.height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(cut.x, part.y, cut.width, part.height);
    draw();
    gl.disable(gl.SCISSOR_TEST);
  };

  return { gl, makeBuffer, fillBuffer, fillSlowly, fillMarks, reserve, drained, warmUp, makeSurface, lit, drawSurfaces, drawWire, drawHedgehog, drawArrows, drawPointer, drawPins, castShadow, drawShadow, countMarked, drawSmall, drawPatches, clear, paint, within };
}
