// angle.frag: the angle between the two normals of angle.vert, on the scale of --show error, which ends at scale_top degrees.
uniform float scale_top;
in vec3 view_point, plain_normal, right_normal;
out vec4 pixel;

void main() {
    vec3 p = norma_unit(plain_normal), r = norma_unit(right_normal), face = norma_unit(cross(dFdx(view_point), dFdy(view_point)));
    float angle = degrees(atan(length(cross(p, r)), dot(p, r)));
    pixel = vec4(encode(decode(scale_colour(angle / scale_top)) * (0.45 + 0.55 * abs(dot(face, norma_unit(view_point))))), 1.0);
}
