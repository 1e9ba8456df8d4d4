/* zip.h: the members of a zip archive in memory. */
#ifndef NORMA_IO_3MF_ZIP_H
#define NORMA_IO_3MF_ZIP_H
#include "io/file/file.h"

typedef struct zip_field { /* a number of the directory: where it is, and its width, 4 or 8 */
    size_t at, width;
} zip_field;

typedef struct zip_member {
    const char *name;             /* in the archive, not terminated */
    size_t name_length, entry;    /* entry: in the directory */
    uint64_t size, packed, local; /* local: offset of its own header */
    zip_field size_field, packed_field, local_field;
    unsigned method, flags;
    uint32_t sum, part; /* part: the caller's, 0 at first */
} zip_member;

typedef struct zip_archive {
    const unsigned char *bytes;  /* not owned */
    size_t size, directory, end; /* offsets of the directory, and of what ends it */
    zip_field directory_fields[2];
    size_t directory_field_count;
    zip_member *members;
    const zip_member **by_name; /* in the same memory */
    size_t count;
} zip_archive;

/* NULL, or what is wrong; "" where memory is out. The caller frees archive->members. */
const char *norma_zip_read(const unsigned char *bytes, size_t size, zip_archive *archive);
/* The first of this name, or SIZE_MAX, O(log(count)). Letters are compared without their case, as
 * OPC has it. */
size_t norma_zip_find(const zip_archive *archive, const char *name, size_t length);
/* The contents, to be freed; archive->members[member].size of them. *wrong as norma_zip_read. */
char *norma_zip_unpack(const zip_archive *archive, size_t member, const char **wrong);
/* Writes the archive to out, which is empty, with other contents for those members whose
 * contents[i].size is not 0, packed by the same method. All else keeps its bytes. */
const char *norma_zip_replace(
    const zip_archive *archive, const growing_bytes *contents, growing_bytes *out);
#endif
