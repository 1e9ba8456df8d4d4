/* shown_findings.c: what norma check found, as the page shows it: numbers and texts, the faces and
 * corners that a finding names in colour, and from where to look at it. */
#include "model.h"
#include "../../package/wasm/exports.h"
#include "io/image/image.h"
#include <math.h>
#include <norma/check.h>
#include <stdlib.h>
#include <string.h>

enum { NOTE = 0, MOST_SEVERITY = NORMA_SEVERITY_ERROR };
static const double REACH_SEEN = 0.3; /* the camera stands nine sizes off */

/* Red, green, blue, alpha, linear: those of norma render --show findings; what is not meant is
 * nothing. */
static const uint8_t colours[MOST_SEVERITY + 1][4] = {
    {0, 0, 0, 0}, {7, 54, 141, 255}, {196, 82, 3, 255}, {163, 6, 6, 255}};

static const view_pack_finding *finding_at(const model *m, uint32_t index) {
    return (const view_pack_finding *)(const void *)(m->pack + m->head->findings) + index;
}

/* ---- reading a pack */

static int is_text(const view_pack_head *head, const unsigned char *pack, uint32_t at) {
    return at < head->size && memchr(pack + at, 0, head->size - at) != NULL;
}

static int is_sound(
    const view_pack_head *head, const unsigned char *pack, const view_pack_finding *f) {
    return f->severity <= MOST_SEVERITY &&
           (f->mesh < head->mesh_count || f->mesh == VIEW_PACK_NONE) &&
           (f->draw < head->draw_count || f->draw == VIEW_PACK_NONE) &&
           is_text(head, pack, f->id) && is_text(head, pack, f->name) &&
           is_text(head, pack, f->unit) && is_text(head, pack, f->label) &&
           is_text(head, pack, f->message) && f->samples % 8 == 0 && f->samples <= head->size &&
           f->sample_count <= (head->size - f->samples) / sizeof(view_pack_sample);
}

int model_findings_are_sound(const view_pack_head *head, const unsigned char *pack) {
    if (head->finding_count == VIEW_PACK_NONE) return 1;
    if (head->findings % 8 || head->findings > head->size ||
        head->finding_count > (head->size - head->findings) / sizeof(view_pack_finding))
        return 0;
    const view_pack_finding *findings =
        (const view_pack_finding *)(const void *)(pack + head->findings);
    for (uint32_t i = 0; i < head->finding_count; ++i)
        if (!is_sound(head, pack, &findings[i])) return 0;
    return 1;
}

/* VIEW_PACK_NONE: the model was not checked. */
uint32_t WEB_EXPORT(model_finding_count)(const model *m) { return m->head->finding_count; }

/* That the page looks into no image is no fault of the file: a note. */
static uint32_t severity_shown(const model *m, const view_pack_finding *f) {
    const char *text = (const char *)m->pack;
    return strcmp(text + f->id, "N002") == 0 &&
                   strstr(text + f->message, norma_image_text(IMAGE_LEFT_OUT))
               ? NOTE
               : f->severity;
}

/* numbers: severity or NOTE, mesh, draw (-1: none), count, worst (NaN: no measure). */
void WEB_EXPORT(model_finding_numbers)(const model *m, uint32_t index, double numbers[5]) {
    const view_pack_finding *f = finding_at(m, index);
    numbers[0] = severity_shown(m, f);
    numbers[1] = f->mesh == VIEW_PACK_NONE ? -1.0 : (double)f->mesh;
    numbers[2] = f->draw == VIEW_PACK_NONE ? -1.0 : (double)f->draw;
    numbers[3] = f->count;
    numbers[4] = f->worst;
}

/* which: id, name, unit, label, message. */
const char *WEB_EXPORT(model_finding_text)(const model *m, uint32_t index, uint32_t which) {
    const view_pack_finding *f = finding_at(m, index);
    const uint32_t texts[5] = {f->id, f->name, f->unit, f->label, f->message};
    return (const char *)m->pack + texts[which < 5 ? which : 4];
}

/* ---- colours */

static size_t triangle_corner(const model_mesh *mesh, size_t i) {
    return mesh->triangle_corners ? mesh->triangle_corners[i] : i;
}

static size_t face_end(const model_mesh *mesh, size_t face) {
    return mesh->mesh.face_starts ? mesh->mesh.face_starts[face + 1] : 3 * face + 3;
}

static void raise(uint8_t *severity, uint32_t to) {
    *severity = *severity < to ? (uint8_t)to : *severity;
}

/* Severities of faces, of vertices, of stored normals, while they are gathered. */
typedef struct marks {
    uint8_t *faces, *vertices, *normals;
} marks;

static int raise_one(uint8_t *severities, size_t number, size_t count, uint32_t to) {
    if (number < count) raise(&severities[number], to);
    return number < count;
}

/* How many elements it names. */
static size_t mark_samples(
    const model *m, const model_mesh *mesh, const view_pack_finding *f, marks *to) {
    const view_pack_sample *samples =
        (const view_pack_sample *)(const void *)(m->pack + f->samples);
    int named = 0;
    size_t count = 0;
    for (uint32_t i = 0; i < f->sample_count; ++i) {
        named = raise_one(to->faces, samples[i].face, mesh->record->face_count, f->severity);
        named |=
            raise_one(to->vertices, samples[i].vertex, mesh->record->position_count, f->severity);
        named |= raise_one(to->normals, samples[i].normal, mesh->stored.count, f->severity);
        count += (size_t)named;
    }
    return count;
}

/* An info that names most of a mesh says something of the mesh; among others it would only hide
 * them. */
static int is_of_the_whole(const model_mesh *mesh, const view_pack_finding *f) {
    return f->severity == NORMA_SEVERITY_INFO && f->count > mesh->record->face_count / 4;
}

static void colour_corners(model_mesh *mesh, const marks *from) {
    size_t face = 0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const size_t corner = triangle_corner(mesh, i);
        uint8_t severity;
        while (corner >= face_end(mesh, face)) ++face;
        severity = from->faces[face];
        raise(&severity, from->vertices[model_corner_position(mesh, corner)]);
        if (mesh->stored_of_corner && mesh->stored_of_corner[corner] < mesh->stored.count)
            raise(&severity, from->normals[mesh->stored_of_corner[corner]]);
        memcpy(mesh->draw_marks + 4 * i, colours[severity], 4);
    }
}

/* Four bytes for each corner of each triangle: what the finding names, or, where there is none of
 * that number, what all do. NULL: out of memory. */
const uint8_t *WEB_EXPORT(model_marks)(model *m, uint32_t index, uint32_t which) {
    model_mesh *mesh = &m->meshes[index];
    const int all = which >= m->head->finding_count;
    marks made = {calloc((size_t)mesh->record->face_count + 1, 1),
        calloc((size_t)mesh->record->position_count + 1, 1), calloc(mesh->stored.count + 1, 1)};
    if (!mesh->draw_marks) mesh->draw_marks = malloc(12 * mesh->triangle_count + 1);
    const int good = made.faces && made.vertices && made.normals && mesh->draw_marks;
    for (uint32_t i = 0;
         good && m->head->finding_count != VIEW_PACK_NONE && i < m->head->finding_count; ++i) {
        const view_pack_finding *f = finding_at(m, i);
        if (f->mesh != index || (all ? is_of_the_whole(mesh, f) : i != which)) continue;
        /* One that names no part of its mesh is about all of it. */
        if (!mark_samples(m, mesh, f, &made) && !all && !mesh->record->decimated)
            memset(made.faces, (int)f->severity, mesh->record->face_count);
    }
    if (good) colour_corners(mesh, &made);
    free(made.faces);
    free(made.vertices);
    free(made.normals);
    return good ? mesh->draw_marks : NULL;
}

/* ---- from where to look */

/* Its area vector, turned away from the middle of the mesh: one that is wound wrongly is to be seen
 * as well. */
static void add_triangle(const float *p, double direction[3], double *size) {
    double u[3], v[3], area[3], outward = 0;
    for (int i = 0; i < 3; ++i) {
        u[i] = (double)p[3 + i] - (double)p[i];
        v[i] = (double)p[6 + i] - (double)p[i];
    }
    for (int i = 0; i < 3; ++i) {
        area[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
        outward += area[i] * ((double)p[i] + (double)p[3 + i] + (double)p[6 + i]);
    }
    for (int i = 0; i < 3; ++i) direction[i] += outward < 0 ? -area[i] : area[i];
    *size = fmax(*size, sqrt(fmax(u[0] * u[0] + u[1] * u[1] + u[2] * u[2],
                            v[0] * v[0] + v[1] * v[1] + v[2] * v[2])));
}

/* Whether a triangle, by the corner of the mesh that it begins with, is what the sample names. */
static int is_named(
    const model_mesh *mesh, size_t triangle, size_t face, const view_pack_sample *sample) {
    if (sample->face != VIEW_PACK_NONE) return face == sample->face;
    for (size_t i = 0; i < 3 && sample->vertex != VIEW_PACK_NONE; ++i)
        if (model_corner_position(mesh, triangle_corner(mesh, 3 * triangle + i)) == sample->vertex)
            return 1;
    return 0;
}

/* Where a sample is drawn, which a skin may have moved. */
static int point_of(const model_mesh *mesh, const view_pack_sample *sample, double out[3]) {
    double p[3];
    size_t count = 0;
    memset(out, 0, 3 * sizeof *out);
    if (sample->vertex < mesh->record->position_count) {
        model_position(mesh, sample->vertex, out);
        count = 1;
    } else if (sample->face < mesh->record->face_count) {
        const size_t start = sample->face ? face_end(mesh, sample->face - 1) : 0;
        for (size_t corner = start; corner < face_end(mesh, sample->face); ++corner, ++count) {
            model_position(mesh, model_corner_position(mesh, corner), p);
            for (int axis = 0; axis < 3; ++axis) out[axis] += p[axis];
        }
    }
    for (int axis = 0; axis < 3 && count; ++axis)
        out[axis] = (out[axis] / (double)count - mesh->centre[axis]) / mesh->radius;
    return count && isfinite(out[0] + out[1] + out[2]);
}

/* Whether it has the faces of whole components, behind the one that stands for it. */
static int is_of_component(const view_pack_finding *f) {
    return f->count == 1 && f->sample_count > 1;
}

/* How far the places of its samples reach from one of them. */
static double reach_of(const model *m, const view_pack_finding *f, const double from[3]) {
    const view_pack_sample *samples =
        (const view_pack_sample *)(const void *)(m->pack + f->samples);
    double most = 0, at[3];
    for (uint32_t i = 0; i < f->sample_count; ++i)
        if (point_of(&m->meshes[f->mesh], &samples[i], at))
            most = fmax(most, hypot(hypot(at[0] - from[0], at[1] - from[1]), at[2] - from[2]));
    return most;
}

/* which: 0: where it is worst; otherwise one of its samples. out: a point, a direction (of any
 * length) from which its faces are seen, and how long their edges are, in the space of
 * draw_positions. 0: the finding has no place. */
int WEB_EXPORT(model_finding_place)(const model *m, uint32_t index, uint32_t which, double out[7]) {
    const view_pack_finding *f = finding_at(m, index);
    if (f->mesh == VIEW_PACK_NONE || !f->has_position) return 0;
    const model_mesh *mesh = &m->meshes[f->mesh];
    const view_pack_sample *samples =
                               (const view_pack_sample *)(const void *)(m->pack + f->samples),
                           none = {VIEW_PACK_NONE, VIEW_PACK_NONE, VIEW_PACK_NONE};
    const view_pack_sample *sample = which < f->sample_count ? &samples[which] : &none;
    size_t face = 0;
    if (!which && f->sample_count > 1 && sample->face == VIEW_PACK_NONE &&
        sample->vertex == VIEW_PACK_NONE)
        sample = &samples[1];
    memset(out, 0, 7 * sizeof *out);
    for (int axis = 0; axis < 3; ++axis)
        out[axis] = (f->position[axis] - mesh->centre[axis]) / mesh->radius;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        while (triangle_corner(mesh, 3 * t) >= face_end(mesh, face)) ++face;
        if (is_named(mesh, t, face, sample))
            add_triangle(mesh->draw_positions + 9 * t, out + 3, out + 6);
    }
    double drawn[3];
    if (point_of(mesh, sample, drawn)) memcpy(out, drawn, sizeof drawn);
    if (is_of_component(f)) out[6] = fmax(out[6], REACH_SEEN * reach_of(m, f, out));
    return isfinite(out[0] + out[1] + out[2]);
}

/* ---- points to show, where faces have no area or are too small to be seen */

/* points: room for most; where its places are, in the space of draw_positions. How many. */
uint32_t WEB_EXPORT(model_finding_points)(
    const model *m, uint32_t index, uint32_t most, double *points) {
    const view_pack_finding *f = finding_at(m, index);
    const view_pack_sample *samples =
        (const view_pack_sample *)(const void *)(m->pack + f->samples);
    uint32_t count = 0;
    for (uint32_t i = 0; f->mesh != VIEW_PACK_NONE && i < f->sample_count && i <= f->count &&
                         count < most && !(i && is_of_component(f));
         ++i)
        count += (uint32_t)point_of(&m->meshes[f->mesh], &samples[i], points + 3 * count);
    return count;
}
