// line.vert: a line of a given width in pixels: the edges of a wireframe, or hedgehog lines along normals. How the files make a program: colour.glsl.
//
// Each line is one instance of a strip of four vertices, gl_VertexID 0 to 3 (drawArraysInstanced(TRIANGLE_STRIP, 0, 4, lines), attribute divisors 1).
// #define HEDGEHOG    from a point along a normal, through the same normal matrix as the surface; otherwise from one point to another
// #define THIN        a pixel wide, of drawArrays(LINES, 0, 2 * lines): from is each end in turn, and to, width and head are not looked at
// Attributes (bind by location)
//   0  vec3  from       local
//   1  vec3  to         local; HEDGEHOG: the normal, of any length
//   2  vec4  colour     linear, with alpha; a constant if the mesh has no colours
//   3  float reach      HEDGEHOG: length in the local unit
// Uniforms
//   mat4 local_to_world, world_to_view, view_to_clip
//   mat3 normal_matrix  HEDGEHOG: from local to world space
//   float reach_scale   HEDGEHOG: world units for one local unit of reach
//   vec2 viewport       pixels
//   float width, head   pixels; head: length of an arrow's head, 0 for none
//   float rim           pixels by which all of it grows, for an edge beneath it; 0 for none
//   float lift          towards the eye, as a part of the distance, so that a line lies on its surface and not in it (0.001)
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in vec4 colour;
layout(location = 3) in float reach;
uniform mat4 local_to_world, world_to_view, view_to_clip;
uniform mat3 normal_matrix;
uniform vec2 viewport;
uniform float width, head, rim, lift, reach_scale;
out vec4 line_colour;
// Pixels along the line, pixels across it, both from its start; its length; clip space's w. Linear on the screen: all but the last times w, divided by it again later.
out vec4 line_place;

const float nearest = 1e-4; // of clip space's w: what lies behind the eye is cut off there

vec4 to_clip(vec3 world) {
    vec4 view = world_to_view * vec4(world, 1.0);
    view.xyz *= 1.0 - lift * view_to_clip[2][3] * view_to_clip[2][3]; // a perspective's eye is the origin
    vec4 clip = view_to_clip * view;
    clip.z -= lift * (1.0 - view_to_clip[2][3] * view_to_clip[2][3]); // an orthographic eye is far away
    return clip;
}

void main() {
    vec3 start = (local_to_world * vec4(from, 1.0)).xyz;
    line_colour = colour;
#if defined(THIN)
    gl_Position = to_clip(start);
    line_place = vec4(0.0, 0.0, 0.0, 1.0);
#else
#if defined(HEDGEHOG)
    vec3 end = start + reach * reach_scale * norma_transform_normal(normal_matrix, to);
#else
    vec3 end = (local_to_world * vec4(to, 1.0)).xyz;
#endif
    vec4 a = to_clip(start), b = to_clip(end);
    if (a.w < nearest && b.w > nearest)
        a = mix(a, b, (nearest - a.w) / (b.w - a.w));
    if (b.w < nearest && a.w > nearest)
        b = mix(b, a, (nearest - b.w) / (a.w - b.w));
    vec2 pixel_a = a.xy / a.w * 0.5 * viewport, pixel_b = b.xy / b.w * 0.5 * viewport, along = pixel_b - pixel_a;
    float pixels = length(along), half_width = 0.5 * max(width, head) + rim + 1.0;
    along = pixels > 1e-3 ? along / pixels : vec2(1.0, 0.0);
    bool at_end = gl_VertexID >= 2;
    float side = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
    vec2 corner = (at_end ? along : -along) * half_width + side * half_width * vec2(-along.y, along.x);
    vec4 clip = at_end ? b : a;
    gl_Position = clip + vec4(corner * 2.0 / viewport * clip.w, 0.0, 0.0);
    line_place = vec4(at_end ? pixels + half_width : -half_width, side * half_width, pixels, 1.0) * clip.w;
#endif
}
