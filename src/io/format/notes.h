/* notes.h: what a person should know of a document that is no error. */
#ifndef NORMA_IO_FORMAT_NOTES_H
#define NORMA_IO_FORMAT_NOTES_H
#include <norma/document.h>

/* Adds a note; 0 where memory is out (the note is then lost, nothing else). */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int norma_document_add_note(norma_document *document, const char *format, ...);
#endif
