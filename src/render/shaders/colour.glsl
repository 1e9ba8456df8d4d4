// colour.glsl: colours. All lighting is done in linear light; encode() makes sRGB of it, once, as the last thing that a fragment shader does.
//
// How a program is put together, natively and in the page: the line "#version 300 es", "precision highp float; precision highp int;", the #defines that its files name, then the text of
// include/norma/shaders/norma.glsl, colour.glsl, light.glsl and the stage's own file, each whole and in this order. Framebuffers are plain RGBA8 (what is in them is sRGB already).

// IEC 61966-2-1.
vec3 encode(vec3 linear) {
    vec3 c = clamp(linear, 0.0, 1.0);
    return mix(12.92 * c, 1.055 * pow(max(c, 0.0031308), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
vec3 decode(vec3 encoded) {
    return mix(encoded / 12.92, pow((encoded + 0.055) / 1.055, vec3(2.4)), step(0.04045, encoded));
}

// The scale of --show error, encoded, for t from 0 to 1: viridis, which stays readable without colour vision and in grey (van der Walt, Smith 2015; CC0).
vec3 scale_colour(float t) {
    const vec3 stops[9] = vec3[9](vec3(0.267, 0.005, 0.329), vec3(0.279, 0.175, 0.483), vec3(0.230, 0.322, 0.546), vec3(0.173, 0.449, 0.558), vec3(0.128, 0.567, 0.551),
                                  vec3(0.158, 0.684, 0.502), vec3(0.369, 0.789, 0.383), vec3(0.678, 0.864, 0.190), vec3(0.993, 0.906, 0.144));
    float at = clamp(t, 0.0, 1.0) * 8.0;
    int below = min(int(at), 7);
    return mix(stops[below], stops[below + 1], at - float(below));
}
