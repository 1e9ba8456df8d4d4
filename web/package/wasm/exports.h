/* exports.h: what JavaScript may call. */
#ifndef NORMA_WEB_EXPORTS_H
#define NORMA_WEB_EXPORTS_H
#define WEB_EXPORT(name) __attribute__((used, export_name(#name))) name
#endif
