// light.glsl: Phong's model (1975): ambient, diffuse and specular light of a point, in linear colours.
//
// Everything here lies in one space, which is called lit space below: world space, or view space where the program has #define LIGHT_IN_VIEW. The picture is the same.
//   uniform vec4 eye                    position with w = 1; w = 0: direction to it (an orthographic camera)
//   uniform int  light_count            0 to 4
//   uniform vec3 light_direction[4]     unit, from the surface to the light
//   uniform vec3 light_colour[4]        linear
//   uniform vec4 phong                  ambient, diffuse, specular (0 to 1) and the exponent
uniform vec4 eye;
uniform int light_count;
uniform vec3 light_direction[4];
uniform vec3 light_colour[4];
uniform vec4 phong;

vec3 towards_eye(vec3 point) { return norma_unit(eye.xyz - eye.w * point); }

vec3 lit(vec3 point, vec3 normal, vec3 base) {
    vec3 to_eye = towards_eye(point), colour = phong.x * base;
    for (int i = 0; i < light_count; ++i) {
        float facing = dot(normal, light_direction[i]);
        if (facing > 0.0) {
            float mirrored = max(dot(2.0 * facing * normal - light_direction[i], to_eye), 0.0);
            colour += light_colour[i] * (phong.y * facing * base + phong.z * pow(mirrored, phong.w));
        }
    }
    return colour;
}
