// surface.frag: the colour of a pixel of a surface. Its #defines and uniforms are those of surface.vert; how the files make a program: colour.glsl.
uniform float two_sided, scale_top;

in vec3 lit_point;
#if defined(SHADING_FLAT)
flat in vec3 lit_normal;
#else
in vec3 lit_normal;
#endif
in vec3 surface_colour;
#if defined(SHADING_GOURAUD)
in vec3 back_colour;
#endif
#if defined(SHOW_ERROR)
in float surface_value;
#endif
out vec4 pixel;

// Gives a flat colour some shape: darker where the surface, as it lies, turns away from the eye.
vec3 shaped(vec3 colour) {
    vec3 face = unit(cross(dFdx(lit_point), dFdy(lit_point)));
    return colour * (0.55 + 0.45 * abs(dot(face, towards_eye(lit_point))));
}

void main() {
    bool turned = two_sided > 0.5 && !gl_FrontFacing;
    vec3 n = turned ? -unit(lit_normal) : unit(lit_normal);
#if defined(SHADING_GOURAUD)
    pixel = vec4(encode(turned ? back_colour : surface_colour), 1.0);
#elif defined(SHOW_NORMALS)
    pixel = vec4(0.5 + 0.5 * n, 1.0);
#elif defined(SHOW_WINDING)
    pixel = vec4(encode(shaped(decode(gl_FrontFacing ? vec3(0.24, 0.70, 0.36) : vec3(0.87, 0.20, 0.18)))), 1.0);
#elif defined(SHOW_ERROR)
    pixel = vec4(encode(shaped(decode(scale_colour(surface_value / scale_top)))), 1.0);
#else
    pixel = vec4(encode(lit(lit_point, n, surface_colour)), 1.0);
#endif
}
