// surface.frag: the colour of a pixel of a surface. Its #defines and uniforms are those of surface.vert; how the files make a program: colour.glsl.
uniform float two_sided, scale_top;
uniform mat4 world_to_view;
uniform vec4 maps;
uniform sampler2D base_map, normal_map;

in vec3 lit_point;
#if defined(SHADING_FLAT)
flat in vec3 lit_normal;
#else
in vec3 lit_normal;
#endif
in vec4 surface_colour, surface_texcoord;
in vec4 lit_tangent;
#if defined(SHADING_GOURAUD)
in vec3 back_colour;
#endif
#if defined(SHOW_ERROR)
in float surface_value;
#endif
out vec4 pixel;

// Gives a flat colour some shape: darker where the surface, as it lies, turns away from the eye.
vec3 shaped(vec3 colour) {
    vec3 face = norma_flat_normal(dFdx(lit_point), dFdy(lit_point));
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

// The base colour times the base map, of which a mask has but alpha; what that cuts away is not drawn. In w the alpha.
vec4 mapped_colour() {
    vec4 base = maps.x > 0.5 ? texture(base_map, surface_texcoord.xy) : vec4(1.0);
    float alpha = base.a * surface_colour.a;
    if (alpha < maps.z)
        discard;
    return vec4(maps.x > 1.5 ? vec3(1.0) : base.rgb, maps.w > 0.0 ? maps.w * alpha : 1.0);
}

// Along which u grows, and along which v falls, where the surface has no tangents (Schuler 2013).
void derived_frame(vec3 n, out vec3 along_u, out vec3 against_v) {
    vec3 dx = dFdx(lit_point), dy = dFdy(lit_point), x = cross(dy, n), y = cross(n, dx);
    vec2 ux = dFdx(surface_texcoord.zw), uy = dFdy(surface_texcoord.zw);
    float sense = dot(dx, x) < 0.0 ? -1.0 : 1.0;
    along_u = sense * (x * ux.x + y * uy.x);
    against_v = -sense * (x * ux.y + y * uy.y);
    float largest = max(dot(along_u, along_u), dot(against_v, against_v));
    float scale = largest > 0.0 ? inversesqrt(largest) : 0.0;
    along_u *= scale;
    against_v *= scale;
}

// The normal as the normal map bends it.
vec3 mapped_normal(vec3 n) {
    if (maps.y == 0.0)
        return n;
    vec3 texel = texture(normal_map, surface_texcoord.zw).xyz, result;
    if (dot(lit_tangent.xyz, lit_tangent.xyz) > 1e-8) {
        result = norma_perturb(lit_normal, lit_tangent, texel, maps.y);
    } else {
        vec3 bent = 2.0 * texel - 1.0, along_u, against_v;
        derived_frame(n, along_u, against_v);
        result = norma_unit(maps.y * (bent.x * along_u + bent.y * against_v) + bent.z * n);
    }
    return dot(result, result) > 0.0 ? result : n;
}

void main() {
    bool turned = two_sided > 0.5 && !gl_FrontFacing;
    vec3 n = norma_facing_normal(norma_unit(lit_normal), !turned);
#if defined(SHADING_GOURAUD)
    vec4 base = mapped_colour();
    pixel = vec4(encode(base.rgb * (turned ? back_colour : surface_colour.rgb)), base.a);
#elif defined(SHOW_NORMALS)
    pixel = vec4(0.5 + 0.5 * n, 1.0);
#elif defined(SHOW_MATCAP)
    pixel = vec4(encode(matcap(norma_unit(seen(n)))), 1.0);
#elif defined(SHOW_ZEBRA)
    vec3 eye_normal = norma_unit(seen(n)), to_eye = norma_unit(seen(towards_eye(lit_point)));
    pixel = vec4(encode((0.7 + 0.3 * abs(dot(eye_normal, to_eye))) * mix(vec3(0.012), vec3(0.72), zebra(eye_normal, to_eye))), 1.0);
#elif defined(SHOW_TANGENTS)
    pixel = lit_tangent.w == 0.0 ? vec4(encode(shaped(vec3(0.2))), 1.0) : vec4((lit_tangent.w > 0.0 ? 1.0 : 0.6) * (0.5 + 0.5 * norma_unit(lit_tangent.xyz)), 1.0);
#elif defined(SHOW_WINDING)
    pixel = vec4(encode(shaped(decode(gl_FrontFacing ? vec3(0.24, 0.70, 0.36) : vec3(0.87, 0.20, 0.18)))), 1.0);
#elif defined(SHOW_ERROR)
    vec3 scaled = surface_value < 0.0 ? vec3(0.2) : decode(scale_colour(surface_value / scale_top));
    pixel = vec4(encode(shaped(scaled)), 1.0);
#else
    vec4 base = mapped_colour();
#if defined(SHADING_PHONG)
    n = norma_facing_normal(mapped_normal(norma_unit(lit_normal)), !turned);
#endif
    pixel = vec4(encode(lit(lit_point, n, base.rgb * surface_colour.rgb)), base.a);
#endif
}
