/* ply_compute.c: a PLY with new normals, and under a matrix. */
#include "io/ply/ply.h"
#include <float.h>
#include <stdlib.h>

/* ---- Normals as whole numbers: in which types they are stored, and the codes for unit vectors. */

double norma_ply_normal_scale(
    const ply_header *header, const ply_element *element, const int properties[3]) {
    ply_type first = norma_ply_property(header, element, properties[0])->type;
    for (int axis = 1; axis < 3; ++axis)
        if (norma_ply_property(header, element, properties[axis])->type != first) return 1;
    return first == PLY_INT8 ? 127 : first == PLY_INT16 ? 32767 : 1;
}

void norma_ply_normal_types(const ply_header *header, const ply_element *element,
    const int properties[3], ply_type types[3]) {
    const double scale = norma_ply_normal_scale(header, element, properties);
    for (int axis = 0; axis < 3; ++axis) {
        const ply_type stored = norma_ply_property(header, element, properties[axis])->type;
        types[axis] = stored >= PLY_FLOAT || scale > 1 ? stored : PLY_FLOAT;
    }
}

norma_document_result norma_ply_encode_normals(norma_document *document, const ply_type types[3],
    float *normals, size_t count, norma_document_error *error) {
    if (types[0] >= PLY_FLOAT || count == 0) return NORMA_DOCUMENT_OK;
    const norma_vec3_view view = {.data = normals, .count = count, .format = NORMA_FORMAT_FLOAT};
    const int narrow = types[0] == PLY_INT8;
    int8_t *bytes = narrow ? norma_io_allocate(3 * count, sizeof *bytes) : NULL;
    int16_t *shorts = narrow ? NULL : norma_io_allocate(3 * count, sizeof *shorts);
    if (!bytes && !shorts) return norma_document_fail_memory(document, error);
    norma_result result = narrow ? norma_encode_snorm8(view, bytes, 0, count)
                                 : norma_encode_snorm16(view, shorts, 0, count);
    for (size_t i = 0; i < 3 * count; ++i) normals[i] = narrow ? (float)bytes[i] : (float)shorts[i];
    free(bytes);
    free(shorts);
    return result ? norma_document_fail_core(document, error, result) : NORMA_DOCUMENT_OK;
}

/* ---- Normals of a PLY. One for each vertex; where a crease asks for several, the vertex
 * gets copies at the end, so that all old ones keep their numbers. */

typedef struct ply_job {
    norma_document *document;
    norma_document_error *error;
    ply_state *state;
    compute_policy policy;
    double *stored;   /* with NORMA_ONLY_BROKEN: the normals as they are, else NULL */
    uint8_t *wanted;  /* with it, nonzero: this vertex's normal is broken */
    float *normals;   /* of the vertices as they will be */
    uint8_t *reasons; /* why one holds the fallback */
    uint32_t *corners, *added;
    size_t added_count;
} ply_job;

static void free_job(ply_job *job) {
    free(job->stored);
    free(job->wanted);
    free(job->normals);
    free(job->reasons);
    free(job->corners);
    free(job->added);
}

static norma_document_result ply_fail_memory(const ply_job *job) {
    return norma_document_fail_memory(job->document, job->error);
}

/* ---- what is to be done */

int norma_ply_is_broken(const double stored[3], double scale) {
    double normal[3];
    for (int axis = 0; axis < 3; ++axis) {
        normal[axis] = stored[axis] / scale;
        if (scale > 1 && normal[axis] < -1) normal[axis] = -1;
    }
    return norma_normal_is_broken(normal, scale == 127 ? 8 : 32);
}

static norma_document_result ply_find_broken(ply_job *job, size_t *broken) {
    ply_state *state = job->state;
    const ply_element *vertex = norma_ply_vertex(state);
    norma_document_result result = norma_ply_read_columns(
        job->document, vertex, state->header.normal, &job->stored, job->error);
    job->wanted = norma_io_allocate(state->vertices, 1);
    if (!result && !job->wanted) return ply_fail_memory(job);
    const double scale = norma_ply_normal_scale(&state->header, vertex, state->header.normal);
    for (size_t i = 0; !result && i < state->vertices; ++i) {
        job->wanted[i] = (uint8_t)norma_ply_is_broken(job->stored + 3 * i, scale);
        *broken += job->wanted[i];
    }
    return result;
}

/* ---- one normal for each vertex */

static norma_document_result compute_smooth(ply_job *job) {
    const norma_mesh mesh = norma_ply_core_mesh(job->state);
    computed_normals made = {.elements = NORMALS_OF_POSITIONS, .with_reasons = 1};
    const norma_result result = norma_policy_compute(&job->policy, &mesh, &made);
    job->normals = made.normals;
    job->reasons = made.reasons;
    return result ? norma_document_fail_core(job->document, job->error, result) : NORMA_DOCUMENT_OK;
}

/* ---- split vertices */

typedef struct split_mesh {
    norma_mesh mesh; /* with a face (v, v, v) for each vertex that no face uses: so it takes part,
                        and gets the nearest normal */
    uint32_t *own_corners, *own_starts; /* NULL where there is no such vertex */
    size_t idle;                        /* how many there are */
    computed_normals made;
} split_mesh;

static void free_split(split_mesh *split) {
    free(split->own_corners);
    free(split->own_starts);
    norma_computed_normals_free(&split->made);
}

static int append_idle(split_mesh *split, const uint8_t *used, size_t vertices) {
    const norma_mesh *mesh = &split->mesh;
    const size_t corner_count = mesh->corner_count + 3 * split->idle,
                 faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    split->own_corners = norma_io_allocate(corner_count, sizeof *split->own_corners);
    split->own_starts = norma_io_allocate(faces + split->idle + 1, sizeof *split->own_starts);
    if (!split->own_corners || !split->own_starts) return 0;
    memcpy(split->own_corners, mesh->corners, mesh->corner_count * sizeof *split->own_corners);
    for (size_t i = 0; i <= faces; ++i)
        split->own_starts[i] = mesh->face_starts ? mesh->face_starts[i] : (uint32_t)(3 * i);
    size_t corner = mesh->corner_count, face = faces;
    for (size_t vertex = 0; vertex < vertices; ++vertex) {
        if (used[vertex]) continue;
        for (int k = 0; k < 3; ++k) split->own_corners[corner++] = (uint32_t)vertex;
        split->own_starts[++face] = (uint32_t)corner;
    }
    split->mesh.corners = split->own_corners;
    split->mesh.face_starts = split->own_starts;
    split->mesh.corner_count = corner_count;
    split->mesh.face_count = face;
    return 1;
}

static norma_document_result gather_split_mesh(const ply_job *job, split_mesh *split) {
    const ply_mesh *mesh = &job->state->mesh;
    const size_t vertices = job->state->vertices;
    split->mesh = norma_ply_core_mesh(job->state);
    uint8_t *used = norma_io_allocate(vertices, 1);
    if (!used) return ply_fail_memory(job);
    for (size_t i = 0; i < mesh->corner_count; ++i) used[mesh->corners[i]] = 1;
    for (size_t i = 0; i < vertices; ++i) split->idle += !used[i];
    int ok = split->idle == 0;
    if (!ok && split->idle <= (UINT32_MAX - mesh->corner_count) / 3)
        ok = append_idle(split, used, vertices);
    free(used);
    return ok ? NORMA_DOCUMENT_OK : ply_fail_memory(job);
}

/* How many of the faces appended count as degenerate: a vertex that is not finite makes none. */
static size_t degenerate_idle(const split_mesh *split) {
    size_t count = 0;
    for (size_t c = split->mesh.corner_count - 3 * split->idle; c < split->mesh.corner_count;
         c += 3)
        count += split->made.reasons[split->made.points[c]] != NORMA_REASON_NON_FINITE;
    return count;
}

static norma_document_result run_split(ply_job *job, split_mesh *split) {
    split->made = (computed_normals){.elements = NORMALS_OF_POINTS,
        .with_reasons = 1,
        .crease_angle_rad = job->policy.summary->crease_angle_rad};
    const norma_result result = norma_policy_compute(&job->policy, &split->mesh, &split->made);
    if (result) return norma_document_fail_core(job->document, job->error, result);
    norma_count *degenerate = &job->policy.summary->report.degenerate_faces;
    degenerate->count -= degenerate_idle(split);
    degenerate->first = degenerate->count ? degenerate->first : SIZE_MAX;
    return NORMA_DOCUMENT_OK;
}

/* The first copy of a vertex keeps its number, all further ones go to the end; a vertex whose
 * normal is not wanted has no further ones. 0: out of memory. */
static int number_places(ply_job *job, const split_mesh *split, uint32_t *place) {
    const size_t vertices = job->state->vertices;
    uint8_t *taken = norma_io_allocate(vertices, 1);
    for (size_t i = 0; taken && i < split->made.count; ++i) {
        const uint32_t source = split->made.sources[i];
        if (taken[source] && (!job->wanted || job->wanted[source])) {
            place[i] = (uint32_t)(vertices + job->added_count);
            job->added[job->added_count++] = source;
        } else {
            place[i] = source;
        }
        taken[source] = 1;
    }
    free(taken);
    return taken != NULL;
}

static int place_normals(ply_job *job, const split_mesh *split, const uint32_t *place) {
    const size_t count = job->state->vertices + job->added_count;
    job->normals = norma_io_allocate(count, 3 * sizeof *job->normals);
    job->reasons = norma_io_allocate(count, 1);
    if (!job->normals || !job->reasons) return 0;
    for (size_t i = 0; i < split->made.count; ++i) {
        memcpy(job->normals + 3 * (size_t)place[i], split->made.normals + 3 * i, 3 * sizeof(float));
        job->reasons[place[i]] = split->made.reasons[i];
    }
    return 1;
}

static norma_document_result place_vertices(ply_job *job, split_mesh *split) {
    uint32_t *place = norma_io_allocate(split->made.count, sizeof *place);
    job->added = norma_io_allocate(split->made.count, sizeof *job->added);
    const int ok =
        place && job->added && number_places(job, split, place) && place_normals(job, split, place);
    if (ok) {
        uint32_t *corners = split->made.points; /* they get their places where they stand */
        for (size_t i = 0; i < job->state->mesh.corner_count; ++i) corners[i] = place[corners[i]];
        job->corners = corners;
        split->made.points = NULL;
    }
    free(place);
    return ok ? NORMA_DOCUMENT_OK : ply_fail_memory(job);
}

static norma_document_result compute_split(ply_job *job) {
    split_mesh split = {0};
    norma_document_result result = gather_split_mesh(job, &split);
    if (!result && job->state->vertices + split.mesh.corner_count > UINT32_MAX)
        result = norma_document_fail(job->document, job->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            NULL, "splitting could need more than 4294967295 vertices");
    if (!result) result = run_split(job, &split);
    if (!result) result = place_vertices(job, &split);
    if (!result) {
        norma_report *report = &job->policy.summary->report;
        norma_policy_forget(report);
        norma_policy_report(
            report, job->reasons, job->state->vertices + job->added_count, NULL, 0, 0);
    }
    free_split(&split);
    return result;
}

/* ---- into the document */

/* The old normals with the broken ones replaced. */
static norma_document_result keep_stored(ply_job *job) {
    ply_edit *edit = &job->state->edit;
    const size_t vertices = job->state->vertices, count = vertices + job->added_count;
    double *all = realloc(job->stored, (count ? count : 1) * 3 * sizeof *all);
    if (!all) return ply_fail_memory(job);
    job->stored = NULL;
    edit->normals.doubles = all;
    for (size_t i = 0; i < count; ++i)
        for (size_t axis = 0; axis < 3 && (i >= vertices || job->wanted[i]); ++axis)
            all[3 * i + axis] = (double)job->normals[3 * i + axis];
    return NORMA_DOCUMENT_OK;
}

/* The sign of a stored zero says nothing: it stays, so that a file whose normals are right already
 * stays as it is. */
static norma_document_result ply_keep_zero_signs(const ply_job *job) {
    const ply_state *state = job->state;
    double *stored = NULL;
    if (state->header.normal[0] == PLY_NONE || job->stored) return NORMA_DOCUMENT_OK;
    norma_document_result result = norma_ply_read_columns(
        job->document, norma_ply_vertex(state), state->header.normal, &stored, job->error);
    for (size_t i = 0; i < 3 * state->vertices && !result; ++i)
        job->normals[i] = norma_policy_keep_zero(job->normals[i], stored[i]);
    free(stored);
    return result;
}

static norma_document_result ply_take_result(ply_job *job) {
    ply_state *state = job->state;
    ply_edit *edit = &state->edit;
    const ply_header *header = &state->header;
    const int had = header->normal[0] != PLY_NONE;
    edit->normals.types[0] = edit->normals.types[1] = edit->normals.types[2] = PLY_FLOAT;
    if (had)
        norma_ply_normal_types(
            header, norma_ply_element(header, header->vertex), header->normal, edit->normals.types);
    norma_document_result result = norma_ply_encode_normals(job->document, edit->normals.types,
        job->normals, state->vertices + job->added_count, job->error);
    if (!result) result = ply_keep_zero_signs(job);
    if (result) return result;
    if (job->stored) {
        result = keep_stored(job);
    } else {
        edit->normals.floats = job->normals;
        job->normals = NULL;
    }
    if (result || job->added_count == 0) return result;
    edit->added = job->added;
    edit->added_count = job->added_count;
    edit->corners = job->corners;
    job->added = job->corners = NULL;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result ply_compute_all(ply_job *job) {
    norma_document_result result;
    size_t broken = 0;
    norma_compute_summary *summary = job->policy.summary;
    if (job->policy.options->only == NORMA_ONLY_BROKEN &&
        job->state->header.normal[0] != PLY_NONE) {
        result = ply_find_broken(job, &broken);
        if (result || broken == 0) return result;
    }
    result = summary->shading == NORMA_SHADING_SMOOTH ? compute_smooth(job) : compute_split(job);
    if (result) return result;
    norma_policy_fill(&job->policy, job->normals, job->reasons,
        job->state->vertices + job->added_count, job->wanted, job->state->vertices);
    result = ply_take_result(job);
    if (!result) result = norma_edited_drop_idle(job->document, &summary->changed, job->error);
    summary->vertices_after = job->state->vertices + job->state->edit.added_count;
    return result;
}

norma_document_result norma_ply_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    ply_state *state = document->state;
    ply_job job = {.document = document,
        .error = error,
        .state = state,
        .policy = norma_policy_begin(options, summary, NORMA_SHADING_SMOOTH, 0)};
    job.policy.shared = document->shared;
    summary->faces = state->faces;
    summary->vertices_before = summary->vertices_after = state->vertices;
    if (state->mesh.corner_count == 0) {
        norma_document_add_note(document, "points without faces: there is nothing to take normals "
                                          "from, so the file stays as it is");
        return NORMA_DOCUMENT_OK;
    }
    if (document->shared && document->shared->locked && document->shared->locked[0])
        return NORMA_DOCUMENT_OK;
    if (options->only == NORMA_ONLY_MISSING && state->header.normal[0] != PLY_NONE)
        return NORMA_DOCUMENT_OK;
    result = ply_compute_all(&job);
    free_job(&job);
    return result;
}

/* ---- A PLY under a matrix: positions in their own types where those hold the result,
 * normals through the normal matrix, faces turned round under a mirror. */

/* ---- positions */

/* Whole numbers that do not hold the result become floats (32-bit ones doubles), and floats
 * doubles. */
static void choose_types(const ply_state *state, ply_edit *edit) {
    const ply_header *header = &state->header;
    const ply_element *vertex = norma_ply_element(header, header->vertex);
    int whole = 1, wide = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const ply_type type = norma_ply_property(header, vertex, header->position[axis])->type;
        edit->positions.types[axis] = type;
        wide |= type == PLY_INT32 || type == PLY_UINT32;
        for (size_t i = 0; i < state->vertices && type < PLY_FLOAT && whole; ++i)
            whole = norma_ply_type_holds(type, edit->positions.doubles[3 * i + (size_t)axis]);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (edit->positions.types[axis] < PLY_FLOAT && !whole)
            edit->positions.types[axis] = wide ? PLY_DOUBLE : PLY_FLOAT;
        for (size_t i = 0; i < state->vertices && edit->positions.types[axis] == PLY_FLOAT; ++i)
            if (!norma_ply_type_holds(PLY_FLOAT, edit->positions.doubles[3 * i + (size_t)axis]))
                edit->positions.types[axis] = PLY_DOUBLE;
    }
}

/* Positions that are all written as floats become floats at once: rows take them as they lie. */
static norma_document_result narrow_positions(
    norma_document *document, ply_edit *edit, norma_document_error *error) {
    const size_t count = ((const ply_state *)document->state)->vertices;
    for (int axis = 0; axis < 3; ++axis)
        if (edit->positions.types[axis] != PLY_FLOAT) return NORMA_DOCUMENT_OK;
    edit->positions.floats = norma_io_allocate(count, 3 * sizeof *edit->positions.floats);
    if (!edit->positions.floats) return norma_document_fail_memory(document, error);
    for (size_t i = 0; i < 3 * count; ++i)
        edit->positions.floats[i] = (float)edit->positions.doubles[i];
    free(edit->positions.doubles);
    edit->positions.doubles = NULL;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result transform_positions(
    norma_document *document, const double matrix[16], norma_document_error *error) {
    ply_state *state = document->state;
    ply_edit *edit = &state->edit;
    edit->positions.doubles =
        norma_io_allocate(state->vertices, 3 * sizeof *edit->positions.doubles);
    if (!edit->positions.doubles) return norma_document_fail_memory(document, error);
    norma_result result = norma_transform_positions_double(
        matrix, state->mesh.positions, edit->positions.doubles, 0, state->vertices);
    if (result) return norma_document_fail_core(document, error, result);
    choose_types(state, edit);
    const norma_document_result told = norma_check_transformed_range(
        document, &state->mesh.positions, edit->positions.doubles, DBL_MAX, "vertex", 1, error);
    return told ? told : narrow_positions(document, edit, error);
}

/* ---- normals */

static norma_document_result transform_column(norma_document *document,
    const normal_mapping *mapping, const ply_element *element, const int properties[3],
    float **normals, ply_type types[3], norma_document_error *error) {
    const ply_header *header = &((const ply_state *)document->state)->header;
    const size_t count = element ? (size_t)element->count : 0;
    double *stored = NULL;
    if (properties[0] == PLY_NONE) return NORMA_DOCUMENT_OK;
    norma_document_result result =
        norma_ply_read_columns(document, element, properties, &stored, error);
    *normals = result ? NULL : norma_io_allocate(count, 3 * sizeof **normals);
    if (!result && !*normals) result = norma_document_fail_memory(document, error);
    if (!result)
        result = norma_transform_stored_normals(document, mapping, stored, count, *normals, error);
    if (!result) {
        norma_ply_normal_types(header, element, properties, types);
        result = norma_ply_encode_normals(document, types, *normals, count, error);
    }
    free(stored);
    return result;
}

static norma_document_result transform_normals(
    norma_document *document, const normal_mapping *mapping, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_header *header = &state->header;
    ply_edit *edit = &state->edit;
    const norma_document_result result = transform_column(document, mapping,
        norma_ply_vertex(state), header->normal, &edit->normals.floats, edit->normals.types, error);
    return result ? result
                  : transform_column(document, mapping, norma_ply_element(header, header->face),
                        header->face_normal, &edit->face_normals.floats, edit->face_normals.types,
                        error);
}

/* ---- faces */

static norma_document_result ply_reverse_faces(
    norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_mesh *mesh = &state->mesh;
    if (mesh->corner_count == 0) return NORMA_DOCUMENT_OK;
    uint32_t *corners = malloc(mesh->corner_count * sizeof *corners);
    if (!corners) return norma_document_fail_memory(document, error);
    state->edit.corners = corners;
    state->edit.reversed = 1;
    memcpy(corners, mesh->corners, mesh->corner_count * sizeof *corners);
    norma_result result = norma_reverse_winding(
        corners, sizeof *corners, mesh->corner_count, mesh->face_starts, mesh->face_count);
    return result ? norma_document_fail_core(document, error, result) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_ply_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    ply_state *state = document->state;
    summary->vertices = state->vertices;
    summary->meshes = 1;
    if (norma_matrix_is_identity(options->matrix)) return NORMA_DOCUMENT_OK;
    normal_mapping mapping;
    result = norma_stored_normals_begin(document, options, summary, &mapping, error);
    if (result) return result;
    result = transform_positions(document, options->matrix, error);
    if (!result) result = transform_normals(document, &mapping, error);
    if (!result && mapping.mirrored) result = ply_reverse_faces(document, error);
    if (!result) result = norma_edited_drop_idle(document, &summary->changed, error);
    return result ? result : norma_stored_normals_progress(document, options, 1, error);
}
