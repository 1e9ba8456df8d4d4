/* Surfaces in light, drawn by three.js: the materials of their files, or clay, in the light of a room and of a lamp that the camera carries. */
import { BufferGeometry, Camera, DirectionalLight, DoubleSide, FrontSide, HemisphereLight, BufferAttribute, GLBufferAttribute, Mesh, MeshStandardMaterial, NeutralToneMapping, PMREMGenerator, Scene, Sphere, WebGLRenderer } from "three";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
import { dress } from "./materials.js";
import { IDENTITY, multiply3, upper } from "./matrix.js";
import { carve } from "./wood.js";

const ROOM = 0.45, SKY = 1.15, LAMP = 1.75, LAMP_FROM = [-0.75, 0.75, 0.45];
/* Of clay, and of the models that the page brings along, which shine: light that runs over them shows normals. */
const MATT = { roughness: 0.62, metalness: 0 }, SHINY = { roughness: 0.36, metalness: 0.1 };
/* The exposure beside what is marked. */
const DIM = 0.42;

export function makeLit(canvas, gl) {
  const renderer = new WebGLRenderer({ canvas, context: gl }), scene = new Scene(), camera = new Camera(), lamp = new DirectionalLight(0xffffff, LAMP);
  renderer.autoClear = false;
  renderer.debug.checkShaderErrors = false;      /* the question waits for the card */
  renderer.toneMapping = NeutralToneMapping;
  renderer.setPixelRatio(1);
  renderer.info.autoReset = true;
  camera.matrixAutoUpdate = camera.matrixWorldAutoUpdate = false;
  scene.matrixWorldAutoUpdate = false;
  scene.add(lamp);
  const sky = new HemisphereLight(0xffffff, 0x8a8680, SKY);
  sky.matrixWorld.setPosition(0, 1, 0);
  scene.environmentIntensity = ROOM;
  let room = null;
  /* What shines shows the room; clay needs the sky alone, which costs next to nothing. The room is made when it is first wanted. */
  const lightFor = (dressed) => {
    sky.visible = !dressed;
    if (dressed && !room) {
      const generator = new PMREMGenerator(renderer), walls = new RoomEnvironment();
      room = generator.fromScene(walls, 0.04).texture;
      walls.dispose();
      generator.dispose();
    }
    scene.environment = dressed ? room : null;
  };

  /* The arrays of a surface, which lie on the card already, with the normals of one side. */
  const geometryOf = (surface, normals) => {
    let made = surface.lit.get(normals);
    if (!made) {
      made = new BufferGeometry();
      made.boundingSphere = new Sphere(undefined, 1);
      if (surface.indexArray) made.setIndex(new BufferAttribute(surface.indexArray, 1));
      surface.lit.set(normals, made);
    }
    const attribute = (name, buffer, size, kind = gl.FLOAT, bytes = 4) => { if (buffer && !made.attributes[name]) made.setAttribute(name, new GLBufferAttribute(buffer, kind, size, bytes, surface.points, kind !== gl.FLOAT)); };
    attribute("position", surface.positions, 3);
    attribute("normal", normals, 3);
    surface.texcoords.forEach((buffer, set) => attribute(set ? `uv${set}` : "uv", buffer, 2));
    attribute("tangent", surface.tangents, 4);
    attribute("color", surface.colours, 4, gl.UNSIGNED_SHORT, 2);
    return made;
  };

  /* Of a part of a model: dressed, or of clay. */
  const wardrobe = new Map();
  const clayOf = (item, colours, map) => {
    const key = ["clay", item.clay, item.isShiny, item.isWooden, colours, item.isDoubleSided, map?.uuid].join();
    if (!wardrobe.has(key)) {
      const clay = new MeshStandardMaterial({ ...(item.isShiny ? SHINY : MATT), vertexColors: colours, side: item.isDoubleSided === false ? FrontSide : DoubleSide, normalMap: map?.normalMap ?? null });
      clay.color.setRGB(...item.clay);
      if (item.isWooden) carve(clay);
      if (map?.normalScale) clay.normalScale.copy(map.normalScale);
      wardrobe.set(key, clay);
    }
    return wardrobe.get(key);
  };
  const materialOf = (item, look) => {
    const { surface } = item, source = item.materials?.[item.material?.material] ?? null, colours = Boolean(look.materials && surface.colours);
    let dressed = null;
    if (source) {
      const key = [source.uuid, Boolean(surface.tangents), colours].join();
      if (!wardrobe.has(key)) wardrobe.set(key, dress(source, { tangents: Boolean(surface.tangents), colours }));
      dressed = wardrobe.get(key);
      if (dressed.normalScale) dressed.normalScale.copy(source.normalScale).multiplyScalar(look.normalMaps ? 1 : 0).setY((look.normalMaps ? 1 : 0) * source.normalScale.y * (surface.tangents ? 1 : -1));
      if (!dressed.toneMapped) dressed.color.copy(source.color).multiplyScalar(look.dim ? DIM : 1);      /* no exposure reaches it */
    }
    if (dressed && look.materials) return dressed;
    return clayOf(item, colours, dressed?.normalMap && look.normalMaps ? dressed : null);
  };

  /* Begins the programs of clay, which stay, while a file is read; whoever draws first would wait for them. */
  const bare = [DoubleSide, FrontSide].map((side) => new Mesh(new BufferGeometry(), new MeshStandardMaterial({ ...MATT, side })));
  const warmUp = () => {
    scene.children.length = 0;
    scene.children.push(lamp, sky, ...bare);
    renderer.resetState();
    lightFor(false);
    renderer.compile(scene, camera);
  };

  const meshes = [];
  const meshAt = (i) => {
    if (meshes[i]) return meshes[i];
    const mesh = new Mesh();
    mesh.matrixAutoUpdate = mesh.matrixWorldAutoUpdate = mesh.frustumCulled = false;
    /* Right or wrong, as the side says, and not what three.js makes of M. */
    mesh.normalMatrix.getNormalMatrix = () => mesh.normalMatrix.fromArray(mesh.userData.normalMatrix);
    return (meshes[i] = mesh);
  };

  const place = (items, view, look) => {
    camera.matrixWorldInverse.fromArray(view.worldToView);
    camera.matrixWorld.copy(camera.matrixWorldInverse).invert();
    camera.projectionMatrix.fromArray(view.viewToClip);
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
    lamp.matrixWorld.setPosition(...LAMP_FROM.map((_, i) => LAMP_FROM.reduce((sum, part, axis) => sum + part * camera.matrixWorld.elements[4 * axis + i], 0)));
    scene.children.length = 0;
    scene.children.push(lamp, sky);
    items.forEach((item, i) => {
      const mesh = meshAt(i);
      mesh.geometry = geometryOf(item.surface, item.normals);
      mesh.material = materialOf(item, look);
      mesh.matrixWorld.fromArray(item.localToWorld);
      mesh.userData.normalMatrix = multiply3(upper(view.worldToView), item.normalMatrix);
      mesh.parent = scene;
      scene.children.push(mesh);
    });
    if (look.posed) { scene.children.push(look.posed); look.posed.parent = scene; }
  };

  /* Into a part of the picture, in pixels from below. What else draws with the context finds it as it was new. */
  const draw = (items, view, look, box, cut) => {
    place(items, view, look);
    renderer.resetState();
    lightFor(Boolean(look.posed || (look.materials && items.some(({ materials }) => materials))));
    renderer.toneMappingExposure = look.dim ? DIM : 1;
    renderer.setViewport(box.x, box.y, box.width, box.height);
    renderer.setScissor(cut.x, box.y, cut.width, box.height);
    renderer.setScissorTest(true);
    renderer.render(scene, camera);
    renderer.resetState();
    gl.bindVertexArray(null);
    gl.enable(gl.DEPTH_TEST);
    gl.viewport(box.x, box.y, box.width, box.height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(cut.x, box.y, cut.width, box.height);
  };
  /* What a picture is going to need: the room, images, programs; one after another, as a picture that made them would hold the page. quiet(): a promise, kept when the card has nothing else to do. */
  const prepare = async (items, look, quiet) => {
    const begin = () => { renderer.resetState(); lightFor(true); place(items, { worldToView: IDENTITY, viewToClip: IDENTITY }, look); }, textures = new Set();
    await quiet();
    begin();
    scene.traverse(({ material }) => { for (const part of Object.values(material ?? {})) if (part?.isTexture) textures.add(part); });
    for (const texture of textures) {
      await quiet();
      renderer.initTexture(texture);
      renderer.resetState();
    }
    await quiet();
    begin();
    if (gl.getExtension("KHR_parallel_shader_compile")) await renderer.compileAsync(scene, camera);
    else renderer.compile(scene, camera);
    await quiet();
  };
  const forget = () => { for (const material of wardrobe.values()) material.dispose(); wardrobe.clear(); };

  return { draw, prepare, warmUp, forget, resize: () => renderer.setSize(canvas.width, canvas.height, false) };
}
