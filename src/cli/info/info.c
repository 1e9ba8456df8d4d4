/* norma info: what is in a file: meshes, counts, normals, the kinds of the transforms. */
#include "cli/files/files.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct info_bounds {
    int known; /* 0: no finite position, or too many instances to look at each vertex of each */
    double least[3], most[3];
} info_bounds;

/* One primitive, or a whole OBJ, PLY or STL. */
typedef struct mesh_part {
    norma_mesh_info info;
    int closed;                /* with --deep: 1 closed, 0 open; -1: not known */
    norma_deviation explained; /* with --deep; no corners: there are no normals to explain */
    norma_tangent_deviation tangents;
} mesh_part;

typedef struct contents {
    const char *path;
    size_t tile; /* of a composite with several models; SIZE_MAX: of anything else */
    norma_file_format format;
    const norma_document *document; /* NULL: a file that does not fit into memory */
    mesh_part *parts;
    size_t part_count, vertices, faces, triangles;
    norma_node_info *nodes;
    size_t node_count, skin_count;
    info_bounds bounds;
} contents;

/* ---- meshes: the primitives of one glTF mesh follow each other */

static size_t mesh_end(const contents *found, size_t first) {
    size_t end = first + 1;
    while (end < found->part_count && found->parts[end].info.mesh == found->parts[first].info.mesh)
        ++end;
    return end;
}

static const char *const storage_names[] = {"none", "vertex", "corner", "facet"};

/* What a mesh has is what every part of it with faces has. */
static norma_normal_storage storage_of(
    const contents *found, size_t first, size_t end, const char **encoding) {
    norma_normal_storage storage = NORMA_NORMALS_NONE;
    *encoding = "";
    for (size_t i = first; i < end; ++i) {
        const norma_mesh_info *info = &found->parts[i].info;
        if (info->faces == 0 && end - first > 1) continue;
        if (info->normals == NORMA_NORMALS_NONE) {
            *encoding = "";
            return NORMA_NORMALS_NONE;
        }
        storage = info->normals;
        *encoding =
            **encoding == '\0' || strcmp(*encoding, info->encoding) == 0 ? info->encoding : "mixed";
    }
    return storage;
}

static void kind_of(const norma_node_info *node, norma_matrix_info *matrix) {
    double normal_matrix[9];
    *matrix = (norma_matrix_info){.kind = NORMA_KIND_SINGULAR, .anisotropy = INFINITY};
    norma_normal_matrix_double(node->world, NORMA_WINDING_REVERSED, normal_matrix, matrix);
}

/* ---- for programs */

/* Ends the object that is open. */
static void write_off(cli_json *json, double p50, double p99, double most) {
    cli_json_print(json, "p50_deg: %g, p99_deg: %g, max_deg: %g}", cli_to_degrees(p50),
        cli_to_degrees(p99), cli_to_degrees(most));
}

/* Whole degrees went in; they come out so. NaN: smooth. */
static double crease_in_degrees(const norma_deviation *explained) {
    return rint(cli_to_degrees(explained->crease_angle_rad) * 1e6) / 1e6;
}

static void write_explained(cli_json *json, const norma_deviation *explained) {
    const int is_flat = explained->shading == NORMA_SHADING_FLAT;
    const double crease = crease_in_degrees(explained);
    cli_json_print(json, "explained_by: {shading: %s, weight: %s, crease_deg: %g",
        is_flat         ? "flat"
        : isnan(crease) ? "smooth"
                        : "crease",
        is_flat ? NULL : norma_weight_name(explained->weight), is_flat ? NAN : crease);
    write_off(json, explained->p50_rad, explained->p99_rad, explained->max_rad);
}

static const char *way_word(norma_tangent_source source) {
    static const char *const words[] = {
        [NORMA_TANGENTS_BY_MIKK] = "mikktspace-triangles",
        [NORMA_TANGENTS_BY_MIKK_ON_QUADS] = "mikktspace-quads",
        [NORMA_TANGENTS_BY_VERTEX_SUMS] = "vertex-sums",
        [NORMA_TANGENTS_BY_MESHOPT] = "meshoptimizer",
        [NORMA_TANGENTS_BY_STEADY] = "steady",
    };
    return words[source];
}

/* Under the tangents that a renderer makes in this way. */
static void write_map_error(
    cli_json *json, norma_tangent_source renderer, const norma_map_error *error) {
    cli_json_open(json, way_word(renderer), '{');
    write_off(json, error->p50_rad, error->p99_rad, error->max_rad);
}

static void write_explained_tangents(cli_json *json, const norma_tangent_deviation *explained) {
    cli_json_print(json,
        "tangents_explained_by: {way: %s, texture_transform: %d, sign: %s, signs_other: %zu, "
        "corners: %zu, explained: %zu, p50_deg: %g, p99_deg: %g, max_deg: %g, map_error: {",
        way_word(explained->source), explained->transformed,
        explained->negated ? "negated" : "as-is", explained->signs_other, explained->corners,
        explained->explained, cli_to_degrees(explained->p50_rad),
        cli_to_degrees(explained->p99_rad), cli_to_degrees(explained->max_rad));
    write_map_error(json, NORMA_TANGENTS_BY_MIKK, &explained->under_mikk);
    write_map_error(json, NORMA_TANGENTS_BY_MESHOPT, &explained->under_meshopt);
    write_map_error(json, NORMA_TANGENTS_BY_VERTEX_SUMS, &explained->under_vertex_sums);
    cli_json_print(json, "}}");
}

static void write_info_part(cli_json *json, const mesh_part *part) {
    const norma_mesh_info *info = &part->info;
    cli_json_print(json,
        "{where: %s, vertices: %zu, faces: %zu, triangles: %zu, normals: %s, encoding: %s, "
        "tangents: %d, smoothing_groups: %d, morph_targets: %zu, compression: %s, not_read: %s",
        info->where, info->vertices, info->faces, info->triangles, storage_names[info->normals],
        info->encoding, info->has_tangents, info->has_smoothing_groups, info->morph_targets,
        info->compression, info->not_read);
    if (part->closed >= 0) cli_json_bool(json, "closed", part->closed);
    if (part->explained.corners) write_explained(json, &part->explained);
    if (part->tangents.corners) write_explained_tangents(json, &part->tangents);
    cli_json_close(json, '}');
}

static void write_mesh(cli_json *json, const contents *found, size_t first, size_t end) {
    size_t vertices = 0, faces = 0;
    const char *encoding;
    norma_normal_storage storage = storage_of(found, first, end, &encoding);
    for (size_t i = first; i < end; ++i) {
        vertices += found->parts[i].info.vertices;
        faces += found->parts[i].info.faces;
    }
    cli_json_print(json,
        "{name: %s, vertices: %zu, faces: %zu, normals: %s, encoding: %s, primitives: [",
        found->parts[first].info.name, vertices, faces, storage_names[storage], encoding);
    for (size_t i = first; i < end; ++i) write_info_part(json, &found->parts[i]);
    cli_json_print(json, "]}");
}

static void write_nodes(cli_json *json, const contents *found) {
    norma_matrix_info matrix;
    cli_json_open(json, "nodes", '[');
    for (size_t i = 0; i < found->node_count; ++i) {
        const norma_node_info *node = &found->nodes[i];
        kind_of(node, &matrix);
        cli_json_print(json,
            "{name: %s, kind: %s, mirrored: %d, anisotropy: %g, node: %zu, mesh: %zu, "
            "instances: %zu}",
            node->name, cli_kind_name(matrix.kind), matrix.mirrored, matrix.anisotropy, node->node,
            node->mesh, node->instances);
    }
    cli_json_close(json, ']');
}

static void write_bounds(cli_json *json, const info_bounds *bounds) {
    const double *least = bounds->least, *most = bounds->most;
    if (bounds->known)
        cli_json_print(json, "bounds: [[%g, %g, %g], [%g, %g, %g]]", least[0], least[1], least[2],
            most[0], most[1], most[2]);
    else
        cli_json_null(json, "bounds");
}

static void write_model(cli_json *json, const contents *found) {
    cli_json_string(json, "format", norma_file_format_name(found->format));
    write_bounds(json, &found->bounds);
    cli_json_print(json, "vertices: %zu, faces: %zu, triangles: %zu, skins: %zu, meshes: [",
        found->vertices, found->faces, found->triangles, found->skin_count);
    for (size_t first = 0; first < found->part_count; first = mesh_end(found, first))
        write_mesh(json, found, first, mesh_end(found, first));
    cli_json_close(json, ']');
    write_nodes(json, found);
    cli_json_notes(json, found->document);
}

/* One object: of a composite's models, where they are several, an array in it. */
static void info_write_json(const contents *found, size_t count) {
    cli_json json = {.out = stdout};
    cli_json_print(&json, "{path: %s", found->path);
    if (count == 1) {
        write_model(&json, found);
    } else {
        cli_json_print(&json, "format: %s, tiles: [", norma_file_format_name(found->format));
        for (size_t i = 0; i < count; ++i) {
            cli_json_open(&json, NULL, '{');
            write_model(&json, &found[i]);
            cli_json_close(&json, '}');
        }
        cli_json_close(&json, ']');
    }
    cli_json_print(&json, "}\n");
}

static void info_write_failure(const char *path, const norma_document_error *error) {
    cli_json json = {.out = stdout};
    cli_json_print(&json, "{path: %s, error: %s}\n", path, error->message);
}

/* ---- for people */

static void print_name(const char *name) {
    if (!name[0]) return;
    fputs(" \"", stdout);
    cli_write_outside(stdout, name);
    fputc('"', stdout);
}

static void print_off(double p50_rad, double p99_rad, double max_rad) {
    char p50[32], p99[32], most[32];
    printf(": off by %s\302\260 at p50, %s\302\260 at p99, %s\302\260 at most",
        cli_decimals(p50, cli_to_degrees(p50_rad), 3),
        cli_decimals(p99, cli_to_degrees(p99_rad), 3),
        cli_decimals(most, cli_to_degrees(max_rad), 3));
}

static void print_explained(const norma_deviation *explained) {
    char text[32];
    const double crease = crease_in_degrees(explained);
    fputs("      stored normals are best explained by ", stdout);
    if (explained->shading == NORMA_SHADING_FLAT)
        fputs("flat shading", stdout);
    else if (isnan(crease))
        printf("%s weights, smooth", norma_weight_name(explained->weight));
    else
        printf("%s weights, crease %s\302\260", norma_weight_name(explained->weight),
            cli_decimals(text, crease, 3));
    print_off(explained->p50_rad, explained->p99_rad, explained->max_rad);
    putchar('\n');
}

static void print_map_error(norma_tangent_source renderer, const norma_map_error *error) {
    printf("      a normal map baked for these, if a renderer makes tangents by %s",
        norma_tangent_source_name(renderer));
    print_off(error->p50_rad, error->p99_rad, error->max_rad);
    putchar('\n');
}

static void print_explained_tangents(const norma_tangent_deviation *explained) {
    printf("      stored tangents are best explained by %s%s, sign %s",
        norma_tangent_source_name(explained->source),
        explained->transformed ? " through the texture transform" : "",
        explained->negated ? "negated" : "as it is");
    print_off(explained->p50_rad, explained->p99_rad, explained->max_rad);
    fputs("; ", stdout);
    cli_count(stdout, explained->explained);
    fputs(" of ", stdout);
    cli_counted(stdout, explained->corners, "corner", "corners");
    fputs(" explained\n", stdout);
    print_map_error(NORMA_TANGENTS_BY_MIKK, &explained->under_mikk);
    print_map_error(NORMA_TANGENTS_BY_MESHOPT, &explained->under_meshopt);
    print_map_error(NORMA_TANGENTS_BY_VERTEX_SUMS, &explained->under_vertex_sums);
}

static void print_part(const mesh_part *part) {
    const norma_mesh_info *info = &part->info;
    cli_counted(stdout, info->vertices, "vertex", "vertices");
    fputs(", ", stdout);
    cli_counted(stdout, info->faces, "face", "faces");
    if (info->triangles != info->faces) {
        fputs(" (", stdout);
        cli_counted(stdout, info->triangles, "triangle", "triangles");
        fputs(")", stdout);
    }
    if (info->normals == NORMA_NORMALS_NONE)
        fputs(", no normals", stdout);
    else
        printf(", normals per %s (%s)", storage_names[info->normals], info->encoding);
    fputs(info->has_tangents ? ", tangents" : "", stdout);
    fputs(info->has_smoothing_groups ? ", smoothing groups" : "", stdout);
    cli_part(stdout, ", ", info->morph_targets, "morph target", "morph targets");
    if (info->compression) printf(", compressed with %s", info->compression);
    if (part->closed >= 0) fputs(part->closed ? ", closed" : ", open", stdout);
    fputs("\n", stdout);
    if (info->not_read) {
        cli_say(stdout, "      cannot be computed or transformed: %s", info->not_read);
        fputs("\n", stdout);
    }
    if (part->explained.corners) print_explained(&part->explained);
    if (part->tangents.corners) print_explained_tangents(&part->tangents);
}

/* Of a glTF file. */
static void print_mesh(const contents *found, size_t first, size_t end) {
    const norma_mesh_info *info = &found->parts[first].info;
    for (size_t i = first; i < end; ++i) {
        printf("  mesh %zu", info->mesh);
        print_name(info->name);
        if (end - first > 1) printf(" primitive %zu", found->parts[i].info.primitive);
        fputs(": ", stdout);
        print_part(&found->parts[i]);
    }
}

static void print_nodes(const contents *found) {
    norma_matrix_info matrix;
    for (size_t i = 0; i < found->node_count; ++i) {
        const norma_node_info *node = &found->nodes[i];
        kind_of(node, &matrix);
        printf("  node %zu", node->node);
        print_name(node->name);
        printf(" draws mesh %zu", node->mesh);
        if (node->instances != 1) {
            fputs(" in ", stdout);
            cli_counted(stdout, node->instances, "instance", "instances");
        }
        printf(": %s", cli_kind_name(matrix.kind));
        if (!isfinite(matrix.anisotropy))
            fputs(", flattened", stdout);
        else if (matrix.kind == NORMA_KIND_NON_UNIFORM_SCALE || matrix.kind == NORMA_KIND_SHEAR)
            printf(", anisotropy %.4g", matrix.anisotropy);
        fputs(matrix.mirrored ? ", mirrored\n" : "\n", stdout);
    }
}

static void print_bounds(const info_bounds *bounds) {
    char from[3][32], to[3][32];
    if (!bounds->known) return;
    for (int axis = 0; axis < 3; ++axis) {
        snprintf(from[axis], sizeof from[axis], "%.6g", bounds->least[axis] + 0.0);
        snprintf(to[axis], sizeof to[axis], "%.6g", bounds->most[axis] + 0.0);
    }
    printf("  from (%s, %s, %s) to (%s, %s, %s)\n", from[0], from[1], from[2], to[0], to[1], to[2]);
}

static void info_print(const contents *found) {
    size_t meshes = 0;
    cli_say(stdout, "%s: ", cli_input_name(found->path));
    if (found->tile != SIZE_MAX) printf("tile %zu: ", found->tile);
    fputs(norma_file_format_name(found->format), stdout);
    if (found->part_count == 1 && !found->parts[0].info.where[0]) {
        print_name(found->parts[0].info.name);
        fputs(", ", stdout);
        print_part(&found->parts[0]);
        print_bounds(&found->bounds);
        return;
    }
    for (size_t first = 0; first < found->part_count; first = mesh_end(found, first)) ++meshes;
    fputs(", ", stdout);
    cli_counted(stdout, meshes, "mesh", "meshes");
    fputs(", ", stdout);
    cli_counted(stdout, found->vertices, "vertex", "vertices");
    fputs(", ", stdout);
    cli_counted(stdout, found->faces, "face", "faces");
    cli_part(stdout, ", ", found->skin_count, "skin", "skins");
    fputs("\n", stdout);
    print_bounds(&found->bounds);
    for (size_t first = 0; first < found->part_count; first = mesh_end(found, first))
        print_mesh(found, first, mesh_end(found, first));
    print_nodes(found);
}

/* ---- The box that a file's surfaces fill, vertex by vertex, so that it is exact under any
 * transform. */

/* A file of a few kilobytes can ask for millions of instances. */
static const size_t most_visits = (size_t)1 << 26;

static void include(info_bounds *bounds, const double p[3]) {
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2])) return;
    for (int axis = 0; axis < 3; ++axis) {
        if (!bounds->known || p[axis] < bounds->least[axis]) bounds->least[axis] = p[axis];
        if (!bounds->known || p[axis] > bounds->most[axis]) bounds->most[axis] = p[axis];
    }
    bounds->known = 1;
}

/* world: column-major. In pieces, so that a large mesh takes little memory. */
static void include_mesh(info_bounds *bounds, const norma_vec3_view *view, const double world[16]) {
    enum { PIECE = 256 };
    double points[PIECE][3];
    for (size_t first = 0; first < view->count; first += PIECE) {
        const size_t count = view->count - first < PIECE ? view->count - first : PIECE;
        const norma_vec3_view piece = {points, count, 0, NORMA_FORMAT_DOUBLE};
        for (size_t i = 0; i < count; ++i) norma_view_vector(view, first + i, points[i]);
        if (norma_transform_positions_double(world, piece, points[0], 0, count)) return;
        for (size_t i = 0; i < count; ++i) include(bounds, points[i]);
    }
}

/* The primitives of a mesh under one node, each of its instances; index SIZE_MAX: as they are
 * stored. *visits: vertices looked at. */
static norma_document_result include_node(norma_document *document, size_t index,
    const norma_node_info *node, info_bounds *bounds, size_t *visits, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    const size_t end = node->first_mesh + node->mesh_count;
    for (size_t i = node->first_mesh; i < end && !result; ++i) {
        norma_mesh_info info;
        norma_mesh_data data;
        result = norma_document_mesh_info(document, i, &info);
        if (result || info.not_read) continue;
        if (index != SIZE_MAX && info.vertices &&
            node->instances > (most_visits - *visits) / info.vertices) {
            *visits = most_visits;
            return NORMA_DOCUMENT_OK;
        }
        *visits += node->instances * info.vertices;
        result = norma_document_mesh_data(document, i, &data, error);
        for (size_t k = 0; k < node->instances && !result; ++k) {
            double world[16];
            memcpy(world, cli_matrix_identity.matrix, sizeof world);
            if (index != SIZE_MAX)
                result = norma_document_instance_world(document, index, k, world, error);
            if (!result) include_mesh(bounds, &data.mesh.positions, world);
        }
    }
    return result;
}

/* Of the positions as they are drawn: of a glTF under the world matrices of the nodes, each
 * instance; without such nodes, and in other formats, as stored. Skins and morphs are left out. */
static norma_document_result info_find_bounds(
    norma_document *document, info_bounds *bounds, norma_document_error *error) {
    const size_t nodes = norma_document_node_count(document);
    size_t visits = 0;
    norma_document_result result = NORMA_DOCUMENT_OK;
    *bounds = (info_bounds){0};
    if (nodes == 0) {
        const norma_node_info all = {
            .instances = 1, .mesh_count = norma_document_mesh_count(document)};
        return include_node(document, SIZE_MAX, &all, bounds, &visits, error);
    }
    for (size_t i = 0; i < nodes && !result && visits < most_visits; ++i) {
        norma_node_info node;
        result = norma_document_node_info(document, i, &node);
        /* Looking at primitives counts as well: thousands of nodes may draw one of thousands. */
        visits = node.mesh_count < most_visits - visits ? visits + node.mesh_count : most_visits;
        if (!result) result = include_node(document, i, &node, bounds, &visits, error);
    }
    if (visits >= most_visits) bounds->known = 0;
    return result;
}

/* ---- Which weight and crease explain the normals of a document's mesh, and
 * which way its tangents, in degrees. */

static norma_document_result fail_search(
    norma_document_error *error, const char *what, norma_result result) {
    error->result =
        result == NORMA_ERROR_MEMORY ? NORMA_DOCUMENT_ERROR_MEMORY : NORMA_DOCUMENT_ERROR_MALFORMED;
    snprintf(error->message, sizeof error->message, "stored %s cannot be explained: %s", what,
        norma_result_text(result));
    return error->result;
}

static norma_document_result explain_part(norma_document *document, size_t mesh, uint32_t threads,
    mesh_part *part, norma_document_error *error) {
    norma_mesh_info info;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_result failed = NORMA_OK;
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    norma_document_result result = norma_document_mesh_info(document, mesh, &info);
    const int has_normals = !result && info.normals != NORMA_NORMALS_NONE;
    if (result || info.not_read || !info.faces || (!has_normals && !info.has_tangents))
        return result;
    result = norma_document_mesh_data(document, mesh, &data, error);
    if (!result && has_normals)
        failed = norma_explain_normals(&data, info.normals, &options, &part->explained);
    if (failed) return fail_search(error, "normals", failed);
    if (result || !info.has_tangents) return result;
    result = norma_document_mesh_attributes(document, mesh, &attributes, error);
    if (!result) failed = norma_explain_tangents(&data, &attributes, &options, &part->tangents);
    return failed ? fail_search(error, "tangents", failed) : result;
}

/* ---- What is in a file that does not fit into memory: counted piece by piece. */

static norma_document_result info_describe_large(const char *path, norma_file_format *format,
    cli_progress *progress, norma_mesh_info *info, info_bounds *bounds,
    norma_document_error *error) {
    const norma_large_options options = {
        .struct_size = sizeof options, .max_memory = cli_memory_for_data(), .format = *format};
    norma_large_description found;
    const norma_document_result result =
        norma_large_describe(path, &options, cli_progress_report, progress, &found, error);
    if (result) return result;
    *format = found.format;
    *info = (norma_mesh_info){.name = "",
        .where = "",
        .vertices = found.vertices,
        .faces = found.faces,
        .triangles = found.triangles,
        .normals = found.normals,
        .encoding = found.encoding};
    bounds->known = found.has_bounds;
    memcpy(bounds->least, found.least, sizeof bounds->least);
    memcpy(bounds->most, found.most, sizeof bounds->most);
    return NORMA_DOCUMENT_OK;
}

/* ---- the files */

static const char info_help[] =
    "norma info IN...: lists what is in a file: meshes, counts, normals and transforms\n"
    "\n"
    "Examples\n"
    "  norma info chair.glb\n"
    "  norma info *.obj --json                    one object per line\n"
    "  norma info chair.glb --deep                also names the weight and crease of the stored "
    "normals\n"
    "  cat a.stl | norma info - --input-format stl\n"
    "\n"
    "Options\n"
    "  --deep                reads the whole file, and reports whether meshes are closed, which "
    "weight\n"
    "                        and crease explain the stored normals, and how stored tangents were "
    "made\n" CLI_INPUT_FORMAT_HELP
    "  --threads N           uses at most N threads (all processors)\n"
    "  --max-memory SIZE     uses at most SIZE (512M, 2G). A larger binary PLY or STL is\n"
    "                        read in parts; other files that need more fail\n"
    "  --json                prints JSON to standard output\n"
    "  --quiet               prints no notes\n"
    "\n"
    "In a glTF, each primitive is counted once, not once per instance. The kind of a node's "
    "transform is\n"
    "that of its world matrix.\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read, 130 interrupted.\n";

typedef struct info_work {
    cli_common common;
    cli_files files;
    int deep;
} info_work;

static const cli_option info_options[] = {{"deep", CLI_SETS(info_work, deep, 1)}};

/* N304 names the components that are open, or that cannot be turned to one side. */
static norma_document_result find_open_parts(
    const info_work *work, norma_document *document, contents *found, norma_document_error *error) {
    uint8_t rules[128] = {0};
    char unknown[64];
    norma_findings *findings = NULL;
    const norma_check_options checking = {.struct_size = sizeof checking,
        .profile = NORMA_CHECK_PROFILE_PRINT,
        .max_samples = 1,
        .rules = rules,
        .threads = work->common.threads};
    norma_rules_select("N304", rules, unknown);
    const norma_document_result result =
        norma_check_document(document, &checking, &findings, error);
    for (size_t i = 0; i < found->part_count && !result; ++i) {
        const norma_mesh_info *info = &found->parts[i].info;
        found->parts[i].closed = info->faces && !info->not_read ? 1 : -1;
        for (size_t k = 0; k < norma_findings_count(findings); ++k)
            if (strcmp(norma_findings_get(findings, k)->where, info->where) == 0)
                found->parts[i].closed = 0;
    }
    norma_findings_free(findings);
    return result;
}

static norma_document_result read_contents(const info_work *work, int whole,
    norma_document *document, contents *found, norma_document_error *error) {
    found->document = document;
    found->format = norma_document_format(document);
    found->part_count = norma_document_mesh_count(document);
    found->parts = calloc(found->part_count + 1, sizeof *found->parts);
    norma_document_result result = found->parts ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_MEMORY;
    for (size_t i = 0; i < found->part_count && !result; ++i) {
        mesh_part *part = &found->parts[i];
        part->closed = -1;
        if (work->deep) result = explain_part(document, i, work->common.threads, part, error);
        if (!result) result = norma_document_mesh_info(document, i, &part->info);
        found->vertices += part->info.vertices;
        found->faces += part->info.faces;
        found->triangles += part->info.triangles;
    }
    found->node_count = norma_document_node_count(document);
    found->nodes = calloc(found->node_count + 1, sizeof *found->nodes);
    result = result || found->nodes ? result : NORMA_DOCUMENT_ERROR_MEMORY;
    for (size_t i = 0; i < found->node_count && !result; ++i)
        result = norma_document_node_info(document, i, &found->nodes[i]);
    found->skin_count = norma_document_skin_count(document);
    if (!result && whole) result = info_find_bounds(document, &found->bounds, error);
    if (!result && work->deep) result = find_open_parts(work, document, found, error);
    return result;
}

/* The body of a larger file is read with --deep only. */
static norma_document_depth depth_of(const info_work *work, const char *path) {
    const double most_megabytes = 256;
    return work->deep || cli_megabytes(path) <= most_megabytes ? NORMA_DOCUMENT_WHOLE
                                                               : NORMA_DOCUMENT_SUMMARY;
}

/* A document's contents, or those of each model of a composite; forget() frees them, whatever the
 * result. */
static norma_document_result read_models(const info_work *work, const char *path, int whole,
    norma_document *document, contents **found, size_t *count, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t models = 1;
    while (norma_document_tile(document, models)) ++models;
    *found = calloc(models, sizeof **found);
    if (!*found) return NORMA_DOCUMENT_ERROR_MEMORY;
    for (*count = 0; *count < models && !result; ++*count) {
        contents *one = &(*found)[*count];
        *one = (contents){.path = path, .tile = models > 1 ? *count : SIZE_MAX};
        result = read_contents(work, whole, norma_document_tile(document, *count), one, error);
        one->format = norma_document_format(document);
    }
    return result;
}

static void forget(contents **found, size_t *count, norma_document **document, void **memory) {
    for (size_t i = 0; i < *count; ++i) {
        free((*found)[i].parts);
        free((*found)[i].nodes);
    }
    free(*found);
    *found = NULL;
    *count = 0;
    norma_document_close(*document);
    free(*memory);
    *document = NULL;
    *memory = NULL;
}

/* A status. */
static int finish_file(const info_work *work, const char *path, const contents *found, size_t count,
    norma_document_error *error) {
    cli_name_error(error, path);
    if (error->result) {
        cli_print_error(error);
        if (work->common.json) info_write_failure(path, error);
    } else if (work->common.json) {
        info_write_json(found, count);
    } else {
        for (size_t i = 0; i < count; ++i) {
            info_print(&found[i]);
            fflush(stdout);
            if (!work->common.quiet) cli_print_notes(path, found[i].document);
        }
    }
    return cli_status_of(error->result);
}

static int run_large_file(const info_work *work, const char *path) {
    cli_progress progress;
    norma_document_error error = {0};
    mesh_part part = {.closed = -1};
    contents found = {.path = path,
        .tile = SIZE_MAX,
        .format = work->files.format,
        .parts = &part,
        .part_count = 1};
    cli_progress_start(&progress, "reading", path, work->common.quiet, cli_megabytes(path));
    error.result =
        info_describe_large(path, &found.format, &progress, &part.info, &found.bounds, &error);
    cli_progress_stop(&progress);
    found.vertices = part.info.vertices;
    found.faces = part.info.faces;
    found.triangles = part.info.triangles;
    return finish_file(work, path, &found, 1, &error);
}

static int info_file(const info_work *work, const char *path) {
    if (!work->deep && cli_needs_passes(&work->files, path)) return run_large_file(work, path);
    norma_document *document;
    norma_document_error error = {0};
    void *memory;
    contents *found = NULL;
    size_t count = 0;
    norma_document_options reading = {.depth = depth_of(work, path)};
    norma_document_result result =
        cli_read(&work->files, &work->common, path, &reading, &document, &memory, &error);
    if (!result)
        result = read_models(
            work, path, reading.depth == NORMA_DOCUMENT_WHOLE, document, &found, &count, &error);
    const int again = result && result != NORMA_DOCUMENT_ERROR_MEMORY && !work->deep &&
                      reading.depth == NORMA_DOCUMENT_WHOLE && strcmp(path, "-") != 0;
    if (again) { /* of a file whose body is at fault, the head may still be read */
        forget(&found, &count, &document, &memory);
        reading.depth = NORMA_DOCUMENT_SUMMARY;
        result = cli_read(&work->files, &work->common, path, &reading, &document, &memory, &error);
        if (!result) result = read_models(work, path, 0, document, &found, &count, &error);
    }
    error.result = result;
    const int status = finish_file(work, path, found, count, &error);
    forget(&found, &count, &document, &memory);
    return status;
}

static int run_one(void *user, size_t file) {
    const info_work *work = user;
    return info_file(work, work->files.inputs.list[file].path);
}

static void report_lost_info(void *user, size_t file, int worker, const char *why) {
    (void)worker;
    const info_work *work = user;
    const char *path = work->files.inputs.list[file].path;
    norma_document_error error;
    cli_lost_error(&error, path, why);
    finish_file(work, path, NULL, 0, &error);
}

/* ---- the command */

static int info_run(const cli_subcommand *command, int count, char **arguments) {
    info_work work = {.common = {.threads = NORMA_ALL_THREADS}};
    const cli_table tables[] = {
        {info_options, CLI_COUNT(info_options), &work},
        {cli_input_options, cli_input_option_count, &work.files},
        {cli_common_options, cli_common_option_count, &work.common},
    };
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = cli_find_inputs(command, &work.files);
    const cli_each each = {
        work.files.inputs.count, run_one, report_lost_info, &work, work.files.guard};
    if (status != CLI_USAGE) status = cli_worse(status, cli_run_each(&each));
    cli_files_end(&work.files);
    return cli_finish(status);
}

const cli_subcommand cli_subcommand_info = {
    "info", "lists what is in a file: meshes, counts, normals and transforms", info_help, info_run};
