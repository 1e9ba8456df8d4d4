/* render_findings.c: what norma check names, coloured: faces, the corners of vertices, and a dot at
 * each place, by the gravest that was found there. */
#include "cli/render/render_command.h"
#include "cli/process/process.h"
#include <norma/check.h>
#include <stdlib.h>
#include <string.h>

const uint32_t render_finding_colours[4] = {[NORMA_SEVERITY_INFO] = 0x2F7FC4,
    [NORMA_SEVERITY_WARNING] = 0xE39A1E,
    [NORMA_SEVERITY_ERROR] = 0xD12B2B};
static const uint32_t *const colours = render_finding_colours;
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
    m->dots[m->dot_count].vertex = sample->vertex;
    m->dots[m->dot_count].face = sample->face;
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
    /* Errors last, so that their dots lie above. */
    for (int severity = NORMA_SEVERITY_INFO; severity <= NORMA_SEVERITY_ERROR; ++severity)
        for (size_t i = 0; good && i < norma_findings_count(findings); ++i) {
            const norma_finding *finding = norma_findings_get(findings, i);
            if ((int)finding->severity == severity && strcmp(finding->where, where) == 0)
                good = mark_finding(&m, finding);
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

/* How many of each severity, the rules of the gravest by name while there is room, and how many
 * have no place on a surface. */
static void tell_found(const norma_findings *findings, render_scene_file *file) {
    const size_t room = sizeof file->found;
    size_t length = 0, named = 0;
    memset(file->found_counts, 0, sizeof file->found_counts);
    file->found_nowhere = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        ++file->found_counts[finding->severity];
        file->found_nowhere += finding->sample_count == 0;
    }
    snprintf(file->found, room, "nothing found");
    for (int severity = NORMA_SEVERITY_ERROR; severity >= NORMA_SEVERITY_INFO; --severity)
        for (size_t i = 0; i < norma_findings_count(findings) && named < 3; ++i) {
            const norma_finding *finding = norma_findings_get(findings, i);
            char name[120];
            snprintf(name, sizeof name, "%s %s", finding->rule->id, finding->rule->name);
            if ((int)finding->severity != severity || (named && strstr(file->found, name)))
                continue;
            const int more =
                snprintf(file->found + length, room - length, "%s%s", named++ ? ", " : "", name);
            length += more > 0 && (size_t)more < room - length ? (size_t)more : 0;
        }
}

norma_document_result render_file_mark(const render_settings *settings, render_scene_file *file,
    render_surface *surfaces, size_t surface_count, norma_document_error *error) {
    cli_progress progress;
    const norma_check_options options = {.struct_size = sizeof options,
        .max_samples = MOST_SAMPLES,
        .rules = settings->has_select ? settings->select : NULL,
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
    if (!result) tell_found(findings, file);
    norma_findings_free(findings);
    error->result = result;
    return result;
}
