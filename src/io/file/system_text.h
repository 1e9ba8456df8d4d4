/* system_text.h: what an error number of the system means. */
#ifndef NORMA_IO_SYSTEM_TEXT_H
#define NORMA_IO_SYSTEM_TEXT_H

/* A few English words, whatever the locale; NULL for a number that has none here. */
const char *norma_system_text(int error);
#endif
