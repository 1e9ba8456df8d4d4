/* entries.c: entries of reports read again. Their hashes were kept, so a report that was written to
 * or cut short meanwhile is seen, wherever that was. */
#include "cli/report/merge.h"
#include "cli/process/errors.h"

static int changed(const report_merge *merged, const report_part *part) {
    if (!merged->files.failed)
        cli_error("%s: byte %llu: the entry of %s changed while the reports were joined",
            merged->files.paths[part->report], (unsigned long long)part->offset, part->path);
    return CLI_FILE;
}

int report_load_part(report_merge *merged, const report_part *part) {
    const size_t size = (size_t)part->size;
    if (!report_grow_entry(merged, size)) return CLI_FILE;
    const size_t got =
        report_files_read(&merged->files, part->report, part->offset, merged->entry, size);
    return got == size && report_hash(REPORT_HASH, merged->entry, size) == part->hash
               ? CLI_OK
               : changed(merged, part);
}

int report_copy_bytes(report_merge *merged, const report_part *part, uint64_t *hash, FILE *out) {
    *hash = REPORT_HASH;
    if (!report_grow_entry(merged, REPORT_BLOCK)) {
        merged->files.failed = 1;
        return 0;
    }
    for (uint64_t at = 0; at < part->size; at += REPORT_BLOCK) {
        const size_t size =
            part->size - at < REPORT_BLOCK ? (size_t)(part->size - at) : REPORT_BLOCK;
        const size_t got =
            report_files_read(&merged->files, part->report, part->offset + at, merged->entry, size);
        if (got < size) return 0;
        *hash = report_hash(*hash, merged->entry, size);
        if (out) fwrite(merged->entry, 1, size, out);
    }
    return 1;
}

int report_copy_part(report_merge *merged, const report_part *part, FILE *out) {
    uint64_t hash;
    return report_copy_bytes(merged, part, &hash, out) && hash == part->hash
               ? CLI_OK
               : changed(merged, part);
}
