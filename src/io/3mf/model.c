/* model.c: the XML of a 3MF model: objects, their meshes and components, and the build's items; and
 * the same text with some triangles reversed or left out. Source: 3MF Core 1.3, chapters 3 and 4;
 * Production Extension 1.1 for parts other than the root. */
#include "io/3mf/3mf.h"
#include "io/text/text.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CORE       "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
#define PRODUCTION "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
#define INSTANCE   "http://www.w3.org/2001/XMLSchema-instance"

/* Extensions whose parts are read, or say nothing about triangles. */
static const char *const KNOWN[] = {CORE, PRODUCTION,
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07", NULL};

typedef enum tmf_element {
    TMF_OUTSIDE,
    TMF_MODEL,
    TMF_RESOURCES,
    TMF_BUILD,
    TMF_OBJECT,
    TMF_MESH,
    TMF_VERTICES,
    TMF_TRIANGLES,
    TMF_COMPONENTS,
    TMF_VERTEX,
    TMF_TRIANGLE,
    TMF_COMPONENT,
    TMF_ITEM
} tmf_element;

static const struct {
    const char *name;
    tmf_element element, parent;
} ELEMENTS[] = {{"vertex", TMF_VERTEX, TMF_VERTICES}, {"triangle", TMF_TRIANGLE, TMF_TRIANGLES},
    {"model", TMF_MODEL, TMF_OUTSIDE}, {"resources", TMF_RESOURCES, TMF_MODEL},
    {"build", TMF_BUILD, TMF_MODEL}, {"object", TMF_OBJECT, TMF_RESOURCES},
    {"mesh", TMF_MESH, TMF_OBJECT}, {"components", TMF_COMPONENTS, TMF_OBJECT},
    {"vertices", TMF_VERTICES, TMF_MESH}, {"triangles", TMF_TRIANGLES, TMF_MESH},
    {"component", TMF_COMPONENT, TMF_COMPONENTS}, {"item", TMF_ITEM, TMF_BUILD}};
enum { ELEMENT_COUNT = sizeof ELEMENTS / sizeof ELEMENTS[0] };

typedef struct model_reader {
    norma_document *document;
    norma_document_error *error;
    tmf_state *state;
    uint32_t part;
    xml_reader xml;
    /* Before the names of core elements, "" or with a colon; the attribute that names a part. The
     * root declares both. (Some programs use prefixes that nothing declares: no other is looked
     * at.) */
    char prefix[64], path[72], instance[64]; /* the last: of attributes that are not allowed */
    int element, parents[ELEMENT_COUNT], depth;
    size_t skipped; /* unknown elements around what is read now */
    int has_resources, has_build;
    norma_document_result result;
    /* Editing: */
    const norma_mesh_edit *edits;
    growing_bytes *text;
    size_t at, begin; /* copied up to at; where the triangle's tag begins */
    size_t object, triangle;
} model_reader;

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
fail_model(model_reader *r, const char *format, ...) {
    char message[400], place[300];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    snprintf(place, sizeof place, "%.200s:%lu", r->state->parts[r->part].name,
        (unsigned long)norma_xml_line(&r->xml));
    r->result = norma_document_fail(
        r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place, "%s", message);
}

static void fail_model_memory(model_reader *r) {
    r->result = norma_document_fail_memory(r->document, r->error);
}

static void *add_to_list(
    model_reader *r, void *list, size_t *count, size_t *capacity, size_t size) {
    void *added = norma_io_add(list, capacity, count, size);
    if (!added) fail_model_memory(r);
    return added;
}

/* ---- attributes */

static const char *value_of(const char **attributes, const char *name) {
    for (; attributes[0]; attributes += 2)
        if (strcmp(attributes[0], name) == 0) return attributes[1];
    return NULL;
}

/* words: ending with NULL. An attribute that is missing has its default. */
static int is_one_of(const char *const *words, const char *value) {
    while (value && *words && strcmp(*words, value) != 0) ++words;
    return !value || *words;
}

static const char *skip_blanks(const char *text) { return text + strspn(text, " \t\r\n"); }

static int value_as_number(const char *text, double *value) {
    const char *end = text ? text + strlen(text) : NULL;
    const char *first = text ? skip_blanks(text) : NULL;
    const char *after = first ? norma_number_parse(first, end, value) : NULL;
    return after && *skip_blanks(after) == '\0' && isfinite(*value);
}

static int read_id(const char *text, uint32_t *value) {
    int64_t number = 0;
    const char *first = text ? skip_blanks(text) : NULL;
    const char *after =
        first ? norma_number_parse_integer(first, first + strlen(first), &number) : NULL;
    *value = (uint32_t)number;
    return after && *skip_blanks(after) == '\0' && number >= 0 && number < INT32_MAX;
}

/* Twelve numbers, row by row, of a matrix for row vectors. */
static int read_matrix(const char *text, double matrix[16]) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    memcpy(matrix, identity, sizeof identity);
    if (!text) return 1;
    const char *end = text + strlen(text);
    for (int i = 0; i < 12; ++i) {
        double *number = &matrix[i / 3 * 4 + i % 3];
        text = norma_number_parse(skip_blanks(text), end, number);
        if (!text || !isfinite(*number)) return 0;
    }
    return *skip_blanks(text) == '\0';
}

/* ---- what is read */

static void add_object(model_reader *r, const char **attributes) {
    tmf_state *state = r->state;
    const char *name = value_of(attributes, "name");
    char where[300];
    tmf_object *object = add_to_list(
        r, &state->objects, &state->object_count, &state->object_capacity, sizeof *object);
    if (!object) return;
    *object = (tmf_object){.part = r->part,
        .number = (uint32_t)state->object_count - 1,
        .first_component = state->component_count};
    if (!read_id(value_of(attributes, "id"), &object->id)) {
        fail_model(r, "expected an object with an id, a whole number");
        return;
    }
    const char *type = value_of(attributes, "type");
    static const char *const types[] = {
        "model", "solidsupport", "support", "surface", "other", NULL};
    if (!is_one_of(types, type)) {
        fail_model(
            r, "expected model, solidsupport, support, surface or other as an object's type");
        return;
    }
    if (value_of(attributes, "pindex") && !value_of(attributes, "pid")) {
        fail_model(r, "expected a pid beside an object's pindex");
        return;
    }
    object->is_other = type && strcmp(type, "other") == 0;
    snprintf(where, sizeof where, "%.200s%sobject %u", r->part ? state->parts[r->part].name : "",
        r->part ? " " : "", (unsigned)object->id);
    object->name = norma_io_copy_text(name ? name : "", name ? strlen(name) : 0);
    object->where = norma_io_copy_text(where, strlen(where));
    if (!object->name || !object->where) fail_model_memory(r);
}

static void check_unit(model_reader *r, const char *unit) {
    static const char *const units[] = {
        "micron", "millimeter", "centimeter", "inch", "foot", "meter", NULL};
    if (!is_one_of(units, unit))
        fail_model(r,
            "expected micron, millimeter, centimeter, inch, foot or meter as the model's unit; "
            "found %.40s",
            unit);
}

/* Materials and what else may have an id: no two resources have the same (chapter 3.4.2). What is
 * wrong with them otherwise, their own readers say. */
static void add_other_id(model_reader *r, const char **attributes) {
    tmf_state *state = r->state;
    tmf_id other = {.part = r->part};
    if (!read_id(value_of(attributes, "id"), &other.id)) return;
    tmf_id *added =
        add_to_list(r, &state->others, &state->other_count, &state->other_capacity, sizeof *added);
    if (added) *added = other;
}

/* The number of the attribute that declares a prefix, not terminated; of none that of the end. */
static size_t find_declaration(const char **attributes, const char *prefix, size_t length) {
    size_t i = 0;
    for (; attributes[2 * i]; ++i)
        if (strncmp(attributes[2 * i], "xmlns:", 6) == 0 &&
            strncmp(attributes[2 * i] + 6, prefix, length) == 0 && !attributes[2 * i][6 + length])
            break;
    return i;
}

/* Only xml:lang is defined for them, and nothing of a schema's instance (chapter 2.3.2). */
static void check_namespaces(model_reader *r, const char **attributes) {
    for (const char **at = attributes; at[0]; at += 2)
        if (strncmp(at[0], "xmlns:", 6) == 0 && strcmp(at[1], INSTANCE) == 0)
            snprintf(r->instance, sizeof r->instance, "%.60s:", at[0] + 6);
    const size_t length = strlen(r->instance);
    for (; attributes[0] && !r->result; attributes += 2)
        if ((length && strncmp(attributes[0], r->instance, length) == 0) ||
            (strncmp(attributes[0], "xml:", 4) == 0 && strcmp(attributes[0], "xml:lang") != 0))
            fail_model(r, "the attribute %.40s is not allowed in a 3MF", attributes[0]);
}

static int is_required(const model_reader *r, const char *space) {
    const tmf_state *state = r->state;
    for (size_t i = state->required_count; i > 0 && state->required[i - 1].part == r->part; --i)
        if (strcmp(state->required[i - 1].space, space) == 0) return 1;
    return 0;
}

/* Prefixes of the namespaces that a reader has to know (chapter 2.4); each is looked at once,
 * however often it is named: a prefix is shorter than what it stands for. */
static void read_required(model_reader *r, const char **attributes) {
    tmf_state *state = r->state;
    char is_named[XML_MOST_ATTRIBUTES] = {0};
    const char *at = value_of(attributes, "requiredextensions");
    for (at = at ? skip_blanks(at) : ""; *at && !r->result;) {
        const size_t length = strcspn(at, " \t\r\n");
        const size_t found = find_declaration(attributes, at, length);
        const char *space = attributes[2 * found] ? attributes[2 * found + 1] : NULL;
        if (!space) {
            fail_model(r, "requires the extension %.*s, a prefix that <model> does not declare",
                length < 40 ? (int)length : 40, at);
            return;
        }
        at = skip_blanks(at + length);
        if (is_named[found]) continue;
        is_named[found] = 1;
        if (is_one_of(KNOWN, space) || is_required(r, space)) continue;
        tmf_required *added = add_to_list(
            r, &state->required, &state->required_count, &state->required_capacity, sizeof *added);
        if (!added) return;
        *added = (tmf_required){r->part, norma_io_copy_text(space, strlen(space))};
        if (!added->space) fail_model_memory(r);
    }
}

static void add_vertex(model_reader *r, const char **attributes) {
    tmf_object *object = &r->state->objects[r->state->object_count - 1];
    double *position = add_to_list(
        r, &object->positions, &object->vertices, &object->position_capacity, 3 * sizeof *position);
    if (!position) return;
    if (!value_as_number(value_of(attributes, "x"), &position[0]) ||
        !value_as_number(value_of(attributes, "y"), &position[1]) ||
        !value_as_number(value_of(attributes, "z"), &position[2]))
        fail_model(r, "expected a vertex with the numbers x, y and z");
}

static void store_triangle(model_reader *r, const char **attributes) {
    tmf_object *object = &r->state->objects[r->state->object_count - 1];
    uint32_t *corner = add_to_list(
        r, &object->corners, &object->faces, &object->corner_capacity, 3 * sizeof *corner);
    if (!corner) return;
    static const char *const names[] = {"v1", "v2", "v3"};
    for (int i = 0; i < 3; ++i)
        if (!read_id(value_of(attributes, names[i]), &corner[i]) || corner[i] >= object->vertices) {
            fail_model(r,
                "expected %s of a triangle to be one of the %zu vertices, numbered from 0",
                names[i], object->vertices);
            return;
        }
}

static void add_use(
    model_reader *r, const char **attributes, tmf_use **list, size_t *count, size_t *capacity) {
    tmf_use *use = add_to_list(r, list, count, capacity, sizeof *use);
    if (!use) return;
    const char *path = value_of(attributes, r->path);
    use->part = r->part;
    if (!read_id(value_of(attributes, "objectid"), &use->id) ||
        !read_matrix(value_of(attributes, "transform"), use->matrix))
        fail_model(r, "expected an objectid, and a transform of twelve numbers if any");
    else if (path)
        r->result = norma_3mf_add_part(r->document, path, strlen(path), &use->part, r->error);
}

static void begin_element(model_reader *r, const char **attributes) {
    tmf_state *state = r->state;
    switch (r->element) {
    case TMF_MODEL:
        check_unit(r, value_of(attributes, "unit"));
        if (!r->edits) read_required(r, attributes);
        break;
    case TMF_RESOURCES:
        r->has_resources = 1;
        break;
    case TMF_BUILD:
        r->has_build = 1;
        break;
    case TMF_OBJECT:
        if (!r->edits) add_object(r, attributes);
        break;
    case TMF_MESH:
        if (!r->edits) state->objects[state->object_count - 1].has_mesh = 1;
        break;
    case TMF_VERTEX:
        if (!r->edits) add_vertex(r, attributes);
        break;
    case TMF_TRIANGLE:
        r->begin = r->xml.begin;
        if (!r->edits) store_triangle(r, attributes);
        break;
    case TMF_COMPONENT:
        if (r->edits) break;
        add_use(
            r, attributes, &state->components, &state->component_count, &state->component_capacity);
        ++state->objects[state->object_count - 1].component_count;
        break;
    case TMF_ITEM:
        if (!r->edits && r->part == 0)
            add_use(r, attributes, &state->items, &state->item_count, &state->item_capacity);
        break;
    default:
        break;
    }
}

static void read_prefixes(model_reader *r, const char **attributes) {
    static const char xmlns[] = "xmlns";
    const size_t length = sizeof xmlns - 1;
    snprintf(r->prefix, sizeof r->prefix, ":");
    for (; attributes[0]; attributes += 2) {
        const char *name = attributes[0] + length;
        if (strncmp(attributes[0], xmlns, length) != 0 || strlen(name) > sizeof r->prefix - 2)
            continue;
        if (strcmp(attributes[1], CORE) == 0)
            snprintf(r->prefix, sizeof r->prefix, "%s%s", name + (*name == ':'), *name ? ":" : "");
        else if (strcmp(attributes[1], PRODUCTION) == 0 && *name == ':')
            snprintf(r->path, sizeof r->path, "%s:path", name + 1);
    }
}

/* NULL: an element of an extension. */
static const char *core_name(const model_reader *r, const char *name, const char **attributes) {
    const size_t length = strlen(r->prefix);
    const int is_hot = r->element == TMF_VERTICES || r->element == TMF_TRIANGLES;
    if (strncmp(name, r->prefix, length) != 0 || strchr(name + length, ':')) return NULL;
    const char *redeclared = length || is_hot ? NULL : value_of(attributes, "xmlns");
    return redeclared && strcmp(redeclared, CORE) != 0 ? NULL : name + length;
}

static void start_element(model_reader *r) {
    const char *name = r->xml.name, **attributes = r->xml.attributes;
    int i = r->skipped ? ELEMENT_COUNT : 0;
    if (r->element == TMF_OUTSIDE) read_prefixes(r, attributes);
    const char *core = i ? NULL : core_name(r, name, attributes);
    if (!i && r->element <= TMF_BUILD) check_namespaces(r, attributes);
    while (i < ELEMENT_COUNT && (!core || ELEMENTS[i].parent != (tmf_element)r->element ||
                                    strcmp(ELEMENTS[i].name, core) != 0))
        ++i;
    if (i == ELEMENT_COUNT && r->element == TMF_OUTSIDE)
        fail_model(r, "expected <model> of the 3MF core namespace, of 2015/02");
    if (i == ELEMENT_COUNT) {
        if (!r->edits && r->element == TMF_MESH && strstr(name, "trianglesets"))
            r->state->objects[r->state->object_count - 1].has_sets = 1;
        if (!r->edits && r->element == TMF_RESOURCES && !r->skipped) add_other_id(r, attributes);
        ++r->skipped;
        return;
    }
    r->parents[r->depth++] = r->element;
    r->element = (int)ELEMENTS[i].element;
    begin_element(r, attributes);
}

/* ---- editing */

static void copy_text_to(model_reader *r, size_t to) {
    norma_io_append(r->text, r->state->parts[r->part].text + r->at, to - r->at);
    r->at = to;
}

typedef struct tag_value {
    size_t begin, end; /* between its quotes; end 0: not there */
} tag_value;

/* The value of an attribute in a tag that xml.c has read. */
static tag_value find_value(const char *text, size_t at, const char *name) {
    const size_t length = strlen(name);
    tag_value value = {0, 0};
    while (text[at] != '>' && text[at] != '/') {
        at += strcspn(text + at, " \t\r\n/>");
        at += strspn(text + at, " \t\r\n");
        const size_t begin = at, size = strcspn(text + at, " \t\r\n=/>");
        if (text[at] == '>' || text[at] == '/') break;
        at += size;
        at += strcspn(text + at, "'\"");
        const char quote = text[at++];
        const size_t from = at;
        while (text[at] != quote) ++at;
        if (size == length && memcmp(text + begin, name, size) == 0) value = (tag_value){from, at};
        ++at;
    }
    return value;
}

/* Each of v2 and v3, p2 and p3 gets the other's value; attributes may stand in any order. */
static void reverse_triangle(model_reader *r, size_t end) {
    const char *text = r->state->parts[r->part].text;
    static const char *const names[] = {"v2", "v3", "p2", "p3"};
    tag_value values[4], by[4];
    for (int i = 0; i < 4; ++i) values[i] = find_value(text, r->begin, names[i]);
    for (int i = 0; i < 4; ++i) by[i] = values[i ^ 1];
    for (size_t done = 0; done < 4; ++done) { /* in the order of the text */
        int next = -1;
        for (int i = 0; i < 4; ++i)
            if (values[i].end && by[i].end && values[i].begin >= r->at &&
                (next < 0 || values[i].begin < values[next].begin))
                next = i;
        if (next < 0) break;
        copy_text_to(r, values[next].begin);
        norma_io_append(r->text, text + by[next].begin, by[next].end - by[next].begin);
        r->at = values[next].end;
    }
    copy_text_to(r, end);
}

static void edit_triangle(model_reader *r, size_t end) {
    const tmf_object *object = &r->state->objects[r->object];
    const norma_mesh_edit *edit = &r->edits[object->mesh];
    if (norma_edit_says(edit->drop_faces, r->triangle) && !object->has_sets) {
        copy_text_to(r, r->begin);
        r->at = end;
    } else if (norma_edit_says(edit->reverse_faces, r->triangle)) {
        reverse_triangle(r, end);
    }
    ++r->triangle;
}

static void end_element(model_reader *r) {
    if (r->skipped) {
        --r->skipped;
        return;
    }
    if (r->edits && r->element == TMF_TRIANGLE) edit_triangle(r, r->xml.at);
    if (r->edits && r->element == TMF_OBJECT) ++r->object, r->triangle = 0;
    r->element = r->parents[--r->depth];
}

/* ---- parsing */

static void parse_model(model_reader *r) {
    const tmf_part *part = &r->state->parts[r->part];
    const void *asked = part->text;
    r->xml = (xml_reader){.text = part->text, .size = part->size};
    if (norma_watch_cancelled(&r->document->watch))
        r->result = norma_document_fail_cancelled(r->document, r->error);
    for (xml_event event = XML_BEGINS; !r->result && event != XML_DONE;) {
        event = norma_xml_next(&r->xml);
        if (norma_watch_passed(&r->document->watch, &asked, part->text + r->xml.at))
            r->result = norma_document_fail_cancelled(r->document, r->error);
        else if (event == XML_BEGINS)
            start_element(r);
        else if (event == XML_ENDS)
            end_element(r);
        else if (event == XML_WRONG)
            fail_model(r, "%s", r->xml.wrong);
        else if (event == XML_NO_MEMORY)
            fail_model_memory(r);
    }
    if (!r->result && r->part == 0 && (!r->has_resources || !r->has_build))
        fail_model(r, "expected <resources> and <build> in the model");
    norma_xml_free(&r->xml);
}

norma_document_result norma_3mf_read_model(
    norma_document *document, uint32_t part, norma_document_error *error) {
    model_reader r = {.document = document, .error = error, .state = document->state, .part = part};
    parse_model(&r);
    return r.result;
}

norma_document_result norma_3mf_edit_model(norma_document *document, uint32_t object,
    const norma_mesh_edit *edits, growing_bytes *text, norma_document_error *error) {
    const uint32_t part = ((tmf_state *)document->state)->objects[object].part;
    model_reader r = {.document = document,
        .error = error,
        .state = document->state,
        .part = part,
        .object = object,
        .edits = edits,
        .text = text};
    while (r.object && r.state->objects[r.object - 1].part == part) --r.object;
    parse_model(&r);
    if (!r.result) copy_text_to(&r, r.state->parts[part].size);
    return r.result       ? r.result
           : text->failed ? norma_document_fail_memory(document, error)
                          : NORMA_DOCUMENT_OK;
}

/* ---- where meshes are drawn */

enum { USE_DEPTH = 64, FREE_USES = 100000, BYTES_A_USE = 16 };

typedef struct placing {
    norma_document *document;
    norma_document_error *error;
    tmf_object **by_id;
    size_t item, visited, most;
    int mirrored;
} placing;

static int compare_ids(const void *a, const void *b) {
    const tmf_id *one = a, *other = b;
    if (one->part != other->part) return one->part < other->part ? -1 : 1;
    return (one->id > other->id) - (one->id < other->id);
}

static int compare_objects(const void *a, const void *b) {
    const tmf_object *one = *(tmf_object *const *)a, *other = *(tmf_object *const *)b;
    if (one->part != other->part) return one->part < other->part ? -1 : 1;
    return (one->id > other->id) - (one->id < other->id);
}

static const tmf_object *find_object(const placing *p, uint32_t part, uint32_t id) {
    const tmf_state *state = p->document->state;
    tmf_object key = {.part = part, .id = id}, *wanted = &key;
    tmf_object **found =
        bsearch(&wanted, p->by_id, state->object_count, sizeof *p->by_id, compare_objects);
    return found ? *found : NULL;
}

static norma_document_result draw_object(
    placing *p, const tmf_object *object, const double world[16]) {
    tmf_state *state = p->document->state;
    char where[64];
    tmf_node *node =
        norma_io_add(&state->nodes, &state->node_capacity, &state->node_count, sizeof *node);
    if (!node) return norma_document_fail_memory(p->document, p->error);
    snprintf(where, sizeof where, "build item %zu", p->item);
    *node = (tmf_node){.mesh = object->mesh,
        .name = object->name,
        .where = norma_io_copy_text(where, strlen(where))};
    memcpy(node->world, world, sizeof node->world);
    p->mirrored |= norma_matrix_determinant(world) < 0;
    return node->where ? NORMA_DOCUMENT_OK : norma_document_fail_memory(p->document, p->error);
}

/* above: the object that has the component; NULL for an item. */
static norma_document_result place_use(
    placing *p, const tmf_use *use, const tmf_object *above, const double parent[16], int depth) {
    const tmf_state *state = p->document->state;
    const tmf_object *object = find_object(p, use->part, use->id);
    double world[16];
    if (!object || (above && above->part == object->part && object->number >= above->number))
        return norma_document_fail(p->document, p->error, NORMA_DOCUMENT_ERROR_MALFORMED,
            above ? above->where : "build", "names object %u, which is not defined before it",
            (unsigned)use->id);
    if (object->is_other && !above)
        return norma_document_fail(p->document, p->error, NORMA_DOCUMENT_ERROR_MALFORMED, "build",
            "draws object %u, which is of the type other", (unsigned)use->id);
    if (depth == USE_DEPTH || p->visited++ == p->most)
        return norma_document_fail(p->document, p->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            above ? above->where : "build",
            "components are nested too deep, or draw far more than the file has bytes");
    norma_matrix_multiply(parent, use->matrix, world);
    if (object->has_mesh) return draw_object(p, object, world);
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < object->component_count && !result; ++i)
        result =
            place_use(p, &state->components[object->first_component + i], object, world, depth + 1);
    return result;
}

static norma_document_result sort_objects(placing *p) {
    const tmf_state *state = p->document->state;
    for (size_t i = 0; i < state->object_count; ++i) p->by_id[i] = &state->objects[i];
    qsort(p->by_id, state->object_count, sizeof *p->by_id, compare_objects);
    for (size_t i = 1; i < state->object_count; ++i)
        if (compare_objects(&p->by_id[i - 1], &p->by_id[i]) == 0)
            return norma_document_fail(p->document, p->error, NORMA_DOCUMENT_ERROR_MALFORMED,
                p->by_id[i]->where, "is defined twice");
    if (state->other_count)
        qsort(state->others, state->other_count, sizeof *state->others, compare_ids);
    for (size_t i = 0; i < state->other_count; ++i) {
        const tmf_id *other = &state->others[i];
        const tmf_object *object = find_object(p, other->part, other->id);
        if (object)
            return norma_document_fail(p->document, p->error, NORMA_DOCUMENT_ERROR_MALFORMED,
                object->where, "has the id of another resource");
        if (i && compare_ids(other - 1, other) == 0)
            return norma_document_fail(p->document, p->error, NORMA_DOCUMENT_ERROR_MALFORMED,
                state->parts[other->part].name, "two resources have the id %u",
                (unsigned)other->id);
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_3mf_place(norma_document *document, norma_document_error *error) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const tmf_state *state = document->state;
    placing p = {.document = document,
        .error = error,
        .most = FREE_USES + state->unpacked / BYTES_A_USE,
        .by_id = norma_io_allocate(state->object_count + 1, sizeof *p.by_id)};
    if (!p.by_id) return norma_document_fail_memory(document, error);
    norma_document_result result = sort_objects(&p);
    for (; p.item < state->item_count && !result; ++p.item)
        result = place_use(&p, &state->items[p.item], NULL, identity, 0);
    if (!result && p.mirrored)
        norma_document_add_note(document,
            "an item of the build is mirrored; 3MF does not say whether its triangles then face "
            "inward (issue 40 of spec_core), so slicers differ");
    free(p.by_id);
    return result;
}
