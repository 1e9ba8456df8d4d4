/* Carved wood for the sculpture, which has no texture coordinates: its colour is a function of the place, so that the grain runs through it as through a block. Year's rings about a heart beside it, bent by noise, and fibres along them; no normal is touched. */

const PLACE = "out vec3 in_block;\nvoid main() {\n  in_block = position;";

/* hash: Teschner et al. 2003, Optimized spatial hashing, eq. 1, stirred; noise: values at lattice points, interpolated with Perlin's cubic. */
const GRAIN = `in vec3 in_block;
float hash(ivec3 p) {
  uint h = (uint(p.x) * 73856093u) ^ (uint(p.y) * 19349663u) ^ (uint(p.z) * 83492791u);
  h = (h ^ (h >> 13)) * 0x5bd1e995u;
  return float((h ^ (h >> 15)) & 0xffffu) / 65535.0;
}
float noise(vec3 p) {
  ivec3 c = ivec3(floor(p));
  vec3 f = fract(p), w = f * f * (3.0 - 2.0 * f);
  vec4 low = vec4(hash(c), hash(c + ivec3(1, 0, 0)), hash(c + ivec3(0, 1, 0)), hash(c + ivec3(1, 1, 0)));
  vec4 high = vec4(hash(c + ivec3(0, 0, 1)), hash(c + ivec3(1, 0, 1)), hash(c + ivec3(0, 1, 1)), hash(c + ivec3(1, 1, 1)));
  vec4 layer = mix(low, high, w.z);
  return mix(mix(layer.x, layer.y, w.x), mix(layer.z, layer.w, w.x), w.y);
}
/* How dark the wood is, 0 to 1: late wood is, at the end of each year. What is finer than a pixel is left out. */
float grain(vec3 p) {
  vec2 bent = p.yz - vec2(-0.75, 0.5) + 0.3 * (vec2(noise(vec3(1.1, 1.6, 1.6) * p), noise(vec3(1.1, 1.6, 1.6) * p + 19.0)) - 0.5);
  float years = 19.0 * length(bent) + 0.8 * noise(9.0 * vec3(bent, 0.3)), part = fract(years), width = fwidth(years);
  float ring = mix(smoothstep(0.3, 0.8, part) * (1.0 - smoothstep(0.82, 1.0, part)), 0.3, smoothstep(0.25, 0.8, width));
  vec3 fibres = vec3(4.0, 75.0, 75.0) * p;
  float fibre = mix(noise(fibres), 0.5, smoothstep(0.4, 1.2, length(fwidth(fibres))));
  return clamp((0.3 + 0.3 * noise(vec3(1.5, 3.0, 3.0) * p + 5.0)) * ring + 0.38 * fibre, 0.0, 1.0);
}
void main() {`;

const EARLY = [0.78, 0.5, 0.27], LATE = [0.3, 0.13, 0.05];
const vec3 = (colour) => `vec3(${colour.map((x) => x.toFixed(3)).join()})`;

export function carve(material) {
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace("void main() {", PLACE);
    shader.fragmentShader = shader.fragmentShader.replace("void main() {", GRAIN)
      .replace("#include <color_fragment>", `float late_wood = grain(in_block);\n  diffuseColor.rgb = mix(${vec3(EARLY)}, ${vec3(LATE)}, late_wood);`)
      .replace("#include <roughnessmap_fragment>", "float roughnessFactor = roughness + 0.16 * late_wood;");
  };
  material.customProgramCacheKey = () => "wood";
  return material;
}
