/* made_mesh.c: meshes and options from bytes: small, mostly right, wrong in every way that
 * arguments can be. */
#include "made_mesh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const size_t component_sizes[] = {4, 8, 1, 1, 2, 2};

static void *block_of(const void *bytes, size_t size) {
    void *block = malloc(size ? size : 1);
    if (size) memcpy(block, bytes, size);
    return block;
}

static void put_component(fuzz_bytes *bytes, norma_format format, uint8_t *at) {
    float number = format == NORMA_FORMAT_FLOAT ? fuzz_float(bytes) : 0;
    double wide = format == NORMA_FORMAT_DOUBLE ? fuzz_double(bytes) : 0;
    uint16_t integer = 0;
    if (format == NORMA_FORMAT_FLOAT)
        memcpy(at, &number, sizeof number);
    else if (format == NORMA_FORMAT_DOUBLE)
        memcpy(at, &wide, sizeof wide);
    else {
        integer = (uint16_t)(fuzz_u8(bytes) * 257);
        memcpy(at, &integer, component_sizes[format]);
    }
}

norma_vec3_view made_view(fuzz_bytes *bytes, size_t count, void **block) {
    static const norma_format formats[] = {NORMA_FORMAT_FLOAT, NORMA_FORMAT_FLOAT,
        NORMA_FORMAT_DOUBLE, NORMA_FORMAT_INT8, NORMA_FORMAT_UINT8, NORMA_FORMAT_INT16,
        NORMA_FORMAT_UINT16, NORMA_FORMAT_FLOAT};
    uint8_t kind = fuzz_u8(bytes);
    norma_vec3_view view = {.count = count, .format = formats[kind % 8]};
    size_t size = 3 * component_sizes[view.format], stride = kind & 8 ? size + (kind >> 4) : size;
    uint8_t *data = calloc(count ? (count - 1) * stride + size : 1, 1);
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < 3; ++k)
            put_component(bytes, view.format, data + i * stride + k * (size / 3));
    view.stride = kind & 8 ? stride : 0;
    view.data = *block = data;
    return view;
}

static void take_corners(fuzz_bytes *bytes, made_mesh *made, size_t corner_count, uint8_t kind) {
    static const size_t sizes[] = {4, 0, 2, 1};
    norma_mesh *mesh = &made->mesh;
    mesh->corner_size = sizes[kind % 4];
    size_t size = mesh->corner_size ? mesh->corner_size : 4;
    uint8_t *corners = malloc(corner_count * size + 1);
    /* One in 256 may name a position that is not there. */
    for (size_t c = 0; c < corner_count; ++c) {
        uint8_t byte = fuzz_u8(bytes);
        uint32_t index =
            byte == 255 ? fuzz_u32(bytes)
                        : (uint32_t)(mesh->positions.count ? byte % mesh->positions.count : byte);
        memcpy(corners + c * size, &index, size);
    }
    mesh->corners = made->blocks[made->block_count++] = block_of(corners, corner_count * size);
    free(corners);
}

static void take_faces(fuzz_bytes *bytes, made_mesh *made, size_t corner_count) {
    uint32_t starts[256], at = 0;
    size_t faces = 0;
    starts[0] = 0;
    while (at < corner_count && faces < 254) {
        uint8_t corners = fuzz_u8(bytes);
        at = corners == 255 ? fuzz_u32(bytes) : at + corners % 8;
        starts[++faces] = corners < 250 && at > corner_count ? (uint32_t)corner_count : at;
    }
    made->mesh.face_starts = made->blocks[made->block_count++] =
        block_of(starts, (faces + 1) * sizeof *starts);
    made->mesh.face_count = made->faces = faces;
}

/* Counts for which no memory is there: they must be refused before anything is read. */
static void make_huge(fuzz_bytes *bytes, norma_mesh *mesh) {
    static const size_t huge[] = {UINT32_MAX, (size_t)UINT32_MAX + 1, SIZE_MAX, SIZE_MAX / 2,
        SIZE_MAX / 3 * 3, SIZE_MAX / 12 * 12};
    size_t count = huge[fuzz_below(bytes, 6)];
    switch (fuzz_below(bytes, 3)) {
    case 0:
        mesh->positions.count = count;
        break;
    case 1:
        mesh->corner_count = count;
        break;
    default:
        mesh->positions.stride = SIZE_MAX - fuzz_below(bytes, 64);
        mesh->positions.count = mesh->positions.count > 2 ? mesh->positions.count : 3;
        break;
    }
}

made_mesh *made_mesh_take(fuzz_bytes *bytes) {
    made_mesh *made = calloc(1, sizeof *made);
    uint8_t kind = fuzz_u8(bytes), extras = fuzz_u8(bytes);
    size_t positions = fuzz_u8(bytes) % 96, corners = fuzz_u8(bytes) % 192;
    made->mesh.positions = made_view(bytes, positions, &made->blocks[made->block_count]);
    ++made->block_count;
    if (!(kind & 4)) /* triangles, but for one in eight */
        corners = extras >= 224 ? corners : corners / 3 * 3;
    made->mesh.corner_count = corners;
    if (kind & 4) take_faces(bytes, made, corners);
    if (kind & 8 && !(extras & 16))
        made->mesh.corner_count = corners = corners < positions ? corners : positions / 3 * 3;
    else
        take_corners(bytes, made, corners, kind);
    made->faces =
        kind & 4 ? made->mesh.face_count : corners / 3; /* face_starts that no longer end where the
                                                           corners do are an error to be found */
    if (extras & 1) {
        uint32_t groups[256];
        for (size_t f = 0; f < made->faces; ++f) groups[f] = fuzz_u8(bytes) & 7;
        made->mesh.smoothing_groups = made->blocks[made->block_count++] =
            block_of(groups, made->faces * sizeof *groups);
    }
    if (extras & 2) {
        uint8_t hard[256] = {0};
        for (size_t c = 0; c < corners; ++c) hard[c] = fuzz_u8(bytes) > 200;
        made->mesh.hard_edges = made->blocks[made->block_count++] = block_of(hard, corners);
    }
    if (extras == 15) make_huge(bytes, &made->mesh);
    return made;
}

void made_mesh_free(made_mesh *made) {
    for (size_t i = 0; i < made->block_count; ++i) free(made->blocks[i]);
    free(made);
}

void made_options_take(fuzz_bytes *bytes, made_options *made) {
    static const uint32_t threads[] = {0, 1, 2, 3};
    uint8_t a = fuzz_u8(bytes), b = fuzz_u8(bytes), c = fuzz_u8(bytes);
    *made = (made_options){0};
    norma_options *o = &made->options;
    o->struct_size = c & 1 ? sizeof *o : 0;
    o->weight = (norma_weight)(a % 8 == 7 && a < 250 ? 0 : a % 8);
    o->weld = (norma_weld)(a / 8 % 4 == 3 ? (a < 252 ? 0 : 3) : a / 8 % 4);
    o->weld_distance = o->weld == NORMA_WELD_DISTANCE ? fuzz_double(bytes) : 0;
    o->non_manifold = a & 32 ? NORMA_NON_MANIFOLD_SMOOTH : NORMA_NON_MANIFOLD_HARD;
    o->fallback = (norma_fallback)(b % 4 == 3 && b < 250 ? 0 : b % 4);
    for (int k = 0; o->fallback == NORMA_FALLBACK_GIVEN && k < 3; ++k)
        o->fallback_normal[k] = fuzz_float(bytes);
    o->normal_stride = b & 4 ? 12 + (b >> 4) : 0;
    o->threads = c & 2 ? threads[c >> 6] : 0;
    if (c & 4) o->parallel_for = fuzz_backwards;
    o->isa = c & 8 && c & 16 ? NORMA_ISA_PORTABLE : NORMA_ISA_BEST;
    fuzz_allocator_start(&made->allocator, c & 32 ? 1 + fuzz_u8(bytes) % 40 : 0);
    o->allocator = made->allocator.allocator;
    o->allocator.user = &made->allocator;
    o->edges = c & 1 ? &made->edges : NULL;
}
