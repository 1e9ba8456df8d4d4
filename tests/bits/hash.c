/* hash.c: results to 64 bits. Not a cryptographic hash: nobody makes collisions here, and a changed
 * bit anywhere changes half of the hash. */
#include "bits.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bits_hash bits_begin(void) { return (bits_hash){0x9E3779B97F4A7C15u}; }

/* The finalizer of SplitMix64 (Steele, Lea, Flood 2014) over state and value. */
void bits_add(bits_hash *hash, uint64_t value) {
    uint64_t z = (hash->state ^ value) + 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    hash->state = z ^ (z >> 31);
}

void bits_size(bits_hash *hash, size_t value) {
    bits_add(hash, value == SIZE_MAX ? UINT64_MAX : value);
}

void bits_bytes(bits_hash *hash, const void *bytes, size_t size) {
    const unsigned char *at = bytes;
    bits_add(hash, size);
    for (; size >= 8; at += 8, size -= 8) {
        uint64_t word;
        memcpy(&word, at, 8);
        bits_add(hash, word);
    }
    uint64_t rest = 0;
    for (size_t i = 0; i < size; ++i) rest = rest << 8 | at[i];
    bits_add(hash, rest);
}

void bits_text(bits_hash *hash, const char *text) {
    bits_add(hash, text != NULL);
    if (text) bits_bytes(hash, text, strlen(text));
}

void bits_double(bits_hash *hash, double value) {
    uint64_t word = 0x7FF8000000000000u;
    if (!isnan(value)) memcpy(&word, &value, 8);
    bits_add(hash, word);
}

void bits_doubles(bits_hash *hash, const double *values, size_t count) {
    bits_add(hash, count);
    for (size_t i = 0; i < count; ++i) bits_double(hash, values[i]);
}

void bits_floats(bits_hash *hash, const float *values, size_t count) {
    bits_add(hash, count);
    for (size_t i = 0; i < count; ++i) {
        uint32_t word = 0x7FC00000u;
        if (!isnan(values[i])) memcpy(&word, values + i, 4);
        bits_add(hash, word);
    }
}

static void add_count(bits_hash *hash, norma_count count) {
    bits_size(hash, count.count);
    bits_size(hash, count.first);
}

void bits_report(bits_hash *hash, const norma_report *report) {
    add_count(hash, report->degenerate_faces);
    add_count(hash, report->non_finite);
    add_count(hash, report->unreferenced);
    add_count(hash, report->cancelled);
    add_count(hash, report->non_manifold_edges);
    add_count(hash, report->winding_conflicts);
}

void bits_edges(bits_hash *hash, const norma_edges *edges) {
    bits_size(hash, edges->count);
    bits_size(hash, edges->open);
    bits_size(hash, edges->smooth);
    bits_size(hash, edges->hard);
}

uint64_t bits_random(uint64_t *seed) {
    bits_hash hash = {*seed};
    bits_add(&hash, 1);
    return *seed = hash.state;
}

double bits_random_unit(uint64_t *seed) { return (double)(bits_random(seed) >> 32) * 0x1p-32; }

void *bits_room(size_t count, size_t size) {
    void *block =
        count <= SIZE_MAX / (size ? size : 1) ? malloc(count && size ? count * size : 1) : NULL;
    if (!block) {
        fprintf(stderr, "out of memory\n");
        exit(2);
    }
    memset(block, 0xA5, count * size);
    return block;
}

norma_options bits_options(const bits_way *way) {
    return (norma_options){.struct_size = sizeof(norma_options),
        .threads = way->threads,
        .isa = way->isa,
        .parallel_for = way->jobs};
}
