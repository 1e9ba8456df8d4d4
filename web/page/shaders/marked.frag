// marked.frag: what is marked in its colour, shaded by the faces as they lie: normals may be what is wrong.
// #define MARKED_ONLY    the rest is left out
//         COUNT          white where it is marked, black elsewhere
in vec3 view_point;
in vec4 mark;
out vec4 pixel;

const float least = 0.2; // of the way from a corner that is marked to one that is not

void main() {
    bool marked = mark.a > least;
#if defined(MARKED_ONLY)
    if (!marked) discard;
#endif
#if defined(COUNT)
    pixel = vec4(vec3(marked ? 1.0 : 0.0), 1.0);
#else
    vec3 face = norma_unit(cross(dFdx(view_point), dFdy(view_point))), to_eye = -norma_unit(view_point);
    face *= sign(dot(face, to_eye));
    float light = 0.3 + 0.4 * max(dot(face, to_eye), 0.0) + 0.3 * max(dot(face, norma_unit(vec3(-0.6, 0.7, 0.5))), 0.0);
    pixel = vec4(encode(mark.rgb / max(mark.a, least) * (0.55 + 0.45 * light)), 1.0);
#endif
}
