/* fuzz.h: what the fuzz targets share: a meter over each input (memory, time, leaks of neither),
 * bytes as numbers, documents in memory.
 *
 * A target is one libFuzzer program. Whatever it finds wrong ends in fuzz_fail, which aborts, so
 * that libFuzzer keeps the input. */
#ifndef NORMA_FUZZ_H
#define NORMA_FUZZ_H
#include <norma/check.h>
#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);
size_t LLVMFuzzerMutate(uint8_t *bytes, size_t size, size_t capacity);
size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t capacity, unsigned seed);

#if defined(__GNUC__)
__attribute__((noreturn, format(printf, 1, 2)))
#endif
void fuzz_fail(const char *format, ...);

/* ---- the meter
 *
 * What is asked of the heap at any one time is at most a base and so many bytes for each byte of
 * the input; time at most FUZZ_SECONDS and one second more for each 128 KiB: a second a megabyte,
 * times eight for the sanitizers. Time is that of the processor, so a busy or a stopped machine is
 * no finding.
 *
 * Readers of OBJ, PLY and STL: 64 KiB and 32 bytes a byte. Files made to need most need 8, 20 (a
 * strip of bytes, of which each is a triangle) and 2. All else, the readers of glTF among it: 2 MiB
 * and 512. A glTF's elements may share their bytes, and what it may stand for is bounded by the
 * reader itself (src/io/gltf/members.c): 256 bytes a byte for what is decoded and 16 corners a
 * byte, of 4 bytes each, twice where normals are missing; and an empty node, of three bytes of
 * JSON, takes 121 bytes for each of them. That is 505 together. Files made to need most need 309
 * (decoded and corners), the largest of the data set 6. */
enum {
    FUZZ_MEMORY_BASE = 1 << 21,
    FUZZ_MEMORY_TIMES = 512,
    FUZZ_PLAIN_BASE = 1 << 16,
    FUZZ_PLAIN_TIMES = 32,
    FUZZ_SECONDS = 2
};
void fuzz_meter_begin(size_t size);       /* the wider bound */
void fuzz_meter_begin_plain(size_t size); /* the narrower one */
void fuzz_meter_end(void);

/* ---- bytes as numbers: zeros behind their end */

typedef struct fuzz_bytes {
    const uint8_t *at;
    size_t left;
} fuzz_bytes;
uint8_t fuzz_u8(fuzz_bytes *bytes);
uint32_t fuzz_u32(fuzz_bytes *bytes);
uint32_t fuzz_below(fuzz_bytes *bytes, uint32_t bound); /* 0 where bound is 0 */
float fuzz_float(fuzz_bytes *bytes);                    /* whole numbers, special ones, any bits */
double fuzz_double(fuzz_bytes *bytes);
void fuzz_take(fuzz_bytes *bytes, void *out, size_t size);

/* Random numbers of a mutator, from its seed alone. */
typedef struct fuzz_random {
    uint64_t state;
} fuzz_random;
uint32_t fuzz_random_u32(fuzz_random *random);
size_t fuzz_random_below(fuzz_random *random, size_t bound); /* 0 where bound is 0 */

/* ---- an allocator that counts, checks what is given back, and may fail */

typedef struct fuzz_allocator {
    norma_allocator allocator;
    size_t live, peak, calls;
    size_t fail_at; /* the call that gets nothing, from 1; 0: none */
} fuzz_allocator;
void fuzz_allocator_start(fuzz_allocator *allocator, size_t fail_at);
void fuzz_allocator_finish(
    fuzz_allocator *allocator); /* fails where something was not given back */

/* Jobs in an order of their own, all on the calling thread. */
void fuzz_backwards(void *user, size_t count, norma_task *task, void *context);

/* ---- documents */

typedef struct fuzz_blob {
    uint8_t *bytes;
    size_t size, capacity;
} fuzz_blob;
int fuzz_blob_write(void *blob, const void *bytes, size_t size); /* a norma_write */

/* Asks a document for all that it can tell; what it answers must make sense. */
void fuzz_read_all(norma_document *document);
/* Opens bytes as a summary, whole, and leniently, and reads all of it: a reader's target is this.
 */
int fuzz_reader(const uint8_t *bytes, size_t size, norma_file_format format);
#endif
