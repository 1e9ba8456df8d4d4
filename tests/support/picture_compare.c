/* picture_compare.c: a picture against a reference, or two parts of one: picture_compare A.png
 * B.png [MEAN [PART]]. Fails where they differ in size, where the mean difference of a level (of
 * 255) is above MEAN (0.5), or where more than PART (0.01) of the pixels differ by more than 8
 * levels. Another renderer may decide otherwise which side of an edge the middle of a pixel lies
 * on. */
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int read_picture(const char *path, png_image *image, unsigned char **pixels) {
    memset(image, 0, sizeof *image);
    image->version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_file(image, path)) {
        fprintf(stderr, "%s: %s\n", path, image->message);
        return 0;
    }
    image->format = PNG_FORMAT_RGBA;
    *pixels = malloc(PNG_IMAGE_SIZE(*image));
    return *pixels && png_image_finish_read(image, NULL, *pixels, 0, NULL);
}

int main(int count, char **arguments) {
    png_image a, b;
    unsigned char *x = NULL, *y = NULL;
    if (count < 3 || !read_picture(arguments[1], &a, &x) || !read_picture(arguments[2], &b, &y))
        return 2;
    const double most_mean = count > 3 ? strtod(arguments[3], NULL) : 0.5,
                 most_part = count > 4 ? strtod(arguments[4], NULL) : 0.01;
    if (a.width != b.width || a.height != b.height) {
        printf("%ux%u against %ux%u\n", a.width, a.height, b.width, b.height);
        return 1;
    }
    const size_t pixels = (size_t)a.width * a.height;
    size_t off = 0;
    double sum = 0;
    for (size_t i = 0; i < pixels; ++i) {
        int largest = 0;
        for (size_t k = 0; k < 4; ++k) {
            const int difference = abs(x[4 * i + k] - y[4 * i + k]);
            largest = difference > largest ? difference : largest;
            sum += difference;
        }
        off += largest > 8;
    }
    const double mean = sum / (4 * (double)pixels), part = (double)off / (double)pixels;
    printf("mean difference %.4f levels, %.4f of the pixels off by more than 8\n", mean, part);
    free(x);
    free(y);
    return mean > most_mean || part > most_part;
}
