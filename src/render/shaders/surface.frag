// surface.frag: the colour of a pixel of a surface. Its #defines and uniforms are those of surface.vert; how the files make a program: colour.glsl.
uniform float two_sided, scale_top;
uniform mat4 world_to_view;

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

// From lit space to the eye's axes.
vec3 seen(vec3 v) {
#if defined(LIGHT_IN_VIEW)
    return v;
#else
    return mat3(world_to_view) * v;
#endif
}

// A ball of grey clay under two soft lamps, one above to the left, one to the right, with a bright rim: its colour where it has this normal.
vec3 matcap(vec3 n) {
    float top = smoothstep(-0.5, 1.0, dot(n, vec3(-0.42, 0.72, 0.55))), side = smoothstep(0.1, 1.0, dot(n, vec3(0.86, 0.05, 0.5)));
    float rim = pow(1.0 - clamp(n.z, 0.0, 1.0), 3.0) * smoothstep(-0.6, 0.6, n.y), spot = smoothstep(0.965, 0.985, dot(n, normalize(vec3(-0.35, 0.55, 0.76))));
    return vec3(0.035, 0.04, 0.05) + vec3(0.46, 0.42, 0.37) * top * top + vec3(0.06, 0.08, 0.12) * side + vec3(0.18, 0.2, 0.24) * rim + 0.3 * spot;
}

// Stripes across the mirrored direction, as wide everywhere as the mirror makes them; grey where they are narrower than a pixel.
float zebra(vec3 n, vec3 to_eye) {
    vec3 mirrored = reflect(-to_eye, n);
    float at = 9.0 * asin(clamp(mirrored.y, -1.0, 1.0)), width = max(fwidth(at), 1e-4);
    float stripe = smoothstep(-width, width, sin(2.0 * at) / 2.0);
    return mix(stripe, 0.5, clamp(width - 0.7, 0.0, 1.0));
}

void main() {
    bool turned = two_sided > 0.5 && !gl_FrontFacing;
    vec3 n = turned ? -unit(lit_normal) : unit(lit_normal);
#if defined(SHADING_GOURAUD)
    pixel = vec4(encode(turned ? back_colour : surface_colour), 1.0);
#elif defined(SHOW_NORMALS)
    pixel = vec4(0.5 + 0.5 * n, 1.0);
#elif defined(SHOW_MATCAP)
    pixel = vec4(encode(matcap(unit(seen(n)))), 1.0);
#elif defined(SHOW_ZEBRA)
    vec3 eye_normal = unit(seen(n)), to_eye = unit(seen(towards_eye(lit_point)));
    pixel = vec4(encode((0.7 + 0.3 * abs(dot(eye_normal, to_eye))) * mix(vec3(0.012), vec3(0.72), zebra(eye_normal, to_eye))), 1.0);
#elif defined(SHOW_WINDING)
    pixel = vec4(encode(shaped(decode(gl_FrontFacing ? vec3(0.24, 0.70, 0.36) : vec3(0.87, 0.20, 0.18)))), 1.0);
#elif defined(SHOW_ERROR)
    pixel = vec4(encode(shaped(decode(scale_colour(surface_value / scale_top)))), 1.0);
#else
    pixel = vec4(encode(lit(lit_point, n, surface_colour)), 1.0);
#endif
}
