// shadow.frag: alpha is how dark the ground is; what is near it casts more (shadow.vert).
out vec4 pixel;
#if defined(CAST)
void main() { pixel = vec4(1.0 - gl_FragCoord.z); }
#else
in vec2 at;
uniform sampler2D shadow;
uniform vec2 reach; // from one of nine samples to the next; of the ground: its darkness
void main() {
#if defined(BLUR)
    const float weights[5] = float[](0.227, 0.1945, 0.1216, 0.0541, 0.0162);
    float sum = weights[0] * texture(shadow, at).a;
    for (int i = 1; i < 5; ++i) sum += weights[i] * (texture(shadow, at + float(i) * reach).a + texture(shadow, at - float(i) * reach).a);
    pixel = vec4(sum);
#else
    pixel = vec4(0.0, 0.0, 0.0, reach.x * texture(shadow, at).a);
#endif
}
#endif
