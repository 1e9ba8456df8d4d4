// surface.vert: a surface through the pipeline: local, world, view, clip (viewport: glViewport). How the files make a program: colour.glsl.
//
// #define one of  SHADING_FLAT     each face has one normal, that of its last corner (index triangles so that each face has a last vertex of its own, or none is shared)
//                 SHADING_GOURAUD  light is computed here, colours are interpolated
//                 SHADING_PHONG    normals are interpolated, light is computed for each pixel
//                 SHOW_NORMALS     the unit normal in lit space as a colour, 0.5 + 0.5 n
//                 SHOW_WINDING     faces seen from their front green, from their back red
//                 SHOW_ERROR       value on the colour scale; grey where it is below 0: there is nothing to compare
//                 SHOW_MATCAP      a studio's lights in it: the normal seen by the eye decides the colour
//                 SHOW_TANGENTS    the unit tangent in lit space as a colour, 0.5 + 0.5 t; darker where its sign is -1, grey where there is none
//                 SHOW_ZEBRA       stripes of light as they are mirrored in it
// #define LIGHT_IN_VIEW            lit space is view space; otherwise world space
//
// Attributes (bind by location)
//   0  vec3  position   local
//   1  vec3  normal     local, any length; with SHADING_FLAT the face's
//   2  vec4  colour     linear; the constant (1, 1, 1, 1) if the mesh has no colours (vertexAttrib4f)
//   3  float value      SHOW_ERROR: degrees
//   4  vec4  texcoord   SHADING_*: of the base map, of the normal map
//   5  vec4  tangent    SHADING_PHONG with a normal map, SHOW_TANGENTS: along which u grows, and a sign; zero: the shader takes derivatives
// Uniforms
//   mat4 local_to_world, world_to_view, view_to_clip
//   mat3 normal_matrix  from local to lit space: norma_normal_matrix of the node (world), norma_normal_matrix_model_view (view), reversed winding; or plain M, to show
//                       why that is wrong. Where the node mirrors, the front is clockwise: glFrontFace(GL_CW)
//   vec3 base_colour    linear
//   float two_sided     1: a back face is lit as the front of its other side; 0: as its normal says (cull it, if it shall not be seen)
//   float scale_top     SHOW_ERROR: the degrees at the scale's top
//   vec4 maps           SHADING_*: x: 1 with a base map, 2 with one of which alpha alone is looked at; y: strength of the normal map, 0 without; z: what has less alpha is not drawn; w: alpha of what blends. Zero: nothing of it
//   sampler2D base_map, normal_map     the first as SRGB8_ALPHA8
// and those of light.glsl.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
layout(location = 3) in float value;
layout(location = 4) in vec4 texcoord;
layout(location = 5) in vec4 tangent;
uniform mat4 local_to_world, world_to_view, view_to_clip;
uniform mat3 normal_matrix;
uniform vec3 base_colour;

out vec3 lit_point;
#if defined(SHADING_FLAT)
flat out vec3 lit_normal;
#else
out vec3 lit_normal;
#endif
out vec4 surface_colour, surface_texcoord;
out vec4 lit_tangent;
#if defined(SHADING_GOURAUD)
out vec3 back_colour;
#endif
#if defined(SHOW_ERROR)
out float surface_value;
#endif

void main() {
    vec4 world = local_to_world * vec4(position, 1.0);
    vec4 view = world_to_view * world;
    gl_Position = view_to_clip * view;
#if defined(LIGHT_IN_VIEW)
    lit_point = view.xyz;
#else
    lit_point = world.xyz;
#endif
    lit_normal = norma_transform_normal(normal_matrix, normal);
    surface_colour = vec4(base_colour * colour.rgb, colour.a);
    surface_texcoord = texcoord;
    mat3 to_lit = mat3(local_to_world);
#if defined(LIGHT_IN_VIEW)
    to_lit = mat3(world_to_view) * to_lit;
#endif
    lit_tangent = tangent.xyz == vec3(0.0) ? vec4(0.0) : norma_transform_tangent(to_lit, tangent, lit_normal);
#if defined(SHADING_GOURAUD)
    back_colour = lit(lit_point, -lit_normal, surface_colour.rgb);
    surface_colour.rgb = lit(lit_point, lit_normal, surface_colour.rgb);
#endif
#if defined(SHOW_ERROR)
    surface_value = value;
#endif
}
