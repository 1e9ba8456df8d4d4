/* report_json.h: reports for programs, one JSON object a line. */
#ifndef NORMA_CLI_REPORT_JSON_H
#define NORMA_CLI_REPORT_JSON_H
#include <stddef.h>
#include <stdio.h>

typedef struct cli_json {
    FILE *out;
    int needs_comma;
} cli_json;
void cli_json_open(cli_json *json, const char *key, char bracket); /* key NULL within an array */
void cli_json_close(cli_json *json, char bracket);
/* text NULL: null. Bytes that are not UTF-8 become U+FFFD. */
void cli_json_string(cli_json *json, const char *key, const char *text);
void cli_json_size(cli_json *json, const char *key, size_t number);
/* Reads back as the same number; null if it is not finite. */
void cli_json_number(cli_json *json, const char *key, double number);
void cli_json_bool(cli_json *json, const char *key, int value);
void cli_json_null(cli_json *json, const char *key);
char *cli_shortest(char text[32], double number); /* the fewest digits that read back as the same */
#endif
