/* ply_layout.c: the header is cut out and put before a body of one vertex and one face; the reader
 * of PLY opens that, and computes its normals, which gives the header of the output. Counts are put
 * back line by line. */
#include "mpi/file/ply_layout.h"
#include <stdio.h>
#include <stdlib.h>

enum { MOST_HEADER = 1 << 20, MOST_BODY = 1 << 16 };

static const char END[] = "end_header\n";

/* ---- lines */

static const char *line_end(const char *line) { return strchr(line, '\n') + 1; }

static int is_blank(char letter) { return letter == ' ' || letter == '\t'; }

/* Of "element NAME COUNT" the count, else NULL. */
static const char *count_in(const char *line) {
    const char *end = line_end(line), *at;
    if (strncmp(line, "element", 7) != 0 || !is_blank(line[7])) return NULL;
    for (at = line + 8; is_blank(*at); at++) continue;
    while (at < end && !is_blank(*at)) at++;
    while (at < end && is_blank(*at)) at++;
    return at < end ? at : NULL;
}

/* A copy of the header with other counts; NULL: out of memory. */
static char *with_counts(const char *header, const uint64_t *counts, size_t *size) {
    char *copy = malloc(strlen(header) + 24 * MPI_MOST_ELEMENTS + 1), *to = copy;
    size_t element = 0;
    if (!copy) return NULL;
    for (const char *line = header; *line; line = line_end(line)) {
        const char *count = count_in(line), *rest = count;
        if (!count) count = rest = line_end(line);
        memcpy(to, line, (size_t)(count - line));
        to += count - line;
        if (rest == line_end(line)) continue;
        to += sprintf(to, "%llu", (unsigned long long)counts[element++]);
        while (*rest >= '0' && *rest <= '9') rest++;
        memcpy(to, rest, (size_t)(line_end(line) - rest));
        to += line_end(line) - rest;
    }
    *to = '\0';
    *size = (size_t)(to - copy);
    return copy;
}

static int read_counts(mpi_job *job, const char *header, ply_layout *layout) {
    for (const char *line = header; *line; line = line_end(line)) {
        const char *count = count_in(line);
        if (!count) continue;
        if (layout->element_count == MPI_MOST_ELEMENTS)
            return norma_mpi_fail(job, "%s: has more than %d elements; use norma compute",
                job->input, (int)MPI_MOST_ELEMENTS);
        layout->counts[layout->element_count++] = strtoull(count, NULL, 10);
    }
    return 0;
}

/* ---- the header of the input */

static char *read_header(mpi_job *job) {
    const size_t most = job->size < MOST_HEADER ? (size_t)job->size : MOST_HEADER;
    char *text = malloc(most + 1), *end = NULL;
    if (!text) {
        norma_mpi_fail(job, "%s: out of memory", job->input);
        return NULL;
    }
    int failed = norma_mpi_read(job, 0, text, most);
    text[failed ? 0 : most] = '\0';
    if (!failed && (strncmp(text, "ply", 3) != 0 || !(end = strstr(text, END))))
        failed = norma_mpi_fail(job, "%s: has no PLY header with lines that end in LF", job->input);
    if (failed) {
        free(text);
        return NULL;
    }
    end[sizeof END - 1] = '\0';
    return text;
}

/* ---- one vertex, one face */

static int element_index(const char *header, const char *name) {
    int index = 0;
    for (const char *line = header; *line; line = line_end(line)) {
        if (!count_in(line)) continue;
        const char *at = line + 8;
        while (is_blank(*at)) at++;
        if (strncmp(at, name, strlen(name)) == 0 && is_blank(at[strlen(name)])) return index;
        index++;
    }
    return -1;
}

/* A row of zeros, whose list of corners is (0, 0, 0). Two passes: the first document has no face,
 * and tells the types. */
static size_t make_body(const ply_header *header, unsigned char *body, size_t room) {
    size_t size = 0;
    memset(body, 0, room);
    for (size_t e = 0; e < header->element_count; e++) {
        const ply_element *element = &header->elements[e];
        if ((int)e != header->vertex && (int)e != header->face) continue;
        for (size_t p = 0; p < element->property_count && size + 64 < room; p++) {
            const ply_property *property = norma_ply_property(header, element, (int)p);
            const int corners = (int)e == header->face && (int)p == header->face_list;
            if (!norma_ply_is_list(property)) {
                size += norma_ply_type_size(property->type);
                continue;
            }
            if (corners) norma_ply_put(body + size, property->count_type, header->encoding, 3);
            size += norma_ply_type_size(property->count_type) +
                    (corners ? 3 * norma_ply_type_size(property->type) : 0);
        }
    }
    return size;
}

static int open_small(mpi_job *job, const void *bytes, size_t size, norma_document **document) {
    const norma_document_options options = {
        .struct_size = sizeof options, .format = NORMA_FILE_PLY};
    norma_document_error error;
    if (norma_document_open_memory(bytes, size, job->input, &options, document, &error) ==
        NORMA_DOCUMENT_OK)
        return 0;
    return norma_mpi_fail(job, "%s", error.message);
}

static const ply_header *header_of(const norma_document *document) {
    return &((const ply_state *)document->state)->header;
}

static int open_before(mpi_job *job, const char *header, ply_layout *layout) {
    uint64_t counts[MPI_MOST_ELEMENTS] = {0};
    const int vertex = element_index(header, "vertex"), face = element_index(header, "face");
    size_t size;
    if (vertex < 0 || face < 0)
        return norma_mpi_fail(job,
            "%s: norma-mpi reads PLY files with the elements vertex and face; use norma compute",
            job->input);
    char *text = with_counts(header, counts, &size);
    int failed = text ? open_small(job, text, size, &layout->before)
                      : norma_mpi_fail(job, "%s: out of memory", job->input);
    unsigned char body[MOST_BODY];
    if (!failed && header_of(layout->before)->encoding == PLY_ASCII)
        failed = norma_mpi_fail(job,
            "%s: is ASCII; norma-mpi reads only binary PLY files, use norma compute", job->input);
    const size_t body_size = failed ? 0 : make_body(header_of(layout->before), body, sizeof body);
    norma_document_close(layout->before);
    layout->before = NULL;
    free(text);
    if (failed) return 1;
    counts[vertex] = counts[face] = 1;
    text = with_counts(header, counts, &size);
    layout->small = text ? realloc(text, size + body_size) : NULL;
    if (!layout->small) {
        free(text);
        return norma_mpi_fail(job, "%s: out of memory", job->input);
    }
    memcpy(layout->small + size, body, body_size);
    return open_small(job, layout->small, size + body_size, &layout->before);
}

/* ---- the header of the output */

static int keep_bytes(void *user, const void *bytes, size_t size) {
    ply_layout *layout = user;
    unsigned char *more = realloc(layout->written, layout->written_size + size + 1);
    if (!more) return 1;
    memcpy(more + layout->written_size, bytes, size);
    layout->written = more;
    layout->written_size += size;
    more[layout->written_size] = '\0';
    return 0;
}

static int open_after(mpi_job *job, ply_layout *layout) {
    const norma_compute_options options = {
        .struct_size = sizeof options, .shading = NORMA_SHADING_SMOOTH};
    norma_document *copy = NULL;
    norma_compute_summary summary;
    norma_document_error error;
    const ply_header *header = header_of(layout->before);
    const size_t small =
        header->body + (size_t)(((const ply_state *)layout->before->state)->size - header->body);
    if (open_small(job, layout->small, small, &copy)) return 1;
    norma_document_result result = norma_document_compute(copy, &options, &summary, &error);
    if (!result) result = norma_document_write(copy, keep_bytes, layout, &error);
    norma_document_close(copy);
    if (result) return norma_mpi_fail(job, "%s", error.message);
    return open_small(job, layout->written, layout->written_size, &layout->after);
}

int norma_mpi_plan_output(mpi_job *job, ply_layout *layout) {
    if (open_after(job, layout)) return 1;
    layout->to = header_of(layout->after);
    char *end = strstr((char *)layout->written, END);
    end[sizeof END - 1] = '\0';
    layout->header = with_counts((char *)layout->written, layout->counts, &layout->header_size);
    return layout->header ? 0 : norma_mpi_fail(job, "%s: out of memory", job->input);
}

/* ---- where rows lie */

size_t norma_mpi_offset_in_row(const ply_header *header, const ply_element *element, int property) {
    size_t offset = 0;
    for (int i = 0; i < property; i++)
        offset += norma_ply_type_size(norma_ply_property(header, element, i)->type);
    return offset;
}

static int place_elements(mpi_job *job, ply_layout *layout) {
    const ply_header *header = layout->from;
    uint64_t at = layout->body;
    int seen = 0;
    for (size_t e = 0; e < header->element_count && seen < 2; e++) {
        const ply_element *element = &header->elements[e];
        if ((int)e == header->vertex) layout->vertex_begin = at;
        if ((int)e == header->face) layout->face_begin = at;
        seen += (int)e == header->vertex || (int)e == header->face;
        if (seen == 2 && (int)e == header->face) break;
        if (element->list_count || (int)e == header->face)
            return norma_mpi_fail(job,
                "%s: norma-mpi reads PLY files in which vertices come before faces and nothing "
                "before faces has lists; use norma compute",
                job->input);
        if (element->fixed_size && layout->counts[e] > (job->size - at) / element->fixed_size)
            return norma_mpi_fail(job, "%s: is too short for what its header announces (byte %llu)",
                job->input, (unsigned long long)job->size);
        at += layout->counts[e] * element->fixed_size;
    }
    return 0;
}

int norma_mpi_read_layout(mpi_job *job, ply_layout *layout) {
    char *header = read_header(job);
    *layout = (ply_layout){0};
    if (!header) return 1;
    layout->body = strlen(header);
    int failed = read_counts(job, header, layout) || open_before(job, header, layout);
    free(header);
    if (failed) return 1;
    layout->from = header_of(layout->before);
    if (layout->from->position[0] == PLY_NONE || layout->from->strips != PLY_NONE)
        return norma_mpi_fail(
            job, "%s: norma-mpi reads positions and faces only; use norma compute", job->input);
    layout->vertices = layout->counts[layout->from->vertex];
    layout->faces = layout->counts[layout->from->face];
    layout->has_normals = layout->from->normal[0] != PLY_NONE;
    if (layout->vertices > UINT32_MAX - 1)
        return norma_mpi_fail(job, "%s: has more than 4294967294 vertices", job->input);
    return place_elements(job, layout);
}

void norma_mpi_close_layout(ply_layout *layout) {
    norma_document_close(layout->before);
    norma_document_close(layout->after);
    free(layout->small);
    free(layout->written);
    free(layout->header);
    *layout = (ply_layout){0};
}
