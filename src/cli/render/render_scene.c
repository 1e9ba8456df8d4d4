/* render_scene.c: a document as a scene: each mesh a surface, each node that draws one, and each of
 * its instances, a draw. */
#include "cli/render/render_scene.h"
#include <stdlib.h>
#include <string.h>

/* ---- surfaces */

static enum render_normals stored_as(const norma_mesh_info *info, const norma_mesh_data *data) {
    if (!data->normals.data || data->normals.count == 0) return RENDER_NORMALS_NONE;
    switch (info->normals) {
    case NORMA_NORMALS_NONE:
        return RENDER_NORMALS_NONE;
    case NORMA_NORMALS_PER_VERTEX:
        return data->normals.count < info->vertices ? RENDER_NORMALS_PER_CORNER
                                                    : RENDER_NORMALS_PER_VERTEX;
    case NORMA_NORMALS_PER_CORNER:
        return RENDER_NORMALS_PER_CORNER;
    case NORMA_NORMALS_PER_FACET:
        return RENDER_NORMALS_PER_FACET;
    }
    return RENDER_NORMALS_NONE;
}

/* What the format leaves open, as norma compute has it; glTF says that a mesh without normals is
 * flat. */
static double usual_crease(
    const render_settings *settings, norma_file_format format, const render_surface *surface) {
    const double flat = -1, all = 3.14159265358979, sixty = 1.0471975511965976;
    switch (format) {
    case NORMA_FILE_STL:
        return flat;
    case NORMA_FILE_PLY:
        return all;
    case NORMA_FILE_OBJ:
        return surface->mesh.smoothing_groups ? all : sixty;
    default:
        return surface->stored == RENDER_NORMALS_NONE && settings->show != RENDER_SHOW_ERROR &&
                       !settings->compute
                   ? flat
                   : sixty;
    }
}

static norma_document_result fill_surface(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, size_t index, const norma_mesh_info *info,
    render_surface *surface, norma_document_error *error) {
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_document_result result = norma_document_mesh_data(file->document, index, &data, error);
    if (!result) result = norma_document_mesh_attributes(file->document, index, &attributes, error);
    if (result) return result;
    const norma_file_format format = norma_document_format(file->document);
    *surface = (render_surface){.mesh = data.mesh,
        .normals = data.normals,
        .corner_normals = data.corner_normals,
        .stored = stored_as(info, &data)};
    if (variant->compute) surface->stored = RENDER_NORMALS_NONE;
    surface->replace_zeros = format == NORMA_FILE_STL;
    surface->weight = variant->weight;
    surface->crease_rad =
        variant->crease_given ? variant->crease_rad : usual_crease(settings, format, surface);
    return render_file_set_material(settings, file, index, &attributes, surface, error);
}

/* ---- the scene */

static norma_document_result fill_surfaces(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, scene_maker *m, norma_document_error *error) {
    for (size_t i = 0; i < norma_document_mesh_count(file->document); ++i) {
        norma_mesh_info info;
        norma_document_result result = norma_document_mesh_info(file->document, i, &info);
        if (!result && (info.not_read || info.triangles == 0)) continue;
        if (!result)
            result = fill_surface(
                settings, file, variant, i, &info, &m->surfaces[m->surface_count], error);
        if (result) return result;
        file->document_meshes[m->surface_count] = i;
        m->mesh_of[m->surface_count++] = info.mesh;
    }
    for (size_t first = 0, next; first < m->surface_count; first = next) {
        for (next = first + 1; next < m->surface_count && m->mesh_of[next] == m->mesh_of[first];)
            ++next;
        if (render_join_needed(settings, &m->surfaces[first], next - first) &&
            !render_join_primitives(file, &m->surfaces[first], next - first, error))
            return error->result;
    }
    return NORMA_DOCUMENT_OK;
}

/* Without nodes each mesh stands where its numbers say. */
static void draw_each_once(scene_maker *m) {
    for (size_t i = 0; i < m->surface_count; ++i) {
        m->draws[i].surface = i;
        memcpy(m->draws[i].world, cli_matrix_identity.matrix, sizeof m->draws[i].world);
    }
    m->draw_count = m->surface_count;
}

/* Why nothing can be drawn: the first mesh that could not be read, or what the file holds instead
 * of faces. */
static norma_document_result fail_empty(render_scene_file *file, norma_document_error *error) {
    char reason[400] = "it holds no mesh";
    for (size_t i = norma_document_mesh_count(file->document); i-- > 0;) {
        norma_mesh_info info;
        if (norma_document_mesh_info(file->document, i, &info)) continue;
        if (info.not_read)
            snprintf(reason, sizeof reason, "%.100s%s%.250s", info.where, info.where[0] ? ": " : "",
                info.not_read);
        else
            snprintf(reason, sizeof reason, "%s",
                info.triangles  ? "no node draws its meshes"
                : info.vertices ? "it holds points without faces"
                                : "it holds no faces");
    }
    char text[440];
    snprintf(text, sizeof text, "there is no surface to draw: %s", reason);
    return render_file_fail(error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, file->input, text);
}

static norma_document_result fill_scene(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, scene_maker *m, norma_document_error *error) {
    norma_document_result result = fill_surfaces(settings, file, variant, m, error);
    if (!result && settings->show == RENDER_SHOW_MARKS)
        result = render_file_mark(settings, file, m->surfaces, m->surface_count, error);
    if (!result) result = render_file_draws(settings, file, m, error);
    if (result || m->draw_count > 0) return result;
    free(m->draws);
    m->draws = calloc(m->surface_count + 1, sizeof *m->draws);
    if (!m->draws)
        return render_file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, "out of memory");
    draw_each_once(m);
    return result;
}

static norma_document_result make_scene(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, render_scene *scene, norma_document_error *error) {
    const size_t meshes = norma_document_mesh_count(file->document);
    scene_maker m = {.surfaces = calloc(meshes + 1, sizeof *m.surfaces),
        .mesh_of = calloc(meshes + 1, sizeof *m.mesh_of)};
    if (!file->document_meshes)
        file->document_meshes = calloc(meshes + 1, sizeof *file->document_meshes);
    norma_document_result result =
        m.surfaces && m.mesh_of && file->document_meshes
            ? fill_scene(settings, file, variant, &m, error)
            : render_file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, "out of memory");
    free(m.mesh_of);
    *scene = (render_scene){m.surfaces, m.surface_count, m.draws, m.draw_count};
    if (!result && m.draw_count == 0) result = fail_empty(file, error);
    if (!result && settings->show == RENDER_SHOW_TANGENTS && !file->with_tangents &&
        !file->with_texcoords)
        result = render_file_fail(error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, file->input,
            "there are no tangents to show: no surface stores any, nor the texture coordinates "
            "that glTF tangents are computed from");
    if (!result) render_file_set_up(settings, file, scene);
    if (result) render_scene_free(scene);
    error->result = result;
    return result;
}

static int same_variant(const render_variant *a, const render_variant *b) {
    return a->compute == b->compute && a->crease_given == b->crease_given &&
           a->weight == b->weight && !(a->crease_given && a->crease_rad != b->crease_rad);
}

const render_scene *render_file_scene(const render_settings *settings, render_scene_file *file,
    const render_variant *variant, norma_document_error *error) {
    for (size_t i = 0; i < file->variant_count; ++i)
        if (same_variant(&file->variants[i], variant)) return &file->scenes[i];
    if (file->variant_count == RENDER_MOST_PANELS) {
        render_file_fail(error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, file->input,
            "would be drawn in too many variants");
        return NULL;
    }
    if (make_scene(settings, file, variant, &file->scenes[file->variant_count], error)) return NULL;
    file->variants[file->variant_count] = *variant;
    return &file->scenes[file->variant_count++];
}
