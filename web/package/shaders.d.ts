/** norma.glsl: normals and tangents in shaders, for GLSL ES 3.00, GLSL 3.30 and GLSL for Vulkan. Paste it after `#version`. */
export const glsl: string;
/** The same functions in HLSL. */
export const hlsl: string;
/** The same functions in WGSL. */
export const wgsl: string;
