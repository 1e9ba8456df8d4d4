/* test_edit.c: norma_document_edit on every mesh of the data set and of assets: faces reversed,
 * left out, normals and positions replaced, vertices copied, each read back from the bytes written.
 * Reversed twice, a text or a list of rows is byte for byte what it was. */
#include "check.h"
#include "document_bytes.h"
#include "mesh_files.h"

static uint32_t next_random(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static size_t corner_at(const norma_mesh *mesh, size_t corner) {
    if (!mesh->corners) return corner;
    if (mesh->corner_size == 1) return ((const uint8_t *)mesh->corners)[corner];
    return mesh->corner_size == 2 ? ((const uint16_t *)mesh->corners)[corner]
                                  : ((const uint32_t *)mesh->corners)[corner];
}

static size_t faces_of(const norma_mesh *mesh) {
    return mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
}
static size_t start_of(const norma_mesh *mesh, size_t face) {
    return mesh->face_starts ? mesh->face_starts[face] : 3 * face;
}

static void position_at(const norma_mesh *mesh, size_t corner, double out[3]) {
    const norma_vec3_view *view = &mesh->positions;
    const size_t sizes[] = {4, 8, 1, 1, 2, 2}, size = sizes[view->format];
    const unsigned char *at = (const unsigned char *)view->data +
                              corner_at(mesh, corner) * (view->stride ? view->stride : 3 * size);
    for (int k = 0; k < 3; ++k, at += size) {
        float f;
        int16_t s;
        uint16_t u;
        switch (view->format) {
        case NORMA_FORMAT_FLOAT:
            memcpy(&f, at, 4), out[k] = (double)f;
            break;
        case NORMA_FORMAT_DOUBLE:
            memcpy(&out[k], at, 8);
            break;
        case NORMA_FORMAT_INT8:
            out[k] = *(const int8_t *)at;
            break;
        case NORMA_FORMAT_UINT8:
            out[k] = *at;
            break;
        case NORMA_FORMAT_INT16:
            memcpy(&s, at, 2), out[k] = s;
            break;
        case NORMA_FORMAT_UINT16:
            memcpy(&u, at, 2), out[k] = u;
            break;
        }
    }
}

typedef struct opened {
    document_bytes bytes;
    norma_document *document;
    size_t meshes;
} opened;

static opened open_bytes(document_bytes bytes, const char *path) {
    opened file = {.bytes = bytes, .document = bytes_open(bytes, path)};
    file.meshes = norma_document_mesh_count(file.document);
    return file;
}

static void close_bytes(opened *file) {
    norma_document_close(file->document);
    bytes_free(&file->bytes);
}

static int is_read(norma_document *document, size_t mesh) {
    norma_mesh_info info;
    assert_int_equal(norma_document_mesh_info(document, mesh, &info), NORMA_DOCUMENT_OK);
    return !info.not_read;
}

static norma_mesh_data data_of(norma_document *document, size_t mesh) {
    norma_mesh_data data;
    assert_int_equal(norma_document_mesh_data(document, mesh, &data, NULL), NORMA_DOCUMENT_OK);
    return data;
}

/* Marks for about one element of five, at least one. */
static uint8_t *random_marks(size_t count, uint32_t *seed) {
    uint8_t *marks = calloc(count + 1, 1);
    for (size_t i = 0; i < count; ++i) marks[i] = next_random(seed) % 5 == 0;
    if (count) marks[next_random(seed) % count] = 1;
    return marks;
}

/* ---- faces */

static void compare_faces(
    const norma_mesh *old, const norma_mesh *now, const norma_mesh_edit *edit) {
    size_t face = 0, count = faces_of(old);
    for (size_t f = 0; f < count; ++f) {
        if (edit->drop_faces && edit->drop_faces[f]) continue;
        size_t begin = start_of(old, f), end = start_of(old, f + 1), at = start_of(now, face);
        assert_int_equal(start_of(now, face + 1) - at, end - begin);
        for (size_t i = begin; i < end; ++i) {
            size_t from =
                edit->reverse_faces && edit->reverse_faces[f] && i > begin ? end + begin - i : i;
            double a[3], b[3];
            position_at(old, from, a);
            position_at(now, at + i - begin, b);
            assert_true(
                memcmp(a, b, sizeof a) == 0 || a[0] != a[0] || a[1] != a[1] || a[2] != a[2]);
        }
        ++face;
    }
    assert_int_equal(face, faces_of(now));
}

static int has_strips(norma_document *document, const norma_mesh_data *data, size_t mesh) {
    norma_mesh_info info;
    norma_document_mesh_info(document, mesh, &info);
    return norma_document_format(document) == NORMA_FILE_PLY && info.faces != faces_of(&data->mesh);
}

/* The edited bytes, or none where the format said that it cannot. */
static document_bytes edited(document_bytes bytes, const char *path, const norma_mesh_edit *edits) {
    norma_document *document = bytes_open(bytes, path);
    norma_document_error error;
    norma_document_result result = norma_document_edit(document, edits, &error);
    document_bytes out = {0};
    if (result == NORMA_DOCUMENT_ERROR_UNSUPPORTED)
        assert_true(error.message[0] != 0);
    else if (result) {
        print_error("%s: %s\n", path, error.message);
        fail();
    } else
        out = bytes_of(document);
    norma_document_close(document);
    return out;
}

static void free_edits(norma_mesh_edit *edits, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        free((void *)edits[i].reverse_faces);
        free((void *)edits[i].drop_faces);
        free((void *)edits[i].set_normals);
        free((void *)edits[i].normals);
    }
    free(edits);
}

static void try_faces(const char *path, int drop) {
    uint32_t seed = 7;
    opened file = open_bytes(bytes_load(path), path);
    norma_mesh_edit *edits = calloc(file.meshes + 1, sizeof *edits);
    for (size_t m = 0; m < file.meshes; ++m) {
        if (!is_read(file.document, m)) continue;
        norma_mesh_data data = data_of(file.document, m);
        size_t faces = faces_of(&data.mesh);
        edits[m].reverse_faces = random_marks(faces, &seed);
        uint8_t *dropped =
            drop && !has_strips(file.document, &data, m) ? random_marks(faces, &seed) : NULL;
        if (dropped && faces < 2) /* a glTF primitive keeps one */
            dropped[0] = 0;
        edits[m].drop_faces = dropped;
    }
    document_bytes out = edited(file.bytes, path, edits);
    if (out.size) {
        opened now = open_bytes(out, path);
        for (size_t m = 0; m < file.meshes; ++m) {
            if (!is_read(file.document, m)) continue;
            norma_mesh_data before = data_of(file.document, m), after = data_of(now.document, m);
            size_t left = 0;
            for (size_t f = 0; f < faces_of(&before.mesh); ++f)
                left += !edits[m].drop_faces || !edits[m].drop_faces[f];
            if (left) compare_faces(&before.mesh, &after.mesh, &edits[m]);
        }
        norma_file_format format = norma_document_format(file.document);
        if (!drop && format != NORMA_FILE_GLTF && format != NORMA_FILE_GLB) {
            document_bytes back = edited(out, path, edits);
            norma_mesh_data data = data_of(file.document, 0);
            if (!has_strips(file.document, &data, 0) && !bytes_equal(back, file.bytes)) {
                print_error("%s: reversed twice is not the same\n", path);
                fail();
            }
            bytes_free(&back);
        }
        close_bytes(&now);
    }
    free_edits(edits, file.meshes);
    close_bytes(&file);
}

/* ---- normals */

static void try_normals(const char *path) {
    uint32_t seed = 11;
    opened file = open_bytes(bytes_load(path), path);
    norma_mesh_edit *edits = calloc(file.meshes + 1, sizeof *edits);
    int any = 0;
    for (size_t m = 0; m < file.meshes; ++m) {
        if (!is_read(file.document, m)) continue;
        norma_mesh_data data = data_of(file.document, m);
        if (!data.normals.count) continue;
        any = 1;
        uint8_t *set = random_marks(data.normals.count, &seed);
        float *normals = calloc(3 * data.normals.count + 1, sizeof *normals);
        for (size_t i = 0; i < data.normals.count; ++i)
            normals[3 * i + next_random(&seed) % 3] = next_random(&seed) % 2 ? 1.0f : -1.0f;
        edits[m].set_normals = set;
        edits[m].normals = normals;
    }
    document_bytes out = any ? edited(file.bytes, path, edits) : (document_bytes){0};
    if (out.size) {
        opened now = open_bytes(out, path);
        for (size_t m = 0; m < file.meshes; ++m) {
            if (!edits[m].set_normals) continue;
            norma_mesh_data before = data_of(file.document, m), after = data_of(now.document, m);
            assert_int_equal(before.normals.count, after.normals.count);
            for (size_t i = 0; i < before.normals.count; ++i) {
                const float *is = (const float *)before.normals.data + 3 * i,
                            *was = (const float *)after.normals.data + 3 * i;
                const float *wanted = edits[m].set_normals[i] ? edits[m].normals + 3 * i : is;
                for (int k = 0; k < 3; ++k)
                    if (!(was[k] == wanted[k]) && !(was[k] != was[k] && wanted[k] != wanted[k])) {
                        print_error("%s: normal %zu is %g instead of %g\n", path, i, (double)was[k],
                            (double)wanted[k]);
                        fail();
                    }
            }
        }
        close_bytes(&now);
    }
    free_edits(edits, file.meshes);
    close_bytes(&file);
}

/* ---- vertices: some copied, each corner's at the old one or at its copy, which may be all that
 * stays; some that no face uses go */

static void random_vertices(const norma_mesh *mesh, norma_mesh_edit *edit, uint32_t *seed) {
    size_t count = mesh->positions.count, next = 0;
    uint32_t *sources = calloc(2 * count + 1, sizeof *sources),
             *corners = calloc(mesh->corner_count + 1, sizeof *corners);
    uint32_t *kept = calloc(count + 1, sizeof *kept), *copies = calloc(count + 1, sizeof *copies);
    uint8_t *used = calloc(count + 1, 1);
    for (size_t c = 0; c < mesh->corner_count; ++c) used[corner_at(mesh, c)] = 1;
    for (size_t v = 0; v < count; ++v) {
        kept[v] = UINT32_MAX;
        if (next_random(seed) % (used[v] ? 9 : 2))
            kept[v] = (uint32_t)next, sources[next++] = (uint32_t)v;
    }
    for (size_t v = count; v-- > 0;) {
        copies[v] = kept[v];
        if (used[v] && (next_random(seed) % 5 == 0 || kept[v] == UINT32_MAX))
            copies[v] = (uint32_t)next, sources[next++] = (uint32_t)v;
        kept[v] = kept[v] == UINT32_MAX ? copies[v] : kept[v];
    }
    for (size_t c = 0; c < mesh->corner_count; ++c)
        corners[c] = (next_random(seed) % 2 ? kept : copies)[corner_at(mesh, c)];
    edit->source_vertices = sources;
    edit->vertex_count = next;
    edit->new_corners = corners;
    free(kept);
    free(copies);
    free(used);
}

/* Of some of the new vertices, along the axes, which every encoding holds. */
static void random_normals(norma_mesh_edit *edit, uint32_t *seed) {
    float *normals = calloc(3 * edit->vertex_count, sizeof *normals);
    for (size_t v = 0; v < edit->vertex_count; ++v)
        normals[3 * v + next_random(seed) % 3] = next_random(seed) % 2 ? 1.0f : -1.0f;
    edit->set_normals = random_marks(edit->vertex_count, seed);
    edit->normals = normals;
}

static void same_floats(
    const float *was, const float *is, size_t width, const norma_mesh_edit *edit) {
    assert_int_equal(!was, !is);
    for (size_t v = 0; was && v < edit->vertex_count; ++v)
        assert_memory_equal(
            was + width * edit->source_vertices[v], is + width * v, width * sizeof *was);
}

/* Of what was decoded to floats. */
static void same_vectors(
    const norma_vec3_view *was, const norma_vec3_view *is, const norma_mesh_edit *edit) {
    assert_int_equal(is->count, was->count ? edit->vertex_count : 0);
    if (was->count) same_floats(was->data, is->data, 3, edit);
}

static void compare_vertices(
    norma_document *was, norma_document *is, size_t mesh, const norma_mesh_edit *edit) {
    norma_mesh_data before = data_of(was, mesh), after = data_of(is, mesh);
    norma_mesh_attributes old, now;
    norma_mesh_info info;
    assert_int_equal(after.mesh.positions.count, edit->vertex_count);
    assert_int_equal(after.mesh.corner_count, before.mesh.corner_count);
    for (size_t c = 0; c < before.mesh.corner_count; ++c) {
        double a[3], b[3];
        position_at(&before.mesh, c, a);
        position_at(&after.mesh, c, b);
        assert_int_equal(corner_at(&after.mesh, c), edit->new_corners[c]);
        assert_memory_equal(a, b, sizeof a);
    }
    assert_int_equal(after.normals.count, before.normals.count ? edit->vertex_count : 0);
    for (size_t v = 0; v < after.normals.count; ++v) {
        const float *is_now = (const float *)after.normals.data + 3 * v,
                    *stored = (const float *)before.normals.data + 3 * edit->source_vertices[v];
        const float *wanted = edit->set_normals[v] ? edit->normals + 3 * v : stored;
        for (int k = 0; k < 3; ++k)
            assert_true(
                is_now[k] == wanted[k] || (is_now[k] != is_now[k] && wanted[k] != wanted[k]));
    }
    assert_int_equal(norma_document_mesh_attributes(was, mesh, &old, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_attributes(is, mesh, &now, NULL), NORMA_DOCUMENT_OK);
    if (!old.corner_texcoords) same_floats(old.texcoords, now.texcoords, 2, edit);
    same_floats(old.colors, now.colors, 4, edit);
    same_floats(old.tangents, now.tangents, 4, edit);
    norma_document_mesh_info(was, mesh, &info);
    for (size_t t = 0; t < info.morph_targets; ++t) {
        norma_morph_data a, b;
        assert_int_equal(norma_document_morph_data(was, mesh, t, &a, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(norma_document_morph_data(is, mesh, t, &b, NULL), NORMA_DOCUMENT_OK);
        same_vectors(&a.positions, &b.positions, edit);
        same_vectors(&a.normals, &b.normals, edit);
        same_vectors(&a.tangents, &b.tangents, edit);
    }
}

static void try_vertices(const char *path) {
    uint32_t seed = 23;
    opened file = open_bytes(bytes_load(path), path);
    norma_mesh_edit *edits = calloc(file.meshes + 1, sizeof *edits);
    for (size_t m = 0; m < file.meshes; ++m)
        if (is_read(file.document, m)) {
            norma_mesh_data data = data_of(file.document, m);
            random_vertices(&data.mesh, &edits[m], &seed);
            if (data.normals.count && edits[m].vertex_count) random_normals(&edits[m], &seed);
            if (!edits[m].vertex_count || data.mesh.corner_count < 3) {
                free((void *)edits[m].source_vertices);
                free((void *)edits[m].new_corners);
                free((void *)edits[m].set_normals);
                free((void *)edits[m].normals);
                edits[m] = (norma_mesh_edit){0};
            }
        }
    document_bytes out = edited(file.bytes, path, edits);
    if (out.size) {
        opened now = open_bytes(out, path);
        for (size_t m = 0; m < file.meshes; ++m)
            if (edits[m].source_vertices)
                compare_vertices(file.document, now.document, m, &edits[m]);
        close_bytes(&now);
    }
    for (size_t m = 0; m < file.meshes; ++m) {
        free((void *)edits[m].source_vertices);
        free((void *)edits[m].new_corners);
    }
    free_edits(edits, file.meshes);
    close_bytes(&file);
}

/* ---- positions: moved by one place of its own */

static void one_position_is_moved(const char *path) {
    opened file = open_bytes(bytes_load(path), path);
    norma_mesh_data data = data_of(file.document, 0);
    size_t count = data.mesh.positions.count;
    norma_mesh_edit edit = {0};
    double *positions = calloc(3 * count, sizeof *positions);
    uint8_t *set = calloc(count, 1);
    positions[4] = 0.25;
    set[1] = 1;
    edit.positions = positions;
    edit.set_positions = set;
    document_bytes out = edited(file.bytes, path, &edit);
    opened now = open_bytes(out, path);
    norma_mesh_data after = data_of(now.document, 0);
    for (size_t c = 0; c < data.mesh.corner_count; ++c) {
        double a[3], b[3];
        position_at(&data.mesh, c, a);
        position_at(&after.mesh, c, b);
        if (corner_at(&data.mesh, c) == 1) a[0] = 0, a[1] = 0.25, a[2] = 0;
        assert_true(a[0] == b[0] && a[1] == b[1] && a[2] == b[2]);
    }
    free(positions);
    free(set);
    close_bytes(&now);
    close_bytes(&file);
}

static void assets_keep_all_else(void **state) {
    static const char *const paths[] = {"assets/box-rotated.obj", "assets/concave-66gon.obj",
        "assets/dodecahedron.obj", "assets/goathead.obj", "assets/spider.stl"};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(paths); ++i) {
        try_faces(paths[i], 0);
        try_faces(paths[i], 1);
        try_normals(paths[i]);
        one_position_is_moved(paths[i]);
    }
}

static size_t tried;

static int has_vertices(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot &&
           (strcmp(dot, ".gltf") == 0 || strcmp(dot, ".glb") == 0 || strcmp(dot, ".ply") == 0);
}

static void visit(const char *path, const char *name, const char *expect) {
    (void)name;
    if (strcmp(expect, "ok") != 0) return;
    document_bytes bytes = bytes_load(path);
    int small = bytes.size < 4000000 / SLOWER;
    int opens = small && bytes_try(bytes, path, NULL, NULL) == NORMA_DOCUMENT_OK;
    bytes_free(&bytes);
    if (!opens) return;
    try_faces(path, 0);
    try_faces(path, 1);
    try_normals(path);
    if (has_vertices(path)) try_vertices(path);
    ++tried;
}

static void data_set_keeps_all_else(void **state) {
    static const char *const formats[] = {"obj", "ply", "stl", "gltf", "glb"};
    (void)state;
    size_t files = 0;
    tried = 0;
    for (size_t i = 0; i < COUNT_OF(formats); ++i) files += data_for_each_format(formats[i], visit);
    if (files == 0) skip();
    assert_true(tried > 100);
}

static void marks_without_numbers_are_refused(void **state) {
    (void)state;
    opened file = open_bytes(bytes_load("assets/goathead.obj"), "assets/goathead.obj");
    const uint8_t *marks = calloc(1000000, 1);
    const norma_mesh_edit edit = {.set_normals = marks};
    norma_document_error error;
    assert_int_equal(
        norma_document_edit(file.document, &edit, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "marks without numbers"));
    assert_int_equal(
        norma_document_edit(file.document, NULL, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    free((void *)marks);
    close_bytes(&file);
}

/* ---- what a changed document gives out stays where it is until the next change */

typedef struct answers {
    norma_mesh_info info;
    norma_mesh_attributes attributes;
    norma_mesh_data data;
} answers;

/* The order in which each would free what was given out before it, if changes still waited. */
static answers ask(norma_document *document) {
    answers a;
    uint32_t *first;
    assert_int_equal(norma_document_mesh_info(document, 0, &a.info), NORMA_DOCUMENT_OK);
    assert_int_equal(
        norma_document_mesh_attributes(document, 0, &a.attributes, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, 0, &a.data, NULL), NORMA_DOCUMENT_OK);
    first = calloc(a.info.vertices + 1, sizeof *first);
    assert_non_null(first);
    if (norma_document_format(document) != NORMA_FILE_STL)
        assert_int_equal(
            norma_document_equal_vertices(document, 0, first, NULL), NORMA_DOCUMENT_OK);
    free(first);
    return a;
}

static void answers_stay(void **state) {
    (void)state;
    static const char *const texts[] = {
        "o name\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\ns 1\nf 1/1 2/1 3/1\n",
        ("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
         "property float s\nproperty float t\nelement face 1\n"
         "property list uchar int vertex_indices\nend_header\n"
         "1 0 0 0 0 1 0 0\n0 1 0 0 0 1 0 0\n0 0 1 0 0 1 0 0\n3 0 1 2\n"),
        ("solid name\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 0 1 0\n"
         "vertex 0 0 1\nendloop\nendfacet\nendsolid name\n")};
    static const char *const names[] = {"a.obj", "a.ply", "a.stl"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        norma_document *document;
        assert_int_equal(
            norma_document_open_memory(texts[i], strlen(texts[i]), names[i], NULL, &document, NULL),
            NORMA_DOCUMENT_OK);
        assert_int_equal(norma_document_compute(document, NULL, NULL, NULL), NORMA_DOCUMENT_OK);
        const answers a = ask(document);
        uint32_t *groups = (uint32_t *)(uintptr_t)a.data.mesh.smoothing_groups;
        if (groups) groups[0] = 77; /* made again, it would be another number */
        const answers b = ask(document);
        assert_true(!groups == (i > 0) && (!groups || b.data.mesh.smoothing_groups[0] == 77));
        assert_true(a.info.name == b.info.name &&
                    a.attributes.texcoords == b.attributes.texcoords &&
                    a.data.mesh.positions.data == b.data.mesh.positions.data &&
                    a.data.normals.data == b.data.normals.data);
        const double x = a.data.mesh.positions.format == NORMA_FORMAT_DOUBLE
                             ? *(const double *)a.data.mesh.positions.data
                             : (double)*(const float *)a.data.mesh.positions.data;
        assert_true(x == 1);
        norma_document_close(document);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(assets_keep_all_else),
        cmocka_unit_test(data_set_keeps_all_else),
        cmocka_unit_test(marks_without_numbers_are_refused),
        cmocka_unit_test(answers_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
