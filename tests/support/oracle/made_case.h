/* made_case.h: a small mesh made without taste, the options of a call, and how both are handed
 * over; made of any bytes, so that a seed and a fuzzer's input are the same thing. A case can be
 * written as text, read again and made smaller. */
#ifndef NORMA_TESTS_MADE_CASE_H
#define NORMA_TESTS_MADE_CASE_H
#include <norma/norma.h>
#include <stdio.h>

enum { CASE_POSITIONS = 2048, CASE_CORNERS = 4096, CASE_FACES = 600 };

typedef struct made_case {
    size_t position_count, corner_count, face_count;
    double positions[CASE_POSITIONS][3]; /* of values that the format holds */
    uint32_t corners[CASE_CORNERS], starts[CASE_FACES + 1], groups[CASE_FACES];
    uint8_t hard[CASE_CORNERS];
    int has_groups, has_hard;
    int soup;     /* no array of corners: 0, 1, 2, ... */
    int polygons; /* face_starts are given, though all faces may be triangles */
    norma_format format;
    size_t position_gap; /* bytes between two positions */
    size_t corner_size, normal_gap;
    int backwards; /* a parallel_for of the caller's that goes from the last to the first */
    norma_options options;
    float crease;
    uint64_t salt; /* decides whatever else is tried: which vertices move, at which end of a page
                      arrays lie, whether writes are counted (0: they are) */
} made_case;

void made_case_make(made_case *made, const void *bytes, size_t size);
void made_case_of_seed(made_case *made, uint64_t seed);

/* Text: a line for each position and face. read returns 0 if that is no case. */
void made_case_print(const made_case *made, FILE *file);
int made_case_read(made_case *made, FILE *file);
int made_case_load(made_case *made, const char *path);

/* Leaves out faces, corners, positions and options for as long as the case still fails. */
void made_case_shrink(made_case *made, int fails(const made_case *));

/* The next number of a chain that a salt begins (splitmix64; Steele, Lea, Flood 2014). */
uint64_t made_case_random(uint64_t *state);
#endif
