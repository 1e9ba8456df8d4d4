/* acid_surface.c: the height field of a patch: an egg with a ridge and a dent, like none of its
 * mirror images or turns. */
#include "acid/acid_mesh.h"

/* sin 30 degrees to +x, and at 120 and 240 degrees from there. */
const acid_vector acid_lights[ACID_LIGHTS] = {
    {0.5, 0, 0.86602540378443865},
    {-0.25, 0.43301270189221932, 0.86602540378443865},
    {-0.25, -0.43301270189221932, 0.86602540378443865},
};

/* height / (1 + steepness q)^2, q a square, and the slope of that by q. */
static double bump(double height, double steepness, double q, double *by_q) {
    const double d = 1 / (1 + steepness * q), d2 = d * d;
    *by_q = -2 * steepness * height * d2 * d;
    return height * d2;
}

acid_relief acid_surface(double x, double y) {
    acid_relief relief = {0.36 - 0.44 * x * x - 0.36 * y * y - 0.10 * x * x * x + 0.08 * x * y * y,
        -0.88 * x - 0.30 * x * x + 0.08 * y * y, -0.72 * y + 0.16 * x * y};
    const double across = y - 0.5 * x - 0.35; /* the ridge */
    double by_q;
    relief.height += bump(0.16, 9, across * across, &by_q);
    relief.along_x += by_q * -1.0 * across;
    relief.along_y += by_q * 2.0 * across;
    const double dx = x - 0.30, dy = y + 0.40; /* the dent */
    relief.height += bump(-0.30, 5, dx * dx + dy * dy, &by_q);
    relief.along_x += by_q * 2 * dx;
    relief.along_y += by_q * 2 * dy;
    return relief;
}

acid_vector acid_surface_normal(const acid_relief *relief) {
    return acid_unit((acid_vector){-relief->along_x, -relief->along_y, 1});
}
