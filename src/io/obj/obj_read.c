/* obj_read.c: reads an OBJ with several threads. The text is cut into stretches of whole
 * statements. The thread that has read a stretch waits for its turn, in the order of the text, to
 * learn where its elements go, and copies them there while others go on. So the arrays are the same
 * as those of a single reader.
 *
 * Errors are not reported from here: the text is then read once more, as one part from its
 * beginning, so that the message knows what stands before each statement. */
#include "io/obj/obj.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { STRETCH = 1 << 18 }; /* bytes; what it becomes stays in a core's own cache */

typedef struct spare_part {
    obj_part part;
    struct spare_part *next;
} spare_part;

typedef struct gathering {
    const norma_document *document;
    norma_watch *watch;
    obj_state *state;
    const char *text, *end;
    pthread_mutex_t lock;
    pthread_cond_t moved; /* turn, or copying */
    size_t turn, copying; /* the stretch whose turn it is; how many copy now */
    spare_part *spares;
    norma_document_result result;
    int64_t group; /* in force */
    uint32_t last_position, last_normal;
    int known;
    obj_oddity unknown, empty_face, odd_number;
} gathering;

/* Where a part's elements go. */
typedef struct place {
    obj_stretch at;
    size_t corner;
    int with_normals, with_faces;
} place;

/* ---- growing arrays */

/* count more elements of a part, in its text from begin on. */
typedef struct addition {
    const obj_part *part;
    size_t begin, count;
} addition;

/* Makes space for more elements behind the used ones. If the array must grow, it grows to what the
 * rest of the text would hold if it were like this part. No thread copies meanwhile. */
static int obj_reserve(
    gathering *g, addition more, void *array, size_t *room, size_t used, size_t size) {
    void *block;
    memcpy(&block, array, sizeof block);
    if (block && used + more.count <= *room) return 1;
    while (g->copying) norma_watch_wait(g->watch, &g->moved, &g->lock);
    const char *begin = block || more.begin == SIZE_MAX ? more.part->begin : g->text + more.begin;
    const double left = (double)(g->end - begin) / (double)(more.part->end - begin);
    const double guess = (double)used + 1.01 * left * (double)more.count;
    const size_t wanted = used + more.count < (size_t)OBJ_MOST && guess < (double)OBJ_MOST
                              ? (size_t)guess
                              : used + more.count; /* left is at least 1, the guess never less */
    void *grown = norma_io_move_block(block, block ? used * size : 0, wanted, size);
    if (!grown) return 0;
    memcpy(array, &grown, sizeof grown);
    *room = wanted;
    return 1;
}

/* From the first corner on that names a normal, every corner has a number. */
static int reserve_corner_normals(gathering *g, const obj_part *part) {
    obj_state *state = g->state;
    const int first = !state->corner_normals;
    if (first && !part->names_normals) return 1;
    if (!obj_reserve(g, (addition){part, part->first_face, part->corner_count},
            &state->corner_normals, &state->corner_normal_room, state->corner_count,
            sizeof(uint32_t)))
        return 0;
    if (first && state->corner_count)
        memset(state->corner_normals, 0xff, state->corner_count * sizeof(uint32_t));
    return 1;
}

/* The same with faces that are no triangles. */
static int reserve_face_starts(gathering *g, const obj_part *part) {
    obj_state *state = g->state;
    const int first = !state->face_starts;
    if (first && !part->has_polygons) return 1;
    if (!obj_reserve(g, (addition){part, part->first_face, part->face_count}, &state->face_starts,
            &state->face_room, state->face_count + 1, sizeof(uint32_t)))
        return 0;
    for (size_t i = 0; first && i <= state->face_count; ++i)
        state->face_starts[i] = (uint32_t)(3 * i);
    return 1;
}

static int reserve_all(gathering *g, const obj_part *part) {
    obj_state *s = g->state;
    const addition positions = {part, SIZE_MAX, part->position_count},
                   normals = {part, part->first_normal, part->normal_count},
                   corners = {part, part->first_face, part->corner_count},
                   others = {part, SIZE_MAX, part->other_count};
    return (!positions.count || obj_reserve(g, positions, &s->positions, &s->position_room,
                                    s->position_count, 3 * sizeof(double))) &&
           (!corners.count || obj_reserve(g, corners, &s->corners, &s->corner_room, s->corner_count,
                                  sizeof(uint32_t))) &&
           (!normals.count || obj_reserve(g, normals, &s->normals, &s->normal_room, s->normal_count,
                                  3 * sizeof(float))) &&
           (!normals.count || obj_reserve(g, normals, &s->normal_offsets, &s->normal_offset_room,
                                  s->normal_count, sizeof(size_t))) &&
           (!others.count || obj_reserve(g, others, &s->other_normals, &s->other_room,
                                 s->other_count, sizeof(uint32_t))) &&
           reserve_corner_normals(g, part) && reserve_face_starts(g, part);
}

/* ---- in turn */

static int obj_too_many(const obj_state *state, const obj_part *part) {
    return part->position_count > OBJ_MOST - state->position_count ||
           part->normal_count > OBJ_MOST - state->normal_count ||
           part->corner_count > OBJ_MOST - state->corner_count;
}

/* Numbers that count back, now that it is known from where. 0: a position before the first. */
static int resolve_relatives(const obj_state *state, obj_part *part) {
    for (size_t i = 0; i < part->relative_count; ++i) {
        const obj_relative *relative = &part->relatives[i];
        const int64_t value =
            relative->value + (int64_t)(relative->list == OBJ_OF_CORNER ? state->position_count
                                                                        : state->normal_count);
        if (relative->list == OBJ_OF_CORNER) {
            if (value < 0) return 0;
            part->corners[relative->slot] = (uint32_t)value;
        } else if (relative->list == OBJ_OF_CORNER_NORMAL) {
            part->corner_normals[relative->slot] = value < 0 ? OBJ_BAD_NORMAL : (uint32_t)value;
            part->has_normals |= value >= 0;
            part->bad_normal_count += value < 0;
        } else {
            part->other_normals[relative->slot] = value < 0 ? OBJ_BAD_NORMAL : (uint32_t)value;
        }
    }
    return 1;
}

static void add_oddity(obj_oddity *sum, const obj_oddity *oddity) {
    sum->first = sum->count ? sum->first : oddity->first;
    sum->count += oddity->count;
}

static int add_runs(gathering *g, const obj_part *part) {
    obj_state *state = g->state;
    size_t first_face = 0;
    for (size_t i = 0; i <= part->run_count; ++i) {
        const size_t end = i < part->run_count ? part->runs[i].first_face : part->face_count;
        state->has_groups |= g->group != 0 && end > first_face;
        first_face = end;
        if (i == part->run_count || part->runs[i].group == g->group) continue;
        g->group = part->runs[i].group;
        const size_t last = state->run_count - 1;
        if (state->run_count && state->runs[last].first_face == state->face_count + end)
            state->run_count = last; /* no face lies between */
        obj_run *run = norma_io_add(&state->runs, &state->run_room, &state->run_count, sizeof *run);
        if (!run) return 0;
        *run = (obj_run){state->face_count + end, g->group};
    }
    return 1;
}

static int take_name(obj_state *state, const obj_part *part) {
    if (state->name || !part->name) return 1;
    const size_t length = (size_t)(part->name_end - part->name);
    state->name = norma_io_allocate(length + 1, 1);
    if (state->name) memcpy(state->name, part->name, length);
    return state->name != NULL;
}

static void add_counts(gathering *g, const obj_part *part) {
    obj_state *state = g->state;
    state->position_count += part->position_count;
    state->corner_count += part->corner_count;
    state->face_count += part->face_count;
    state->normal_count += part->normal_count;
    state->offset_count = state->normal_count;
    state->other_count += part->other_count;
    state->bad_normal_count += part->bad_normal_count;
    state->has_normals |= part->has_normals;
    state->has_surfaces |= part->has_surfaces;
    state->has_long_positions |= part->has_long_positions;
    if (state->block == SIZE_MAX)
        state->block =
            part->first_normal < part->first_face ? part->first_normal : part->first_face;
    if (state->first_library == SIZE_MAX) state->first_library = part->first_library;
    if (part->last_library != SIZE_MAX) state->last_library = part->last_library;
    g->last_position =
        part->last_position > g->last_position ? part->last_position : g->last_position;
    g->last_normal = part->last_normal > g->last_normal ? part->last_normal : g->last_normal;
    g->known |= part->known;
    add_oddity(&g->unknown, &part->unknown);
    add_oddity(&g->empty_face, &part->empty_face);
    add_oddity(&g->odd_number, &part->odd_number);
}

static norma_document_result take_turn(gathering *g, obj_part *part, size_t index, place *to) {
    obj_state *state = g->state;
    if (part->result) return part->result;
    if (obj_too_many(state, part)) return NORMA_DOCUMENT_ERROR_UNSUPPORTED;
    if (!resolve_relatives(state, part)) return NORMA_DOCUMENT_ERROR_MALFORMED;
    if (!reserve_all(g, part) || !add_runs(g, part) || !take_name(state, part))
        return NORMA_DOCUMENT_ERROR_MEMORY;
    to->at = (obj_stretch){(size_t)(part->begin - g->text), state->position_count,
        state->normal_count, state->face_count, state->other_count};
    to->corner = state->corner_count;
    to->with_normals = state->corner_normals != NULL;
    to->with_faces = state->face_starts != NULL;
    state->stretches[index] = to->at;
    add_counts(g, part);
    return NORMA_DOCUMENT_OK;
}

/* ---- side by side */

/* In slices, so that a cancel is noticed soon also in a stretch that is one long line. */
static void copy_list(const gathering *g, void *to, const void *from, size_t size) {
    const size_t slice = (size_t)1 << 24;
    for (size_t at = 0; at < size && (at == 0 || !norma_watch_cancelled(g->watch)); at += slice)
        memcpy((char *)to + at, (const char *)from + at, size - at < slice ? size - at : slice);
}

static void copy_part(const gathering *g, const obj_part *part, const place *to) {
    const obj_state *state = g->state;
    if (part->position_count)
        copy_list(g, state->positions + 3 * to->at.position, part->positions,
            part->position_count * 3 * sizeof(double));
    if (part->normal_count) {
        copy_list(g, state->normals + 3 * to->at.normal, part->normals,
            part->normal_count * 3 * sizeof(float));
        copy_list(g, state->normal_offsets + to->at.normal, part->normal_offsets,
            part->normal_count * sizeof(size_t));
    }
    if (part->other_count)
        copy_list(g, state->other_normals + to->at.other, part->other_normals,
            part->other_count * sizeof(uint32_t));
    if (part->corner_count)
        copy_list(
            g, state->corners + to->corner, part->corners, part->corner_count * sizeof(uint32_t));
    if (part->corner_count && part->names_normals)
        copy_list(g, state->corner_normals + to->corner, part->corner_normals,
            part->corner_count * sizeof(uint32_t));
    else if (part->corner_count && to->with_normals)
        memset(state->corner_normals + to->corner, 0xff, part->corner_count * sizeof(uint32_t));
    for (size_t i = 0; to->with_faces && i < part->face_count; ++i)
        state->face_starts[to->at.face + i + 1] = (uint32_t)to->corner + part->face_ends[i];
}

static spare_part *get_spare(gathering *g) {
    pthread_mutex_lock(&g->lock);
    spare_part *spare = g->spares;
    if (spare) g->spares = spare->next;
    const int failed = g->result != NORMA_DOCUMENT_OK;
    pthread_mutex_unlock(&g->lock);
    if (!spare) spare = norma_io_allocate(1, sizeof *spare);
    if (spare && failed)
        spare->part.result =
            NORMA_DOCUMENT_ERROR_MALFORMED; /* not read: an earlier one has failed */
    else if (spare)
        spare->part.result = NORMA_DOCUMENT_OK;
    return spare;
}

static void gather_stretch(void *context, size_t index) {
    gathering *g = context;
    spare_part *spare = get_spare(g);
    place to = {.with_normals = 0};
    if (spare && !spare->part.result) {
        obj_part *part = &spare->part;
        part->text = g->text;
        part->begin = g->text + g->state->stretches[index].offset;
        part->end = index + 1 < g->state->stretch_count
                        ? g->text + g->state->stretches[index + 1].offset
                        : g->end;
        norma_obj_read_part(g->document, part, NULL);
    }
    pthread_mutex_lock(&g->lock);
    while (g->turn != index) norma_watch_wait(g->watch, &g->moved, &g->lock);
    if (!g->result)
        g->result = spare ? take_turn(g, &spare->part, index, &to) : NORMA_DOCUMENT_ERROR_MEMORY;
    const int taken = !g->result;
    ++g->turn;
    g->copying += (size_t)taken;
    pthread_cond_broadcast(&g->moved);
    pthread_mutex_unlock(&g->lock);
    if (taken) copy_part(g, &spare->part, &to);
    pthread_mutex_lock(&g->lock);
    g->copying -= (size_t)taken;
    if (spare) {
        spare->next = g->spares;
        g->spares = spare;
    }
    pthread_cond_broadcast(&g->moved);
    pthread_mutex_unlock(&g->lock);
}

/* ---- all of it */

static int cut(gathering *g, const char *start) {
    obj_state *state = g->state;
    const size_t most = (size_t)(g->end - start) / STRETCH + 2;
    state->stretches = norma_io_allocate(most + 1, sizeof *state->stretches);
    if (!state->stretches) return 0;
    for (const char *p = start; p < g->end || state->stretch_count == 0;) {
        state->stretches[state->stretch_count++].offset = (size_t)(p - g->text);
        p = g->end - p > STRETCH ? norma_obj_part_end(g->text, p + STRETCH - 1, g->end, g->watch)
                                 : g->end;
    }
    return 1;
}

static norma_document_result gather_all(gathering *g, norma_document_error *error) {
    const norma_options options = {.struct_size = sizeof options,
        .threads = g->document->threads,
        .progress = norma_watch_tell,
        .progress_user = g->watch};
    core_call call;
    norma_result failed = norma_core_begin(&call, &options);
    if (!failed) failed = norma_core_parallel(&call, g->state->stretch_count, gather_stretch, g);
    if (failed) return norma_document_fail_core(g->document, error, failed);
    obj_state *state = g->state;
    state->stretches[state->stretch_count] = (obj_stretch){(size_t)(g->end - g->text),
        state->position_count, state->normal_count, state->face_count, state->other_count};
    return g->result;
}

static void free_spares(gathering *g) {
    while (g->spares) {
        spare_part *next = g->spares->next;
        norma_obj_free_part(&g->spares->part);
        free(g->spares);
        g->spares = next;
    }
}

/* The text from its beginning, for the message. */
static norma_document_result obj_tell(
    const gathering *g, const char *start, norma_document_error *error) {
    obj_part part = {.text = g->text, .begin = start, .end = g->end, .whole = 1};
    norma_document_result result = norma_obj_read_part(g->document, &part, error);
    norma_obj_free_part(&part);
    return result ? result
                  : norma_document_fail(
                        g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, NULL, "not OBJ text");
}

/* ---- what only the whole shows */

/* The first face's line that names a position past the last one. */
static norma_document_result fail_position(
    const gathering *g, const char *start, norma_document_error *error) {
    const obj_state *state = g->state;
    size_t corner = 0;
    const void *asked = start;
    for (const char *p = start; p < g->end && !norma_watch_passed(g->watch, &asked, p);
         p = norma_obj_skip_end(norma_obj_statement_end(p, g->end, g->watch), g->end)) {
        p = norma_obj_skip_blanks(p, g->end);
        if (norma_obj_keyword(p, g->end, &p) != OBJ_FACE) continue;
        for (obj_corner token; !norma_watch_passed(g->watch, &asked, p); p = token.end) {
            p = norma_obj_skip_blanks(p, g->end);
            if (!norma_obj_corner(p, g->end, &token)) break;
            if (state->corners[corner++] < state->position_count) continue;
            char line[24];
            line[norma_number_format_integer(norma_obj_line(g->text, p), line)] = 0;
            return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, line,
                "position %lld of a face, where the file holds %zu positions",
                (long long)token.position, state->position_count);
        }
    }
    return NORMA_DOCUMENT_OK;
}

/* Normals are the part that is computed: what names one that is not there is no reason to refuse
 * the file. */
static void mark_bad_normals(obj_state *state) {
    state->bad_normal_count = 0;
    state->has_normals = 0;
    for (size_t i = 0; state->corner_normals && i < state->corner_count; ++i) {
        if (state->corner_normals[i] == OBJ_NO_NORMAL) continue;
        if (state->corner_normals[i] >= state->normal_count)
            state->corner_normals[i] = OBJ_BAD_NORMAL;
        state->bad_normal_count += state->corner_normals[i] == OBJ_BAD_NORMAL;
        state->has_normals |= state->corner_normals[i] != OBJ_BAD_NORMAL;
    }
}

/* Where a statement's first token stands, for a note: at most 40 bytes of it, and its line. */
static void add_note(
    const gathering *g, norma_document *document, const obj_oddity *oddity, const char *what) {
    if (!oddity->count) return;
    const char *token = norma_obj_skip_blanks(oddity->first, g->end);
    const char *token_end = norma_obj_token_end(token, g->end);
    int length = token_end - token > 40 ? 40 : (int)(token_end - token);
    norma_document_add_note(document, "%zu %s, the first \"%.*s\" in line %zu", oddity->count, what,
        length, token, norma_obj_line(g->text, token));
}

static norma_document_result obj_fail_unknown(const gathering *g, norma_document_error *error) {
    char line[24];
    const char *word = g->unknown.first, *word_end = norma_obj_token_end(word, g->end);
    line[norma_number_format_integer(norma_obj_line(g->text, word), line)] = 0;
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, line,
        "\"%.*s\" where an OBJ statement was expected",
        word_end - word > 40 ? 40 : (int)(word_end - word), word);
}

static norma_document_result obj_check_whole(
    gathering *g, const char *start, norma_document *document, norma_document_error *error) {
    obj_state *state = g->state;
    if (!g->known && g->unknown.count) return obj_fail_unknown(g, error);
    if (state->corner_count && g->last_position >= state->position_count)
        return fail_position(g, start, error);
    if (g->last_normal >= state->normal_count) mark_bad_normals(state);
    for (size_t i = 0; i < state->other_count; ++i)
        if (state->other_normals[i] >= state->normal_count)
            state->other_normals[i] = OBJ_BAD_NORMAL;
    add_note(g, document, &g->unknown,
        "statements of kinds that OBJ does not have are kept as they are");
    add_note(g, document, &g->empty_face, "faces without a corner are kept as they are");
    add_note(
        g, document, &g->odd_number, "numbers are followed by other characters, which are ignored");
    return NORMA_DOCUMENT_OK;
}

static int is_utf16(const unsigned char *bytes, size_t size) {
    return size >= 2 &&
           ((bytes[0] == 0xfe && bytes[1] == 0xff) || (bytes[0] == 0xff && bytes[1] == 0xfe) ||
               (!bytes[0] && bytes[1]) || (bytes[0] && !bytes[1]));
}

static norma_document_result obj_gather(
    gathering *g, const char *start, norma_document *document, norma_document_error *error) {
    if (!cut(g, start) || pthread_mutex_init(&g->lock, NULL))
        return norma_document_fail_memory(document, error);
    if (pthread_cond_init(&g->moved, NULL)) {
        pthread_mutex_destroy(&g->lock);
        return norma_document_fail_memory(document, error);
    }
    norma_document_result result = gather_all(g, error);
    free_spares(g);
    pthread_cond_destroy(&g->moved);
    pthread_mutex_destroy(&g->lock);
    if (result == NORMA_DOCUMENT_ERROR_MEMORY) return norma_document_fail_memory(document, error);
    if (result == NORMA_DOCUMENT_ERROR_MALFORMED || result == NORMA_DOCUMENT_ERROR_UNSUPPORTED)
        return obj_tell(g, start, error);
    if (!result) result = obj_check_whole(g, start, document, error);
    return result;
}

static norma_document_result obj_read(norma_document *document, norma_document_error *error) {
    obj_state *state = document->state;
    const unsigned char *bytes = document->source.data;
    const size_t size = document->source.size;
    gathering g = {.document = document,
        .watch = &document->watch,
        .state = state,
        .text = (const char *)bytes,
        .end = (const char *)bytes + size};
    state->block = state->first_library = state->last_library = SIZE_MAX;
    if (!size)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, NULL,
            "the file is empty; expected OBJ statements");
    if (norma_begins_with_zeros(bytes, size))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, "1",
            "the file begins with zeros; expected OBJ statements");
    if (is_utf16(bytes, size))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "UTF-16 text; expected ASCII or UTF-8 (convert it first)");
    const int marked = size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0;
    return obj_gather(&g, g.text + (marked ? 3 : 0), document, error);
}

/* ---- The state of an OBJ document: read, let go, and read again once its changes have
 * become bytes; and the core's view of it. */

static void free_vertices(obj_vertices *v) {
    if (!v) return;
    free(v->kept_before);
    free(v->numbers);
    free(v->corners);
    free(v->lines);
    free(v);
}

static void free_content(void *content) {
    obj_state *state = content;
    free_vertices(state->vertices);
    free(state->stretches);
    free(state->positions);
    free(state->corners);
    free(state->corner_normals);
    free(state->face_starts);
    free(state->normals);
    free(state->normal_offsets);
    free(state->other_normals);
    free(state->runs);
    free(state->name);
    free(state->shown_normals);
    free(state->group_masks);
    free(state->hard_edges);
}

static int obj_has_edit(const void *content) {
    const obj_state *state = content;
    return state->normals_replaced || state->normals_turned || state->positions_moved ||
           state->faces_reversed || state->reverse_faces || state->drop_faces || state->cut_faces ||
           state->vertices;
}

const edited_format norma_obj_edited = {
    sizeof(obj_state), 1, obj_has_edit, free_content, obj_read, NULL, NULL};

norma_mesh norma_obj_mesh(const obj_state *state) {
    static const double nowhere[3];
    static const uint32_t nothing[1];
    const norma_vec3_view positions = {state->positions ? state->positions : nowhere,
        state->position_count, 0, NORMA_FORMAT_DOUBLE};
    return (norma_mesh){.positions = positions,
        .corners = state->corners ? state->corners : nothing,
        .corner_count = state->corner_count,
        .face_starts = state->face_starts,
        .face_count = state->face_count};
}

/* ---- Smoothing groups of any number of numbers, as the core's masks of 32 bits.
 *
 * Up to 32 groups get a bit each. Of more, only faces that meet at an edge matter to one another:
 * the faces of one group that hang together by edges are a patch, and patches that meet are
 * coloured so that no two of them share a colour, greedily, with 31 colours. Where more would be
 * needed, the patch gets the last bit, and its borders are marked hard. Meeting is judged by the
 * core's own welding, so that it is what the core will see. */

enum { COLOURS = 31 };

static int obj_compare_numbers(const void *a, const void *b) {
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return x < y ? -1 : x > y;
}

/* The groups other than 0 that faces lie in, each once, ascending; NULL: out of memory. */
static int64_t *distinct_groups(const obj_state *state, size_t *count) {
    int64_t *groups = norma_io_allocate(state->run_count + 1, sizeof *groups);
    size_t used = 0;
    if (!groups) return NULL;
    for (size_t i = 0; i < state->run_count; ++i) {
        size_t end = i + 1 < state->run_count ? state->runs[i + 1].first_face : state->face_count;
        if (state->runs[i].group && end > state->runs[i].first_face)
            groups[used++] = state->runs[i].group;
    }
    qsort(groups, used, sizeof *groups, obj_compare_numbers);
    *count = 0;
    for (size_t i = 0; i < used; ++i)
        if (i == 0 || groups[i] != groups[i - 1]) groups[(*count)++] = groups[i];
    return groups;
}

/* For each face its group's place among the distinct ones, from 1, or 0. */
static void number_faces(
    const obj_state *state, const int64_t *groups, size_t count, uint32_t *numbers) {
    for (size_t i = 0; i < state->run_count; ++i) {
        size_t end = i + 1 < state->run_count ? state->runs[i + 1].first_face : state->face_count;
        const int64_t *found = state->runs[i].group ? bsearch(&state->runs[i].group, groups, count,
                                                          sizeof *groups, obj_compare_numbers)
                                                    : NULL;
        for (size_t face = state->runs[i].first_face; face < end; ++face)
            numbers[face] = found ? (uint32_t)(found - groups) + 1 : 0;
    }
}

/* A face along an edge. */
typedef struct side {
    uint32_t low, high; /* the edge's two positions, welded */
    uint32_t group, face, corner;
} side;

static int compare_sides(const void *a, const void *b) {
    const side *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    if (x->group != y->group) return x->group < y->group ? -1 : 1;
    return x->corner < y->corner ? -1 : x->corner > y->corner;
}

typedef struct patches {
    const obj_state *state;
    uint32_t *numbers; /* of each face; masks at the end */
    side *sides;
    size_t side_count;
    uint32_t *root;  /* of each face, a forest towards lower faces */
    uint8_t *colour; /* of each root */
    uint64_t *pairs; /* roots that meet, each way */
    size_t pair_count, pair_room;
    uint8_t *hard;
} patches;

static void list_sides(patches *p, const core_mesh *mesh) {
    const obj_state *state = p->state;
    for (size_t face = 0; face < state->face_count; ++face) {
        size_t begin = norma_obj_face_start(state, face),
               end = norma_obj_face_start(state, face + 1);
        for (size_t c = begin; c < end && p->numbers[face]; ++c) {
            uint32_t a = norma_core_welded(mesh, state->corners[c]);
            uint32_t b = norma_core_welded(mesh, state->corners[c + 1 < end ? c + 1 : begin]);
            if (a != b)
                p->sides[p->side_count++] = (side){
                    a < b ? a : b, a < b ? b : a, p->numbers[face], (uint32_t)face, (uint32_t)c};
        }
    }
    qsort(p->sides, p->side_count, sizeof *p->sides, compare_sides);
}

static size_t edge_end(const patches *p, size_t begin) {
    size_t end = begin + 1;
    while (end < p->side_count && p->sides[end].low == p->sides[begin].low &&
           p->sides[end].high == p->sides[begin].high)
        ++end;
    return end;
}

static void join_patches(patches *p) {
    for (size_t i = 1; i < p->side_count; ++i) {
        const side *a = &p->sides[i - 1], *b = &p->sides[i];
        if (a->low != b->low || a->high != b->high || a->group != b->group) continue;
        norma_core_join_sets(p->root, a->face, b->face);
    }
}

/* The first side of each group at an edge, at most most of them; how many there are. */
static size_t groups_at_edge(
    const patches *p, size_t begin, size_t end, size_t *first, size_t most) {
    size_t count = 0;
    for (size_t i = begin; i < end; ++i)
        if (i == begin || p->sides[i].group != p->sides[i - 1].group) {
            if (count < most) first[count] = i;
            ++count;
        }
    return count;
}

/* Lists the patches that meet; edges of more groups than there are colours are hard. */
static int list_pairs(patches *p) {
    size_t first[COLOURS];
    for (size_t begin = 0, end; begin < p->side_count; begin = end) {
        end = edge_end(p, begin);
        size_t count = groups_at_edge(p, begin, end, first, COLOURS);
        if (count > COLOURS) {
            for (size_t i = begin; i < end; ++i) p->hard[p->sides[i].corner] = 1;
            continue;
        }
        void *grown =
            norma_io_grow(p->pairs, &p->pair_room, p->pair_count + count * count, sizeof *p->pairs);
        if (!grown) return 0;
        p->pairs = grown;
        for (size_t i = 0; i < count; ++i)
            for (size_t k = 0; k < count; ++k)
                if (i != k)
                    p->pairs[p->pair_count++] =
                        (uint64_t)norma_core_set_of(p->root, p->sides[first[i]].face) << 32 |
                        norma_core_set_of(p->root, p->sides[first[k]].face);
    }
    return 1;
}

static int compare_pairs(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

static void colour_patches(patches *p) {
    if (p->pair_count > 0) qsort(p->pairs, p->pair_count, sizeof *p->pairs, compare_pairs);
    for (size_t i = 0; i < p->pair_count;) {
        uint32_t patch = (uint32_t)(p->pairs[i] >> 32), taken = 0;
        for (; i < p->pair_count && (uint32_t)(p->pairs[i] >> 32) == patch; ++i)
            if ((uint32_t)p->pairs[i] < patch)
                taken |= UINT32_C(1) << p->colour[(uint32_t)p->pairs[i]];
        while (p->colour[patch] < COLOURS && taken >> p->colour[patch] & 1) ++p->colour[patch];
    }
}

/* The borders of patches for which no colour was left. */
static void mark_borders(patches *p) {
    for (size_t begin = 0, end; begin < p->side_count; begin = end) {
        end = edge_end(p, begin);
        if (p->sides[begin].group == p->sides[end - 1].group) continue;
        for (size_t i = begin; i < end; ++i)
            if (p->colour[norma_core_set_of(p->root, p->sides[i].face)] == COLOURS)
                p->hard[p->sides[i].corner] = 1;
    }
}

static norma_result colour_groups(patches *p, const core_mesh *mesh) {
    size_t faces = p->state->face_count;
    p->sides = norma_io_allocate(p->state->corner_count, sizeof *p->sides);
    p->root = norma_io_allocate(faces, sizeof *p->root);
    p->colour = norma_io_allocate(faces, 1);
    if (!p->sides || !p->root || !p->colour) return NORMA_ERROR_MEMORY;
    for (size_t face = 0; face < faces; ++face) p->root[face] = (uint32_t)face;
    list_sides(p, mesh);
    join_patches(p);
    if (!list_pairs(p)) return NORMA_ERROR_MEMORY;
    colour_patches(p);
    mark_borders(p);
    for (size_t face = 0; face < faces; ++face)
        p->numbers[face] =
            p->numbers[face] ? UINT32_C(1) << p->colour[norma_core_set_of(p->root, (uint32_t)face)]
                             : 0;
    return NORMA_OK;
}

/* More than 32 groups: colours for patches, over positions welded as the options ask. */
static norma_result mask_many(obj_state *state, const norma_options *options) {
    core_call call;
    core_mesh mesh;
    norma_options quiet = *options;
    quiet.progress = NULL;
    norma_mesh view = norma_obj_mesh(state);
    norma_result result = norma_core_begin(&call, &quiet);
    if (!result) result = norma_core_mesh_shape(&view, &mesh);
    if (!result) result = norma_core_mesh_content(&call, &mesh);
    if (!result) result = norma_core_weld(&call, &mesh);
    if (result) return result;
    patches p = {.state = state,
        .numbers = state->group_masks,
        .hard = norma_io_allocate(state->corner_count, 1)};
    result = p.hard ? colour_groups(&p, &mesh) : NORMA_ERROR_MEMORY;
    free(p.sides);
    free(p.root);
    free(p.colour);
    free(p.pairs);
    norma_core_unweld(&call, &mesh);
    state->hard_edges = p.hard;
    return result;
}

norma_result norma_obj_groups(obj_state *state, const norma_options *options) {
    size_t count;
    int64_t *groups = distinct_groups(state, &count);
    free(state->group_masks);
    free(state->hard_edges);
    state->hard_edges = NULL;
    state->groups_shown = 0;
    state->group_masks = norma_io_allocate(state->face_count, sizeof *state->group_masks);
    if (!groups || !state->group_masks) {
        free(groups);
        return NORMA_ERROR_MEMORY;
    }
    number_faces(state, groups, count, state->group_masks);
    free(groups);
    if (count > 32) return mask_many(state, options);
    for (size_t face = 0; face < state->face_count; ++face)
        if (state->group_masks[face])
            state->group_masks[face] = UINT32_C(1) << (state->group_masks[face] - 1);
    return NORMA_OK;
}
