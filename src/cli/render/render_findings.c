/* render_findings.c: what norma check names, coloured: faces, the corners of vertices, and a dot at
 * each place, by the gravest that was found there. */
#include "cli/render/render_command.h"
#include "cli/process/errors.h"
#include "cli/process/progress.h"
#include <norma/check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const uint32_t colours[] = {[NORMA_SEVERITY_INFO] = 0x2F7FC4,
    [NORMA_SEVERITY_WARNING] = 0xE39A1E,
    [NORMA_SEVERITY_ERROR] = 0xD12B2B};
enum { MOST_SAMPLES = 20000 }; /* of one finding */

/* One surface's marks while they are made: severities first, so that the gravest stays. */
typedef struct marks {
    const render_surface *surface;
    size_t faces, corners;
    uint8_t *face_severity, *corner_severity;
    uint32_t *vertex_corners, *vertex_starts; /* the corners of each position */
    render_dot *dots;
    size_t dot_count, dot_room;
} marks;

static size_t face_count(const norma_mesh *mesh) {
    return mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
}

/* A counting sort of corners by position. */
static void sort_corners(marks *m) {
    const norma_mesh *mesh = &m->surface->mesh;
    for (size_t i = 0; i < m->corners; ++i) ++m->vertex_starts[norma_mesh_corner(mesh, i) + 1];
    for (size_t i = 0; i < mesh->positions.count; ++i)
        m->vertex_starts[i + 1] += m->vertex_starts[i];
    for (size_t i = m->corners; i-- > 0;) {
        const uint32_t position = norma_mesh_corner(mesh, i);
        m->vertex_corners[--m->vertex_starts[position + 1]] = (uint32_t)i;
    }
    /* Each start has moved down to its own; the first stays 0. */
    memmove(
        m->vertex_starts, m->vertex_starts + 1, mesh->positions.count * sizeof *m->vertex_starts);
    m->vertex_starts[mesh->positions.count] = (uint32_t)m->corners;
}

static int begin(marks *m, const render_surface *surface) {
    *m = (marks){.surface = surface,
        .faces = face_count(&surface->mesh),
        .corners = surface->mesh.corner_count};
    m->face_severity = calloc(m->faces + 1, 1);
    m->corner_severity = calloc(m->corners + 1, 1);
    m->vertex_corners = malloc((m->corners + 1) * sizeof *m->vertex_corners);
    m->vertex_starts = calloc(surface->mesh.positions.count + 2, sizeof *m->vertex_starts);
    if (!m->face_severity || !m->corner_severity || !m->vertex_corners || !m->vertex_starts)
        return 0;
    sort_corners(m);
    return 1;
}

static void end(marks *m) {
    free(m->face_severity);
    free(m->corner_severity);
    free(m->vertex_corners);
    free(m->vertex_starts);
    free(m->dots);
}

static void raise(uint8_t *severity, norma_severity to) {
    *severity = *severity < to ? (uint8_t)to : *severity;
}

/* The vertex of a sample, or the corner of its face that is nearest to its position: a dot moves
 * with it. */
static uint32_t vertex_of(const marks *m, const norma_sample *sample) {
    const norma_mesh *mesh = &m->surface->mesh;
    double best = INFINITY;
    uint32_t vertex = UINT32_MAX;
    if (sample->vertex < mesh->positions.count) return (uint32_t)sample->vertex;
    if (sample->face >= m->faces) return vertex;
    const size_t first = mesh->face_starts ? mesh->face_starts[sample->face] : 3 * sample->face,
                 end = mesh->face_starts ? mesh->face_starts[sample->face + 1] : first + 3;
    for (size_t corner = first; corner < end; ++corner) {
        double p[3], squares = 0;
        norma_view_vector(&mesh->positions, norma_mesh_corner(mesh, corner), p);
        for (int k = 0; k < 3; ++k)
            squares += (p[k] - sample->position[k]) * (p[k] - sample->position[k]);
        if (squares >= best) continue;
        best = squares;
        vertex = norma_mesh_corner(mesh, corner);
    }
    return vertex;
}

static int add_dot(marks *m, const norma_sample *sample, norma_severity severity) {
    if (!sample->has_position) return 1;
    if (m->dot_count == m->dot_room) {
        const size_t room = m->dot_room ? 2 * m->dot_room : 64;
        render_dot *larger = realloc(m->dots, room * sizeof *larger);
        if (!larger) return 0;
        m->dots = larger;
        m->dot_room = room;
    }
    memcpy(m->dots[m->dot_count].position, sample->position, sizeof sample->position);
    m->dots[m->dot_count].vertex = vertex_of(m, sample);
    m->dots[m->dot_count++].colour = colours[severity];
    return 1;
}

static void mark_sample(marks *m, const norma_sample *sample, norma_severity severity) {
    if (sample->face < m->faces) raise(&m->face_severity[sample->face], severity);
    if (sample->vertex < m->surface->mesh.positions.count)
        for (uint32_t i = m->vertex_starts[sample->vertex];
             i < m->vertex_starts[sample->vertex + 1]; ++i)
            raise(&m->corner_severity[m->vertex_corners[i]], severity);
    for (size_t i = 0; sample->normal != SIZE_MAX && m->surface->corner_normals && i < m->corners;
         ++i)
        if (m->surface->corner_normals[i] == sample->normal)
            raise(&m->corner_severity[i], severity);
}

/* Dots mark what is small or far between; where very many places are named, the faces' colours do.
 * An info that names most of a mesh says something of the mesh, and would only hide the rest. */
static const size_t most_dots = 400;

static int is_of_the_whole(const marks *m, const norma_finding *finding) {
    return finding->severity == NORMA_SEVERITY_INFO && finding->count > m->faces / 4;
}

static int mark_finding(marks *m, const norma_finding *finding) {
    int good = 1;
    for (size_t i = 0; i < finding->sample_count && good && !is_of_the_whole(m, finding); ++i) {
        mark_sample(m, &finding->samples[i], finding->severity);
        if (finding->sample_count <= most_dots && finding->severity >= NORMA_SEVERITY_WARNING)
            good = add_dot(m, &finding->samples[i], finding->severity);
    }
    return good;
}

static uint32_t *coloured(render_scene_file *file, const uint8_t *severities, size_t count) {
    uint32_t *out = malloc((count + 1) * sizeof *out);
    for (size_t i = 0; out && i < count; ++i) out[i] = colours[severities[i]];
    return out && render_file_keep(file, out) ? out : NULL;
}

static int mark_surface(render_scene_file *file, const norma_findings *findings, const char *where,
    render_surface *surface) {
    marks m;
    int good = begin(&m, surface);
    for (size_t i = 0; good && i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (strcmp(finding->where, where) == 0) good = mark_finding(&m, finding);
    }
    if (good) {
        surface->face_marks = coloured(file, m.face_severity, m.faces);
        surface->corner_marks = coloured(file, m.corner_severity, m.corners);
        good = surface->face_marks && surface->corner_marks;
    }
    if (good && m.dots) {
        surface->dots = m.dots;
        surface->dot_count = m.dot_count;
        good = render_file_keep(file, m.dots);
        m.dots = NULL;
    }
    end(&m);
    return good;
}

static void count_words(const norma_findings *findings, char *words, size_t room) {
    size_t counts[4] = {0};
    int length;
    for (size_t i = 0; i < norma_findings_count(findings); ++i)
        ++counts[norma_findings_get(findings, i)->severity];
    length = snprintf(words, room, "%zu error%s, %zu warning%s, %zu info%s",
        counts[NORMA_SEVERITY_ERROR], counts[NORMA_SEVERITY_ERROR] == 1 ? "" : "s",
        counts[NORMA_SEVERITY_WARNING], counts[NORMA_SEVERITY_WARNING] == 1 ? "" : "s",
        counts[NORMA_SEVERITY_INFO], counts[NORMA_SEVERITY_INFO] == 1 ? "" : "s");
    /* The first rules by name, while there is room. */
    for (size_t i = 0;
         i < norma_findings_count(findings) && i < 3 && length > 0 && (size_t)length < room; ++i) {
        const norma_rule *rule = norma_findings_get(findings, i)->rule;
        length += snprintf(words + length, room - (size_t)length, "%s%s %s", i ? ", " : ": ",
            rule->id, rule->name);
    }
}

norma_document_result render_file_mark(const render_settings *settings, render_scene_file *file,
    render_surface *surfaces, size_t surface_count, norma_document_error *error) {
    cli_progress progress;
    const norma_check_options options = {.struct_size = sizeof options,
        .max_samples = MOST_SAMPLES,
        .threads = settings->common.threads,
        .progress = cli_progress_elapsed,
        .progress_user = &progress};
    norma_findings *findings = NULL;
    cli_progress_start(&progress, "checking", file->input, settings->common.quiet, 0);
    norma_document_result result = norma_check_document(file->document, &options, &findings, error);
    cli_progress_stop(&progress);
    for (size_t i = 0; i < surface_count && !result; ++i) {
        norma_mesh_info info;
        result = norma_document_mesh_info(file->document, file->document_meshes[i], &info);
        if (!result && !mark_surface(file, findings, info.where, &surfaces[i])) {
            snprintf(error->message, sizeof error->message, "%.800s: out of memory",
                cli_input_name(file->input));
            result = NORMA_DOCUMENT_ERROR_MEMORY;
        }
    }
    if (!result) count_words(findings, file->found, sizeof file->found);
    norma_findings_free(findings);
    error->result = result;
    return result;
}
