/* xml.h: XML in memory, tag by tag: what a 3MF's packages and models are written in. */
#ifndef NORMA_IO_3MF_XML_H
#define NORMA_IO_3MF_XML_H
#include "io/file/file.h"

enum { XML_MOST_ATTRIBUTES = 256 }; /* of a tag: each is compared with those before it */

typedef enum xml_event {
    XML_BEGINS, /* an element; <a/> begins and ends */
    XML_ENDS,
    XML_DONE,
    XML_WRONG, /* wrong says why: no XML, a document type or another encoding than UTF-8 */
    XML_NO_MEMORY
} xml_event;

typedef struct xml_span {
    size_t at, length;
} xml_span;

typedef struct xml_reader {
    /* text, which is not owned, ends with a zero byte at text[size]. */
    const char *text;
    size_t size, begin, at;  /* the last event was from begin to at */
    const char *name;        /* of what begins */
    const char **attributes; /* names and values in turn, then NULL; references are replaced */
    char wrong[120];
    char *words; /* where name and attributes point */
    xml_span *open;
    size_t attribute_count, attribute_capacity, word_capacity, depth, open_capacity;
    int started, has_root, is_empty_tag;
} xml_reader;

/* reader: all zero but text and size. After XML_DONE and what stands behind it there it is done. */
xml_event norma_xml_next(xml_reader *reader);
/* The number of the line where the last event began. */
size_t norma_xml_line(const xml_reader *reader);
void norma_xml_free(xml_reader *reader); /* keeps the text */
#endif
