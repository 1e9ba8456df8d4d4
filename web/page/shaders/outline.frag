// outline.frag: a line round what is white in a mask, on its outside, so that what it goes round keeps its own look.
uniform sampler2D mask;
uniform vec2 corner; // of the mask in the picture, in pixels
uniform float width;
uniform vec4 colour;
out vec4 pixel;

const int steps = 16;

void main() {
    ivec2 last = textureSize(mask, 0) - 1, here = ivec2(gl_FragCoord.xy - corner);
    if (texelFetch(mask, clamp(here, ivec2(0), last), 0).r > 0.5)
        discard;
    for (int i = 0; i < 2 * steps; i++) {
        float angle = float(i) * 6.2831853 / float(steps), reach = i < steps ? width : 0.5 * width;
        ivec2 there = here + ivec2(round(reach * vec2(cos(angle), sin(angle))));
        if (texelFetch(mask, clamp(there, ivec2(0), last), 0).r > 0.5) {
            pixel = vec4(encode(colour.rgb), colour.a);
            return;
        }
    }
    discard;
}
