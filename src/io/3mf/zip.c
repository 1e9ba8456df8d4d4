/* zip.c: zip archives by their directory. What is not replaced keeps its bytes, packed as it is.
 * Source: PKWARE APPNOTE 6.3.10. */
#include "io/3mf/3mf.h"
#include <stdlib.h>
#include <string.h>
#if !defined(__wasm__)
#include <zlib.h>
#endif

enum {
    LOCAL_HEADER = 30,
    ENTRY_HEADER = 46,
    END_HEADER = 22,
    END_64_HEADER = 56,
    LOCATOR_64 = 20,
    COMMENT = 65535,
    ZIP64 = 1,
    STORED = 0,
    DEFLATED = 8,
    ENCRYPTED = 1,
    DESCRIBED_BEHIND = 8
};

static unsigned get_16(const unsigned char *at) { return at[0] | (unsigned)at[1] << 8; }
static uint64_t little_endian(const unsigned char *at, size_t width) {
    uint64_t value = 0;
    for (size_t i = width; i-- > 0;) value = value << 8 | at[i];
    return value;
}
static void put_little_endian(unsigned char *at, size_t width, uint64_t value) {
    for (size_t i = 0; i < width; ++i) at[i] = (unsigned char)(value >> 8 * i);
}
static int has_signature(const unsigned char *at, unsigned char third, unsigned char fourth) {
    return at[0] == 'P' && at[1] == 'K' && at[2] == third && at[3] == fourth;
}

/* ---- the directory */

static int find_end(const unsigned char *bytes, size_t size, size_t *end) {
    if (size < END_HEADER) return 0;
    const size_t last = size - END_HEADER, first = last > COMMENT ? last - COMMENT : 0;
    for (size_t at = last + 1; at-- > first;)
        if (has_signature(bytes + at, 5, 6) && get_16(bytes + at + 20) <= last - at) {
            *end = at;
            return 1;
        }
    return 0;
}

static uint64_t note_field(zip_archive *a, size_t at, size_t width) {
    a->directory_fields[a->directory_field_count++] = (zip_field){at, width};
    return little_endian(a->bytes + at, width);
}

/* How many entries it has, and where they begin: in the end record, or in that of a large archive.
 */
static const char *read_end(zip_archive *a, uint64_t *count) {
    static const char cut[] = "its directory lies outside the file";
    uint64_t start = note_field(a, a->end + 16, 4);
    *count = get_16(a->bytes + a->end + 10);
    if (a->end >= LOCATOR_64 && has_signature(a->bytes + a->end - LOCATOR_64, 6, 7)) {
        const uint64_t at = little_endian(a->bytes + a->end - LOCATOR_64 + 8, 8);
        if (at > a->end || a->end - at < END_64_HEADER || !has_signature(a->bytes + at, 6, 6))
            return cut;
        if (start != UINT32_MAX)
            a->directory_field_count = 1;
        else
            a->directory_field_count = 0;
        start = note_field(a, (size_t)at + 48, 8);
        *count = little_endian(a->bytes + at + 32, 8);
        a->end = (size_t)at;
    }
    a->directory = (size_t)start;
    return start > a->end || *count > (a->end - start) / ENTRY_HEADER ? cut : NULL;
}

/* What is 0xFFFFFFFF stands in the extra field of large archives, in this order. */
static int read_wide(const zip_archive *a, zip_member *m, const unsigned char *extra, size_t size) {
    zip_field *fields[] = {&m->size_field, &m->packed_field, &m->local_field};
    size_t at = 4;
    while (size >= 4 && get_16(extra) != ZIP64) {
        const size_t step = 4 + (size_t)get_16(extra + 2);
        if (step > size) return 0;
        extra += step;
        size -= step;
    }
    for (int i = 0; i < 3; ++i) {
        if (little_endian(a->bytes + fields[i]->at, 4) != UINT32_MAX) continue;
        if (size < 4 || at + 8 > size || at + 8 > 4 + (size_t)get_16(extra + 2)) return 0;
        *fields[i] = (zip_field){(size_t)(extra - a->bytes) + at, 8};
        at += 8;
    }
    return 1;
}

static const char *read_entry(const zip_archive *a, size_t at, zip_member *m, size_t *next) {
    static const char broken[] = "its directory is damaged";
    const unsigned char *entry = a->bytes + at;
    if (a->end - at < ENTRY_HEADER || !has_signature(entry, 1, 2)) return broken;
    const size_t name = get_16(entry + 28), extra = get_16(entry + 30),
                 length = ENTRY_HEADER + name + extra + get_16(entry + 32);
    if (length > a->end - at) return broken;
    *m = (zip_member){.name = (const char *)entry + ENTRY_HEADER,
        .name_length = name,
        .entry = at,
        .flags = get_16(entry + 8),
        .method = get_16(entry + 10),
        .sum = (uint32_t)little_endian(entry + 16, 4),
        .size_field = {at + 24, 4},
        .packed_field = {at + 20, 4},
        .local_field = {at + 42, 4}};
    if (!read_wide(a, m, entry + ENTRY_HEADER + name, extra)) return broken;
    m->size = little_endian(a->bytes + m->size_field.at, m->size_field.width);
    m->packed = little_endian(a->bytes + m->packed_field.at, m->packed_field.width);
    m->local = little_endian(a->bytes + m->local_field.at, m->local_field.width);
    *next = at + length;
    return NULL;
}

static int case_aside(char letter) {
    return letter >= 'A' && letter <= 'Z' ? letter - 'A' + 'a' : letter;
}

/* Shorter names come first. */
static int compare_aside_case(const char *a, size_t a_length, const char *b, size_t b_length) {
    size_t same = 0;
    if (a_length != b_length) return a_length < b_length ? -1 : 1;
    while (same < a_length && case_aside(a[same]) == case_aside(b[same])) ++same;
    return same == a_length ? 0 : case_aside(a[same]) - case_aside(b[same]);
}

static int compare_zip_members(const void *a, const void *b) {
    const zip_member *first = *(const zip_member *const *)a,
                     *second = *(const zip_member *const *)b;
    const int order =
        compare_aside_case(first->name, first->name_length, second->name, second->name_length);
    return order ? order : first < second ? -1 : first > second;
}

const char *norma_zip_read(const unsigned char *bytes, size_t size, zip_archive *a) {
    uint64_t count;
    *a = (zip_archive){.bytes = bytes, .size = size};
    if (!find_end(bytes, size, &a->end)) return "it has no directory at its end";
    const char *wrong = read_end(a, &count);
    if (wrong) return wrong;
    a->members = norma_io_allocate((size_t)count + 1, sizeof *a->members + sizeof *a->by_name);
    if (!a->members) return "";
    a->by_name = (const zip_member **)(a->members + count + 1);
    for (size_t at = a->directory; a->count < count && !wrong; ++a->count) {
        wrong = read_entry(a, at, &a->members[a->count], &at);
        a->by_name[a->count] = &a->members[a->count];
    }
    if (!wrong) qsort(a->by_name, a->count, sizeof *a->by_name, compare_zip_members);
    return wrong;
}

size_t norma_zip_find(const zip_archive *a, const char *name, size_t length) {
    size_t from = 0, to = a->count;
    while (from < to) {
        const size_t middle = from + (to - from) / 2;
        const zip_member *m = a->by_name[middle];
        if (compare_aside_case(m->name, m->name_length, name, length) < 0)
            from = middle + 1;
        else
            to = middle;
    }
    if (from == a->count || compare_aside_case(a->by_name[from]->name,
                                a->by_name[from]->name_length, name, length) != 0)
        return SIZE_MAX;
    return (size_t)(a->by_name[from] - a->members);
}

/* ---- contents */

/* Where its packed bytes begin; 0: they do not fit before the directory. */
static size_t packed_at(const zip_archive *a, const zip_member *m) {
    if (m->local > a->directory || a->directory - m->local < LOCAL_HEADER ||
        !has_signature(a->bytes + m->local, 3, 4))
        return 0;
    const unsigned char *header = a->bytes + m->local;
    const uint64_t begin = m->local + LOCAL_HEADER + get_16(header + 26) + get_16(header + 28);
    return begin <= a->directory && m->packed <= a->directory - begin ? (size_t)begin : 0;
}

/* The checksum of the members' contents, with the polynomial of APPNOTE 4.4.7. */
static uint32_t crc_of(const char *bytes, size_t size) {
    uint32_t table[256], sum = UINT32_MAX;
    for (uint32_t i = 0; i < 256; ++i) {
        table[i] = i;
        for (int bit = 0; bit < 8; ++bit)
            table[i] = table[i] >> 1 ^ (table[i] & 1 ? 0xEDB88320U : 0);
    }
    for (size_t i = 0; i < size; ++i) sum = sum >> 8 ^ table[(sum ^ (unsigned char)bytes[i]) & 255];
    return ~sum;
}

char *norma_zip_unpack(const zip_archive *a, size_t member, const char **wrong) {
    const zip_member *m = &a->members[member];
    const size_t begin = packed_at(a, m), size = (size_t)m->size;
    *wrong = m->flags & ENCRYPTED ? "is encrypted"
             : m->method != STORED && m->method != DEFLATED
                 ? "is packed by another method than deflate"
             : !begin || (m->method == STORED && m->size != m->packed)
                 ? "is not where the zip's directory says"
                 : NULL;
    if (*wrong) return NULL;
    char *text = malloc(size + 1);
    *wrong = "";
    if (!text) return NULL;
    inflate_result status = INFLATE_OK;
    if (m->method == STORED)
        memcpy(text, a->bytes + begin, size);
    else
        status = norma_inflate(a->bytes + begin, (size_t)m->packed, text, size);
    text[size] = '\0';
    if (status == INFLATE_OK && crc_of(text, size) == m->sum) return text;
    free(text);
    if (status != INFLATE_NO_MEMORY)
        *wrong = "is damaged: it does not unpack to the length and checksum that the zip gives";
    return NULL;
}

/* ---- The streams of RFC 1951, through zlib; in a page the host has them. */

#if !defined(__wasm__)
inflate_result norma_inflate(const unsigned char *from, size_t packed, char *to, size_t size) {
    z_stream z = {.next_in = (unsigned char *)(uintptr_t)from, .next_out = (unsigned char *)to};
    int status = inflateInit2(&z, -MAX_WBITS);
    if (status != Z_OK) return INFLATE_NO_MEMORY;
    while (status == Z_OK) { /* zlib counts in 32 bits */
        const size_t in = packed < UINT32_MAX ? packed : UINT32_MAX,
                     out = size < UINT32_MAX ? size : UINT32_MAX;
        z.avail_in = (unsigned)in;
        z.avail_out = (unsigned)out;
        status = inflate(&z, Z_NO_FLUSH);
        packed -= in - z.avail_in;
        size -= out - z.avail_out;
    }
    inflateEnd(&z);
    return status == Z_STREAM_END && size == 0 ? INFLATE_OK
           : status == Z_MEM_ERROR             ? INFLATE_NO_MEMORY
                                               : INFLATE_DAMAGED;
}

unsigned char *norma_deflate(const unsigned char *from, size_t size, size_t *packed) {
    const uLong bound = compressBound((uLong)size) + 64;
    unsigned char *out = malloc(bound);
    z_stream z = {.next_in = (unsigned char *)(uintptr_t)from,
        .avail_in = (unsigned)size,
        .next_out = out,
        .avail_out = (unsigned)bound};
    if (!out || deflateInit2(&z, Z_DEFAULT_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8,
                    Z_DEFAULT_STRATEGY) != Z_OK) {
        free(out);
        return NULL;
    }
    const int status = deflate(&z, Z_FINISH);
    *packed = z.total_out;
    deflateEnd(&z);
    if (status == Z_STREAM_END) return out;
    free(out);
    return NULL;
}
#endif

/* ---- other contents */

/* Its own header, without the lengths of large archives and with those of the new content. */
static void put_local(const zip_archive *a, zip_member *m, growing_bytes *out) {
    unsigned char header[LOCAL_HEADER];
    const unsigned char *local = a->bytes + m->local;
    const size_t name = get_16(local + 26), extra = get_16(local + 28);
    size_t kept = 0;
    memcpy(header, local, LOCAL_HEADER);
    put_little_endian(header + 6, 2, m->flags);
    put_little_endian(header + 14, 4, m->sum);
    put_little_endian(header + 18, 4, m->packed);
    put_little_endian(header + 22, 4, m->size);
    const size_t at = out->size;
    norma_io_append(out, header, LOCAL_HEADER);
    norma_io_append(out, local + LOCAL_HEADER, name);
    const unsigned char *field = local + LOCAL_HEADER + name;
    for (size_t rest = extra; rest >= 4;) {
        const size_t step = 4 + (size_t)get_16(field + 2);
        if (step > rest) break;
        if (get_16(field) != ZIP64) {
            norma_io_append(out, field, step);
            kept += step;
        }
        field += step;
        rest -= step;
    }
    if (!out->failed) put_little_endian((unsigned char *)out->data + at + 28, 2, kept);
}

/* The member as it will be; NULL for its bytes where memory is out. */
static unsigned char *pack(zip_member *m, const growing_bytes *content, size_t *packed) {
    unsigned char *bytes = NULL;
    *packed = content->size;
    if (m->method == DEFLATED) {
        bytes = norma_deflate((const unsigned char *)content->data, content->size, packed);
    } else if ((bytes = malloc(content->size))) {
        memcpy(bytes, content->data, content->size);
    }
    m->flags &= ~(unsigned)DESCRIBED_BEHIND;
    m->size = content->size;
    m->packed = *packed;
    m->sum = crc_of(content->data, content->size);
    return bytes;
}

static int compare_locals(const void *a, const void *b) {
    const zip_member *first = *(const zip_member *const *)a,
                     *second = *(const zip_member *const *)b;
    return first->local != second->local ? (first->local > second->local ? 1 : -1)
                                         : (first > second) - (first < second);
}

static void move_field(const zip_archive *a, zip_field field, uint64_t by, unsigned char *tail) {
    unsigned char *at = tail + (field.at - a->directory);
    put_little_endian(at, field.width, little_endian(at, field.width) + by);
}

static void move_directory(const zip_archive *a, uint64_t by, unsigned char *tail) {
    for (size_t i = 0; i < a->directory_field_count; ++i)
        move_field(a, a->directory_fields[i], by, tail);
    if (a->directory_field_count && a->directory_fields[a->directory_field_count - 1].width == 8) {
        const zip_field locator = {a->end + END_64_HEADER + 8, 8};
        if (has_signature(tail + (locator.at - 8 - a->directory), 6, 7))
            move_field(a, locator, by, tail);
    }
}

/* Its bytes come before end, where the next one begins. */
static const char *replace_member(const zip_archive *a, zip_member m, uint64_t end,
    const growing_bytes *content, unsigned char *tail, growing_bytes *out) {
    const size_t begin = packed_at(a, &m);
    size_t packed;
    if (!begin || begin + m.packed > end) return "parts of it overlap";
    if (content->size > INT32_MAX) return "a part of it would become larger than two gigabytes";
    unsigned char *bytes = pack(&m, content, &packed);
    put_local(a, &m, out);
    if (bytes) norma_io_append(out, bytes, packed);
    free(bytes);
    if (!bytes || out->failed) return "";
    unsigned char *entry = tail + (m.entry - a->directory);
    put_little_endian(entry + 8, 2, m.flags);
    put_little_endian(entry + 16, 4, m.sum);
    put_little_endian(tail + (m.packed_field.at - a->directory), m.packed_field.width, m.packed);
    put_little_endian(tail + (m.size_field.at - a->directory), m.size_field.width, m.size);
    return NULL;
}

/* One after the other as they lie in the archive, which is in out up to at. */
static const char *replace_members(const zip_archive *a, const zip_member **order,
    const growing_bytes *contents, unsigned char *tail, growing_bytes *out) {
    const char *wrong = NULL;
    size_t at = 0;
    for (size_t k = 0; k < a->count && !wrong; ++k) {
        const zip_member *m = order[k];
        const growing_bytes *content = &contents[m - a->members];
        const int is_last = k + 1 == a->count || order[k + 1]->local >= a->directory;
        const uint64_t end = is_last ? a->directory : order[k + 1]->local;
        const int begins = m->local >= at && m->local < a->directory;
        if (begins) move_field(a, m->local_field, (uint64_t)out->size - at, tail);
        if (!content->size) continue;
        if (!begins) return "parts of it overlap";
        norma_io_append(out, a->bytes + at, (size_t)m->local - at);
        wrong = replace_member(a, *m, end, content, tail, out);
        at = (size_t)end;
    }
    norma_io_append(out, a->bytes + at, a->directory - at);
    move_directory(a, (uint64_t)out->size - a->directory, tail);
    return wrong;
}

const char *norma_zip_replace(
    const zip_archive *a, const growing_bytes *contents, growing_bytes *out) {
    const size_t tail_size = a->size - a->directory;
    unsigned char *tail = malloc(tail_size + 1);
    const zip_member **order = malloc((a->count + 1) * sizeof *order);
    const char *wrong = tail && order ? NULL : "";
    if (!wrong) {
        memcpy(tail, a->bytes + a->directory, tail_size);
        memcpy((void *)order, (const void *)a->by_name, a->count * sizeof *order);
        qsort((void *)order, a->count, sizeof *order, compare_locals);
        wrong = replace_members(a, order, contents, tail, out);
    }
    if (!wrong) {
        norma_io_append(out, tail, tail_size);
        wrong = out->failed ? "" : NULL;
    }
    free(tail);
    free((void *)order);
    return wrong;
}
