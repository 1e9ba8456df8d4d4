/* mesh_files.c: see mesh_files.h. */
#include "mesh_files.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- building */

static void *grown(void *block, size_t *room, size_t needed, size_t size) {
    if (needed <= *room) return block;
    *room = needed * 2 + 64;
    block = realloc(block, *room * size);
    if (!block) abort();
    return block;
}

void mesh_file_add_position(mesh_file *mesh, double x, double y, double z) {
    mesh->positions = grown(
        mesh->positions, &mesh->position_room, mesh->position_count + 1, sizeof *mesh->positions);
    mesh->positions[mesh->position_count][0] = x;
    mesh->positions[mesh->position_count][1] = y;
    mesh->positions[mesh->position_count][2] = z;
    ++mesh->position_count;
}

void mesh_file_add_face(mesh_file *mesh, const uint32_t *corners, size_t count) {
    mesh->corners =
        grown(mesh->corners, &mesh->corner_room, mesh->corner_count + count, sizeof *mesh->corners);
    mesh->starts =
        grown(mesh->starts, &mesh->face_room, mesh->face_count + 2, sizeof *mesh->starts);
    for (size_t i = 0; i < count; ++i) mesh->corners[mesh->corner_count + i] = corners[i];
    mesh->starts[mesh->face_count] = (uint32_t)mesh->corner_count;
    mesh->corner_count += count;
    mesh->starts[++mesh->face_count] = (uint32_t)mesh->corner_count;
}

void mesh_file_free(mesh_file *mesh) {
    free(mesh->positions);
    free(mesh->corners);
    free(mesh->starts);
    memset(mesh, 0, sizeof *mesh);
}

norma_mesh mesh_file_view_polygons(const mesh_file *mesh) {
    static const uint32_t none[1] = {0};
    return (norma_mesh){
        .positions = {mesh->positions, mesh->position_count, 0, NORMA_FORMAT_DOUBLE},
        .corners = mesh->corners ? mesh->corners : none,
        .corner_count = mesh->corner_count,
        .face_starts = mesh->starts ? mesh->starts : none,
        .face_count = mesh->face_count};
}

norma_mesh mesh_file_view(const mesh_file *mesh) {
    norma_mesh view = mesh_file_view_polygons(mesh);
    int triangles = mesh->face_count > 0;
    for (size_t f = 0; f <= mesh->face_count && triangles; ++f)
        triangles = mesh->starts[f] == 3 * f;
    if (triangles) view.face_starts = NULL;
    if (triangles) view.face_count = 0;
    return view;
}

norma_mesh mesh_file_view_float(const mesh_file *mesh, float *floats) {
    norma_mesh view = mesh_file_view(mesh);
    for (size_t i = 0; i < mesh->position_count; ++i)
        for (size_t x = 0; x < 3; ++x) floats[3 * i + x] = (float)mesh->positions[i][x];
    view.positions = (norma_vec3_view){floats, mesh->position_count, 0, NORMA_FORMAT_FLOAT};
    return view;
}

/* ---- OBJ */

static int load_obj_face(mesh_file *mesh, const char *text) {
    uint32_t corners[2000];
    size_t count = 0;
    for (;;) {
        char *end;
        const long n = strtol(text, &end, 10);
        if (end == text) break;
        const long index = n < 0 ? (long)mesh->position_count + n : n - 1;
        if (index < 0 || index >= (long)mesh->position_count ||
            count == sizeof corners / sizeof *corners)
            return -1;
        corners[count++] = (uint32_t)index;
        text = end + strcspn(end, " \t\r\n");
    }
    if (count > 2) mesh_file_add_face(mesh, corners, count);
    return 0;
}

/* Positions may come after the faces that name them: two passes. */
static int load_obj(mesh_file *mesh, char *text) {
    for (char *p = text; (p = strstr(p, "\\\n")); p += 2) memset(p, ' ', 2);
    for (char *p = text; (p = strstr(p, "\\\r\n")); p += 3) memset(p, ' ', 3);
    for (int pass = 0; pass < 2; ++pass)
        for (char *line = text; *line;
             line += strcspn(line, "\r\n"), line += strspn(line, "\r\n")) {
            line += strspn(line, " \t");
            if (pass == 0 && line[0] == 'v' && (line[1] == ' ' || line[1] == '\t')) {
                char *at = line + 1;
                const double x = strtod(at, &at), y = strtod(at, &at), z = strtod(at, &at);
                mesh_file_add_position(mesh, x, y, z);
            }
            if (pass == 1 && line[0] == 'f' && (line[1] == ' ' || line[1] == '\t') &&
                load_obj_face(mesh, line + 1))
                return -1;
        }
    return 0;
}

/* ---- PLY */

typedef enum ply_type {
    PLY_I8,
    PLY_U8,
    PLY_I16,
    PLY_U16,
    PLY_I32,
    PLY_U32,
    PLY_F32,
    PLY_F64,
    PLY_NO_TYPE
} ply_type;
typedef struct ply_property {
    char name[64];
    ply_type list, type; /* list: PLY_NO_TYPE unless it is one */
} ply_property;
typedef struct ply_element {
    char name[64];
    unsigned long count;
    ply_property properties[64];
    size_t property_count;
} ply_element;
typedef struct ply_reader {
    const unsigned char *at, *end;
    int ascii, big;
    int failed;
} ply_reader;

static ply_type ply_type_of(const char *name) {
    static const char *const names[][2] = {{"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},
        {"ushort", "uint16"}, {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"},
        {"double", "float64"}};
    for (int i = 0; i < 8; ++i)
        if (!strcmp(name, names[i][0]) || !strcmp(name, names[i][1])) return (ply_type)i;
    return PLY_NO_TYPE;
}

static double ply_number(ply_reader *r, ply_type type) {
    static const size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    unsigned char bytes[8] = {0};
    union {
        int8_t i8;
        uint8_t u8;
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        float f32;
        double f64;
    } v;
    if (r->ascii) {
        char *end;
        const double x = strtod((const char *)r->at, &end);
        if ((const unsigned char *)end == r->at) r->failed = 1;
        r->at = (const unsigned char *)end;
        return x;
    }
    if ((size_t)(r->end - r->at) < sizes[type]) {
        r->failed = 1;
        return 0;
    }
    for (size_t i = 0; i < sizes[type]; ++i) bytes[i] = r->at[r->big ? sizes[type] - 1 - i : i];
    r->at += sizes[type];
    memcpy(&v, bytes, sizeof v);
    switch (type) {
    case PLY_I8:
        return v.i8;
    case PLY_U8:
        return v.u8;
    case PLY_I16:
        return v.i16;
    case PLY_U16:
        return v.u16;
    case PLY_I32:
        return v.i32;
    case PLY_U32:
        return v.u32;
    case PLY_F32:
        return (double)v.f32;
    default:
        return v.f64;
    }
}

static void ply_list(ply_reader *r, const ply_property *p, mesh_file *mesh) {
    uint32_t corners[2000];
    const double count = ply_number(r, p->list);
    const int wanted =
        mesh && (!strcmp(p->name, "vertex_indices") || !strcmp(p->name, "vertex_index"));
    if (!(count >= 0 && count <= 2000)) r->failed = 1;
    for (size_t i = 0; !r->failed && i < (size_t)count; ++i) {
        const double n = ply_number(r, p->type);
        if (wanted && !(n >= 0 && n < (double)mesh->position_count))
            r->failed = 1;
        else
            corners[i] = wanted ? (uint32_t)n : 0;
    }
    if (!r->failed && wanted && count > 2) mesh_file_add_face(mesh, corners, (size_t)count);
}

static void ply_body(ply_reader *r, const ply_element *e, mesh_file *mesh) {
    const int vertex = !strcmp(e->name, "vertex"), face = !strcmp(e->name, "face");
    for (unsigned long i = 0; i < e->count && !r->failed; ++i) {
        double p[3] = {0, 0, 0};
        for (size_t j = 0; j < e->property_count && !r->failed; ++j) {
            const ply_property *property = &e->properties[j];
            if (property->list != PLY_NO_TYPE) {
                ply_list(r, property, face ? mesh : NULL);
                continue;
            }
            const double x = ply_number(r, property->type);
            if (strlen(property->name) == 1 && property->name[0] >= 'x' && property->name[0] <= 'z')
                p[property->name[0] - 'x'] = x;
        }
        if (vertex && !r->failed) mesh_file_add_position(mesh, p[0], p[1], p[2]);
    }
}

/* One header line; -1 at nonsense, 1 at its end. */
static int ply_header_line(const char *line, ply_reader *r, ply_element *elements, size_t *count) {
    char a[64], b[64], name[64];
    unsigned long n;
    if (!strcmp(line, "end_header")) return 1;
    if (sscanf(line, "format %63s", a) == 1) {
        r->ascii = !strcmp(a, "ascii");
        r->big = !strcmp(a, "binary_big_endian");
    } else if (sscanf(line, "element %63s %lu", name, &n) == 2) {
        if (*count == 8) return -1;
        memset(&elements[*count], 0, sizeof *elements);
        strcpy(elements[*count].name, name);
        elements[(*count)++].count = n;
    } else if (!strncmp(line, "property", 8)) {
        ply_element *e = *count ? &elements[*count - 1] : NULL;
        ply_property *p = e && e->property_count < 64 ? &e->properties[e->property_count++] : NULL;
        if (!p) return -1;
        p->list = PLY_NO_TYPE;
        if (sscanf(line, "property list %63s %63s %63s", a, b, name) == 3)
            p->list = ply_type_of(a);
        else if (sscanf(line, "property %63s %63s", b, name) != 2)
            return -1;
        strcpy(p->name, name);
        p->type = ply_type_of(b);
        if (p->type == PLY_NO_TYPE) return -1;
    }
    return 0;
}

static int load_ply(mesh_file *mesh, const char *text, size_t size) {
    static ply_element elements[8];
    ply_reader r = {(const unsigned char *)text, (const unsigned char *)text + size, 0, 0, 0};
    size_t count = 0;
    int state = 0;
    if (strncmp(text, "ply", 3)) return -1;
    while (state == 0 && r.at < r.end) {
        char line[512];
        const size_t length = strcspn((const char *)r.at, "\r\n");
        if (length >= sizeof line) return -1;
        memcpy(line, r.at, length);
        line[length] = 0;
        r.at += length;
        r.at += r.at[0] == '\r' && r.at[1] == '\n' && strstr(text, "\r\nformat") ? 2 : 1;
        state = ply_header_line(line, &r, elements, &count);
    }
    if (state != 1) return -1;
    for (size_t i = 0; i < count; ++i) ply_body(&r, &elements[i], mesh);
    return r.failed ? -1 : 0;
}

/* ---- STL */

static int load_stl(mesh_file *mesh, const char *text, size_t size) {
    uint32_t facets = 0;
    if (size >= 84) memcpy(&facets, text + 80, 4);
    if (size >= 84 && size == 84 + 50 * (size_t)facets) {
        for (size_t i = 0; i < 3 * (size_t)facets; ++i) {
            float p[3];
            memcpy(p, text + 84 + 50 * (i / 3) + 12 + 12 * (i % 3), sizeof p);
            mesh_file_add_position(mesh, (double)p[0], (double)p[1], (double)p[2]);
        }
    } else {
        if (strncmp(text, "solid", 5)) return -1;
        for (const char *p = text; (p = strstr(p, "vertex")); p += 6) {
            char *at = (char *)(size_t)(p + 6);
            const double x = strtod(at, &at), y = strtod(at, &at), z = strtod(at, &at);
            mesh_file_add_position(mesh, x, y, z);
        }
        if (mesh->position_count % 3) return -1;
    }
    for (uint32_t i = 0; i < mesh->position_count; i += 3)
        mesh_file_add_face(mesh, (uint32_t[]){i, i + 1, i + 2}, 3);
    return 0;
}

/* ---- files */

static char *read_whole(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    if (!file) return NULL;
    if (!fseek(file, 0, SEEK_END)) {
        const long end = ftell(file);
        rewind(file);
        text = end >= 0 ? calloc((size_t)end + 2, 1) : NULL;
        if (text && fread(text, 1, (size_t)end, file) != (size_t)end) {
            free(text);
            text = NULL;
        }
        *size = (size_t)end;
    }
    fclose(file);
    return text;
}

int mesh_file_load(const char *path, mesh_file *mesh) {
    const char *dot = strrchr(path, '.');
    size_t size = 0;
    int result = -1;
    memset(mesh, 0, sizeof *mesh);
    char *text = dot ? read_whole(path, &size) : NULL;
    if (!text) return -1;
    if (!strcmp(dot, ".obj")) result = load_obj(mesh, text);
    if (!strcmp(dot, ".ply")) result = load_ply(mesh, text, size);
    if (!strcmp(dot, ".stl")) result = load_stl(mesh, text, size);
    free(text);
    if (result) mesh_file_free(mesh);
    return result;
}

static int is_there(const char *path) {
    FILE *file = fopen(path, "rb");
    if (file) fclose(file);
    return file != NULL;
}

const char *data_folder(void) {
    static const char *const places[] = {
        "../shared/data",
        "../../shared/data",
        "../../../shared/data",
#ifdef NORMA_SOURCE_DIR
        NORMA_SOURCE_DIR "/../shared/data",
#endif
    };
    const char *given = getenv("NORMA_DATA");
    char path[1024];
    if (given && *given) {
        snprintf(path, sizeof path, "%s/INDEX.tsv", given);
        return is_there(path) ? given : NULL;
    }
    for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
        snprintf(path, sizeof path, "%s/INDEX.tsv", places[i]);
        if (is_there(path)) return places[i];
    }
    return NULL;
}

const char *assets_folder(void) {
#ifdef NORMA_SOURCE_DIR
    return NORMA_SOURCE_DIR "/assets";
#else
    return "assets";
#endif
}

size_t data_for_each(
    const char *folder, void (*visit)(void *user, const char *path, const char *name), void *user) {
    char path[1024], name[600];
    size_t size, count = 0;
    snprintf(path, sizeof path, "%s/INDEX.tsv", folder);
    char *index = read_whole(path, &size);
    if (!index) return 0;
    const char *line = index + strcspn(index, "\n");
    while (*line == '\n' && line[1]) {
        const size_t length = strcspn(++line, "\t\n");
        if (length < sizeof name) {
            memcpy(name, line, length);
            name[length] = 0;
            snprintf(path, sizeof path, "%.400s/%s", folder, name);
            visit(user, path, name);
            ++count;
        }
        line += strcspn(line, "\n");
    }
    free(index);
    return count;
}
