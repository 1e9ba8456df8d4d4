// line.frag: a line with round ends, or an arrow, its borders smooth. Needs blending (SRC_ALPHA, ONE_MINUS_SRC_ALPHA); uniforms of line.vert; how the files make a program: colour.glsl.
uniform float width, head, rim;
in vec4 line_colour, line_place;
out vec4 pixel;

void main() {
    vec3 place = line_place.xyz / line_place.w;
    float along = place.x, across = abs(place.y), shaft_end = max(place.z - head, 0.0);
    vec2 beyond = vec2(max(max(-along, along - shaft_end), 0.0), across);
    float outside = length(beyond) - 0.5 * width;
    if (head > 0.0)
        outside = min(outside, max((across - 0.4 * (place.z - along)) * 0.93, shaft_end - along));
    float coverage = clamp(0.5 + rim - outside, 0.0, 1.0);
    if (coverage <= 0.0)
        discard;
    pixel = vec4(encode(line_colour.rgb), line_colour.a * coverage);
}
