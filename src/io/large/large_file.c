/* large_file.c: a file that is read through a window, in order or by place; memory that counts
 * against a limit; and what the file becomes. */
#include "io/large/large.h"
#include <stdlib.h>
#include <string.h>

/* ---- Blocks of memory that count against a limit, so that work is cut smaller before the
 * system refuses. */

/* 0: more than there is. */
static size_t claim(large_budget *budget, size_t count, size_t size) {
    if (count && size > SIZE_MAX / count) return 0;
    const size_t bytes = count && size ? count * size : 1;
    if (bytes > budget->most - budget->used) return 0;
    budget->used += bytes;
    return bytes;
}

static void release_claim(large_budget *budget, size_t count, size_t size) {
    budget->used -= count && size ? count * size : 1;
}

static void *take_block(large_budget *budget, size_t count, size_t size, int zeroed) {
    const size_t bytes = claim(budget, count, size);
    void *block = !bytes ? NULL : zeroed ? calloc(bytes, 1) : malloc(bytes);
    if (bytes && !block) release_claim(budget, count, size);
    return block;
}

void *norma_large_take(large_budget *budget, size_t count, size_t size) {
    return take_block(budget, count, size, 0);
}

void *norma_large_take_zeroed(large_budget *budget, size_t count, size_t size) {
    return take_block(budget, count, size, 1);
}

void norma_large_give(large_budget *budget, void *block, size_t count, size_t size) {
    if (!block) return;
    release_claim(budget, count, size);
    free(block);
}

void *norma_large_grow(
    large_budget *budget, void *block, size_t old_count, size_t count, size_t size) {
    if (!block) return norma_large_take(budget, count, size);
    if (count <= old_count || !claim(budget, count - old_count, size)) return NULL;
    void *grown = count > SIZE_MAX / size ? NULL : realloc(block, count * size);
    if (!grown) release_claim(budget, count - old_count, size);
    return grown;
}

/* ---- for the core */

static void *large_allocate(void *user, size_t size, size_t alignment) {
    void *block = NULL;
    const size_t bytes = claim(user, 1, size);
    if (!bytes) return NULL;
#if defined(_WIN32)
    block = _aligned_malloc(bytes, alignment);
#else
    if (bytes <= SIZE_MAX - alignment)
        block = aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
#endif
    if (!block) release_claim(user, 1, size);
    return block;
}

static void large_release(void *user, void *block, size_t size) {
    release_claim(user, 1, size);
#if defined(_WIN32)
    _aligned_free(block);
#else
    free(block);
#endif
}

norma_allocator norma_large_allocator(large_budget *budget) {
    return (norma_allocator){large_allocate, large_release, budget};
}

/* ---- A set of vertices, a bit each. Members before one are counted from a number for each word
 * of 64, so that members can be numbered without a list of them. */

static size_t large_words_of(size_t count) { return count / 64 + 1; }

int norma_large_bits_open(large_budget *budget, size_t count, large_bits *bits) {
    *bits = (large_bits){.count = count};
    bits->words = norma_large_take_zeroed(budget, large_words_of(count), sizeof *bits->words);
    bits->before = norma_large_take_zeroed(budget, large_words_of(count), sizeof *bits->before);
    if (bits->words && bits->before) return 1;
    norma_large_bits_close(budget, bits);
    return 0;
}

void norma_large_bits_close(large_budget *budget, large_bits *bits) {
    norma_large_give(budget, bits->words, large_words_of(bits->count), sizeof *bits->words);
    norma_large_give(budget, bits->before, large_words_of(bits->count), sizeof *bits->before);
    *bits = (large_bits){0};
}

void norma_large_bits_clear(large_bits *bits) {
    memset(bits->words, 0, large_words_of(bits->count) * sizeof *bits->words);
}

void norma_large_bits_set_range(large_bits *bits, size_t begin, size_t end) {
    while (begin < end && begin & 63) norma_large_bits_set(bits, begin++);
    while (end > begin && end & 63) norma_large_bits_set(bits, --end);
    if (begin < end) memset(bits->words + begin / 64, 0xff, (end - begin) / 8);
}

/* Without an instruction for it, which not every machine has. */
static uint32_t ones(uint64_t word) {
    word -= word >> 1 & UINT64_C(0x5555555555555555);
    word = (word & UINT64_C(0x3333333333333333)) + (word >> 2 & UINT64_C(0x3333333333333333));
    word = (word + (word >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f);
    return (uint32_t)(word * UINT64_C(0x0101010101010101) >> 56);
}

size_t norma_large_bits_count(large_bits *bits) {
    uint32_t sum = 0;
    for (size_t word = 0; word < large_words_of(bits->count); ++word) {
        bits->before[word] = sum;
        sum += ones(bits->words[word]);
    }
    return sum;
}

size_t norma_large_bits_before(const large_bits *bits, size_t index) {
    const uint64_t below = (UINT64_C(1) << (index & 63)) - 1;
    return bits->before[index / 64] + ones(bits->words[index / 64] & below);
}

/* ---- A file that is read through a window, in order or by place. */

static const size_t MOST_HEADER = (size_t)1 << 19;

static norma_document_result read_beginning(large_file *file) {
    const size_t size = norma_large_some(file->size, MOST_HEADER);
    unsigned char *bytes = malloc(size ? size : 1);
    if (!bytes) return norma_large_fail_memory(file);
    file->document->source = (file_bytes){.data = bytes, .size = size, .owned = 1};
    return norma_large_read(file, 0, bytes, size);
}

static norma_document_result make_document(
    const char *path, norma_file_format format, large_file *file) {
    const norma_document_options opening = {.struct_size = sizeof opening, .format = format};
    file->document = norma_document_make(path, 1, &opening);
    return file->document ? NORMA_DOCUMENT_OK : norma_document_fail_memory(NULL, file->error);
}

static int read_window(void *window, uint64_t offset, void *bytes, size_t size) {
    return norma_window_read(window, offset, bytes, size);
}

norma_document_result norma_large_open(const char *path, const norma_large_options *options,
    norma_file_format format, large_file *file, norma_document_error *error) {
    *file = (large_file){.error = error, .budget = {.most = options->max_memory}, .to = 1};
    const norma_document_result result = make_document(path, format, file);
    if (result) return result;
    const int failed = norma_window_open(path, &file->window);
    if (failed) return norma_large_fail_read(file, failed);
    file->document->stamp = *norma_window_stamp(file->window);
    file->size = file->document->stamp.size;
    file->source = (large_source){read_window, file->window, file->size,
        "does not fit into the memory allowed", "allow more memory"};
    return read_beginning(file);
}

norma_document_result norma_large_open_source(
    const char *path, norma_file_format format, const large_source *source, large_file *file) {
    const norma_document_result result = make_document(path, format, file);
    file->source = *source;
    file->size = source->size;
    return result ? result : read_beginning(file);
}

void norma_large_close(large_file *file) {
    norma_window_close(file->window);
    norma_document_close(file->document);
    *file = (large_file){0};
}

norma_document_result norma_large_fail_memory(large_file *file) {
    return norma_document_fail(file->document, file->error, NORMA_DOCUMENT_ERROR_MEMORY, NULL,
        "out of memory, even in the smallest parts; allow more memory");
}

norma_document_result norma_large_fail_whole(const large_file *file, const char *what) {
    return norma_document_fail(file->document, file->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "%s, and %s; %s", file->source.why, what, file->source.instead);
}

norma_document_result norma_large_fail_read(large_file *file, int system_error) {
    return norma_document_fail_file(
        file->document->path, file->error, "cannot be read", system_error);
}

norma_document_result norma_large_read(
    large_file *file, uint64_t offset, void *bytes, size_t size) {
    const int failed = file->source.read(file->source.user, offset, bytes, size);
    return failed ? norma_large_fail_read(file, failed) : NORMA_DOCUMENT_OK;
}

void norma_large_stage(large_file *file, double from, double to) {
    file->from = from;
    file->to = to;
}

norma_document_result norma_large_tell(large_file *file, double fraction) {
    const double done = file->from + (file->to - file->from) * fraction;
    if (!file->progress || !file->progress(file->progress_user, done < 1 ? done : 1))
        return NORMA_DOCUMENT_OK;
    return norma_document_fail_cancelled(file->document, file->error);
}

/* ---- rows */

int norma_large_reader_open(large_file *file, large_reader *reader) {
    const uint64_t plenty = 16 * (uint64_t)LARGE_BUFFER;
    *reader = (large_reader){.file = file};
    reader->capacity = file->budget.most < plenty ? SMALL_BUFFER : LARGE_BUFFER;
    reader->buffer = norma_large_take(&file->budget, reader->capacity, 1);
    return reader->buffer != NULL;
}

void norma_large_reader_close(large_reader *reader) {
    if (!reader->buffer) return;
    norma_large_give(&reader->file->budget, reader->buffer, reader->capacity, 1);
    reader->buffer = NULL;
}

void norma_large_reader_seek(large_reader *reader, uint64_t offset) {
    if (offset >= reader->offset && offset - reader->offset <= reader->filled) {
        reader->at = (size_t)(offset - reader->offset);
        return;
    }
    reader->offset = offset;
    reader->filled = reader->at = 0;
}

const unsigned char *norma_large_peek(large_reader *reader, size_t size) {
    if (reader->filled - reader->at >= size) return reader->buffer + reader->at;
    const uint64_t end = reader->offset + reader->filled, left = reader->file->size - end;
    if (reader->result || size > reader->capacity || size > reader->filled - reader->at + left)
        return NULL;
    memmove(reader->buffer, reader->buffer + reader->at, reader->filled - reader->at);
    reader->offset += reader->at;
    reader->filled -= reader->at;
    reader->at = 0;
    const size_t more = norma_large_some(left, reader->capacity - reader->filled);
    reader->result = norma_large_read(reader->file, end, reader->buffer + reader->filled, more);
    if (reader->result) return NULL;
    reader->filled += more;
    return reader->buffer;
}

/* ---- What a large file becomes: written whole to a temporary file, changed there where a
 * normal is known only in the end, and put in its place as every output is. */

norma_document_result norma_large_output_open(
    large_file *file, const char *path, const norma_large_options *options, large_output *output) {
    *output = (large_output){.file = file, .path = path};
    norma_document_result result =
        norma_document_check_target(file->document, path, options->in_place, file->error);
    if (!result && norma_file_is_stream(path))
        result =
            norma_document_fail(file->document, file->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
                "does not fit into the memory allowed, and a device or a pipe cannot be written "
                "in passes; give the name of a file");
    if (result) return result;
    const int failed = norma_file_writer_open(path, &output->writer);
    if (failed) return norma_document_fail_file(path, file->error, "cannot be written", failed);
    if (options->in_place && norma_file_same(path, file->document->path))
        norma_file_writer_expect(output->writer, &file->document->stamp);
    return NORMA_DOCUMENT_OK;
}

int norma_large_output_write(void *user, const void *bytes, size_t size) {
    large_output *output = user;
    if (!output->error) output->error = norma_file_writer_write(output->writer, bytes, size);
    output->written += size;
    return output->error;
}

static norma_document_result fail_write(large_output *output, int error) {
    return norma_document_fail_file(output->path, output->file->error, "cannot be written", error);
}

norma_document_result norma_large_output_result(large_output *output) {
    return output->error ? fail_write(output, output->error) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_output_copy(large_output *output, uint64_t begin, uint64_t end) {
    large_file *file = output->file;
    unsigned char *buffer = norma_large_take(&file->budget, SMALL_BUFFER, 1);
    norma_document_result result = buffer ? NORMA_DOCUMENT_OK : norma_large_fail_memory(file);
    for (uint64_t at = begin; at < end && !result;) {
        const size_t size = norma_large_some(end - at, SMALL_BUFFER);
        result = norma_large_read(file, at, buffer, size);
        if (!result) {
            norma_large_output_write(output, buffer, size);
            result = norma_large_output_result(output);
        }
        at += size;
        if (!result) result = norma_large_tell(file, (double)(at - begin) / (double)(end - begin));
    }
    norma_large_give(&file->budget, buffer, SMALL_BUFFER, 1);
    return result;
}

norma_document_result norma_large_output_read(
    large_output *output, uint64_t offset, void *bytes, size_t size) {
    const int error = norma_file_writer_read(output->writer, offset, bytes, size);
    return error ? fail_write(output, error) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_output_patch(
    large_output *output, uint64_t offset, const void *bytes, size_t size) {
    const int error = norma_file_writer_patch(output->writer, offset, bytes, size);
    return error ? fail_write(output, error) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_output_close(
    large_output *output, norma_document_result result, uint64_t *size) {
    large_file *file = output->file;
    if (!output->writer) return result;
    int failed = result ? 0 : norma_file_writer_prepare(output->writer);
    if (failed) result = fail_write(output, failed);
    if (result != NORMA_DOCUMENT_CANCELLED && result != NORMA_DOCUMENT_ERROR_MEMORY &&
        norma_window_has_changed(file->window))
        result = norma_large_fail_read(file, FILE_CHANGED);
    if (result) {
        norma_file_writer_abandon(output->writer);
        return result;
    }
    failed = norma_file_writer_commit(output->writer);
    if (failed) return fail_write(output, failed);
    if (size) *size = output->written;
    return NORMA_DOCUMENT_OK;
}
