/* mcp.h: norma mcp: the subcommands as tools of the Model Context Protocol. */
#ifndef NORMA_CLI_MCP_MCP_H
#define NORMA_CLI_MCP_MCP_H
#include "cli/options/options.h"
#include "cli/process/process.h"

/* ---- The folders that tools may use. */

typedef struct mcp_roots {
    char **paths; /* without links; the first is where relative paths begin */
    size_t count;
} mcp_roots;

/* NULL, or what was expected. */
const char *mcp_roots_add(mcp_roots *roots, const char *folder);
void mcp_roots_free(mcp_roots *roots);

/* ---- Tools, each of which is a subcommand. */

typedef struct mcp_tool mcp_tool;

/* NULL: no tool has that name, or it writes files and --read-only forbids that. */
const mcp_tool *mcp_tool_find(const char *name, int read_only);
void mcp_tools_list(cli_json *json, int read_only);

enum { MCP_MOST_WORDS = 40, MCP_DEFAULT_BYTES = 2000, MCP_MOST_BYTES = 200000 };

typedef struct mcp_request {
    const mcp_tool *tool;
    const cli_subcommand *command;
    char *words[MCP_MOST_WORDS]; /* its command line */
    int count;
    const char *given; /* the file that the answer is about, as it was named: the message's */
    size_t max_bytes;  /* of text, and of structured content */
    char fault[MCP_DEFAULT_BYTES + 48]; /* what is wrong with the call */
} mcp_request;

/* Reads a tool's arguments. 0: request->fault says what is wrong. */
int mcp_request_read(
    mcp_request *request, const mcp_tool *tool, cli_value arguments, const mcp_roots *roots);
void mcp_request_free(mcp_request *request);

/* ---- What a subcommand printed becomes a result of the protocol. */

typedef struct mcp_printed {
    const char *out, *err;
    size_t out_size, err_size;
    int status;       /* its exit status */
    const char *lost; /* why it ended without one; or NULL */
} mcp_printed;

typedef enum mcp_kind { MCP_REPORT, MCP_CHECK, MCP_PICTURE, MCP_WORDS } mcp_kind;
mcp_kind mcp_tool_kind(const mcp_tool *tool);
const char *mcp_tool_name(const mcp_tool *tool);
int mcp_tool_writes(const mcp_tool *tool);

/* Adds content, structuredContent and isError to the object that is open. */
void mcp_write_result(cli_json *json, const mcp_request *request, const mcp_printed *printed);
/* The same for a call that was refused. */
void mcp_write_refusal(cli_json *json, const char *why);
#endif
