// scale.frag: the colour scale from left (0) to right (1).
in float scale_value;
out vec4 pixel;

void main() { pixel = vec4(scale_colour(scale_value), 1.0); }
