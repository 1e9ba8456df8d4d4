/* mcp_command.c: norma mcp: a server of the Model Context Protocol (modelcontextprotocol.io) on
 * standard input and output, one JSON-RPC message a line. Versions 2025-06-18 and 2025-11-25 begin
 * with initialize; 2026-07-28 has no beginning, each request names its version. Every call runs its
 * subcommand in a worker process, so that a crash ends the call only, cancelling ends the worker,
 * and memory does not grow. One call runs at a time; the next ones wait. */
#define _POSIX_C_SOURCE 200809L
#include "cli/mcp/mcp.h"
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char mcp_help[] =
    "norma mcp: the commands as tools for an agent (Model Context Protocol)\n"
    "\n"
    "Examples\n"
    "  norma mcp                             a server for the files of this folder\n"
    "  norma mcp --root models --read-only   only looks, and only into this folder\n"
    "\n"
    "Options\n"
    "  --root FOLDER         tools may use files in this folder and below; repeatable. Relative\n"
    "                        paths begin at the first one (the working folder)\n"
    "  --read-only           offers no tool that writes a file\n"
    "\n"
    "Reads requests from standard input and answers on standard output, one JSON message per "
    "line,\n"
    "until the input ends. docs/agents.md says how to add it to an agent and what it may touch.\n"
    "Exit status: 0 the input ended, 2 wrong usage, 3 standard output failed, 130 interrupted.\n";

static const char *const versions[] = {"2026-07-28", "2025-11-25", "2025-06-18"};

enum {
    LONGEST_LINE = 1 << 20,
    MOST_WAITING = 64,
    MOST_PRINTED = 64 << 20, /* by a subcommand */
    GRACE_MS = 2000,         /* from cancelling a worker to killing it */
    PARSE_ERROR = -32700,
    INVALID_REQUEST = -32600,
    METHOD_NOT_FOUND = -32601,
    INVALID_PARAMS = -32602,
    RESOURCE_NOT_FOUND = -32002,
    UNSUPPORTED_VERSION = -32022
};

typedef struct waiting_call {
    char *id, *progress_token; /* as JSON; no token: NULL */
    const mcp_tool *tool;
    cli_parsed *message; /* its arguments are read when its turn comes: files are judged then */
    mcp_request request;
    int modern;             /* in the form of 2026-07-28 */
    const norma_rule *rule; /* a resource is read; else NULL */
} waiting_call;

typedef struct captured {
    int descriptor; /* -1: it has ended */
    char *bytes;    /* with a 0 behind them */
    size_t size, room, taken;
} captured;

typedef struct mcp_server {
    cli_common common;
    mcp_roots roots;
    int read_only;
    const char *fault; /* of an option */

    char *line; /* what was read and is not yet a whole line */
    size_t line_size, line_room;
    int line_is_long, ended;

    waiting_call waiting[MOST_WAITING];
    size_t waiting_count;

    int running, cancelled;
    waiting_call call; /* that runs */
    cli_worker worker;
    captured out, err, channel;
    double told_progress;
    int status; /* of the subcommand; -1: not known yet */
    struct timespec cancelled_at;
    int killed;
} mcp_server;

/* ---- messages */

static char *json_of(cli_value value) { return value.in ? cli_json_sorted(value) : NULL; }

static cli_json mcp_begin_message(void) {
    cli_json json = {.out = stdout};
    cli_json_print(&json, "{jsonrpc: \"2.0\"");
    return json;
}

static void end_message(cli_json *json) {
    cli_json_print(json, "}\n");
    if (fflush(stdout) || ferror(stdout)) exit(CLI_FILE); /* the client has gone */
}

static cli_json begin_answer(const char *id, int modern) {
    cli_json json = mcp_begin_message();
    cli_json_raw(&json, "id", id);
    cli_json_print(&json, modern ? "result: {resultType: \"complete\"" : "result: {");
    return json;
}

static void end_answer(cli_json *json) {
    cli_json_close(json, '}');
    end_message(json);
}

/* id NULL: it could not be read. */
static cli_json begin_error(const char *id, int code, const char *message) {
    cli_json json = mcp_begin_message();
    cli_json_raw(&json, "id", id ? id : "null");
    cli_json_print(&json, "error: {code: %g, message: %s", (double)code, message);
    return json;
}

static void send_error(const char *id, int code, const char *message) {
    cli_json json = begin_error(id, code, message);
    end_answer(&json);
}

/* The end of an answer that changes with the program only, as lists and rules do. */
static void end_constant(cli_json *json, int modern) {
    if (modern) cli_json_print(json, "ttlMs: 3600000, cacheScope: \"public\"");
    end_answer(json);
}

/* ---- what is answered at once */

static void write_server(cli_json *json, const char *key) {
    cli_json_open(json, key, '{');
    cli_json_print(json, "name: \"norma\", title: %s, version: %s}",
        "Norma: surface normals of meshes", norma_version());
}

static void write_abilities(cli_json *json, const mcp_server *server) {
    cli_json_print(json, "capabilities: {tools: {}, resources: {}}, instructions: %s",
        server->read_only
            ? "Checks the normals of mesh files. Begin with check_mesh; render_mesh shows faults; "
              "explain_rule explains a rule. Relative paths begin at the first root."
            : "Checks and fixes the normals of mesh files. Begin with check_mesh: it names the "
              "call of fix_mesh for each fault. render_mesh shows faults; compare_normals "
              "measures a change. Relative paths begin at the first root. Outputs are new files.");
}

static void answer_initialize(const mcp_server *server, const char *id, cli_value params) {
    const char *asked = cli_string(cli_get(params, "protocolVersion")), *chosen = versions[1];
    for (size_t i = 1; i < CLI_COUNT(versions); ++i)
        if (asked && strcmp(asked, versions[i]) == 0) chosen = versions[i];
    cli_json json = begin_answer(id, 0);
    cli_json_string(&json, "protocolVersion", chosen);
    write_server(&json, "serverInfo");
    write_abilities(&json, server);
    end_answer(&json);
}

static void answer_discover(const mcp_server *server, const char *id) {
    cli_json json = begin_answer(id, 1);
    cli_json_print(&json, "supportedVersions: [%s]", versions[0]);
    write_abilities(&json, server);
    cli_json_print(&json, "ttlMs: 3600000, cacheScope: \"public\", _meta: {");
    write_server(&json, "io.modelcontextprotocol/serverInfo");
    cli_json_close(&json, '}');
    end_answer(&json);
}

static void answer_empty(const char *id) {
    cli_json json = begin_answer(id, 0);
    end_answer(&json);
}

#define RULE_URI "norma://rules/"

static void write_resource(cli_json *json, const norma_rule *rule) {
    char uri[sizeof RULE_URI + 8];
    snprintf(uri, sizeof uri, RULE_URI "%s", rule->id);
    cli_json_print(json, "{uri: %s", uri);
}

static void list_resources(cli_json *json) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    cli_json_open(json, "resources", '[');
    for (size_t i = 0; i < count; ++i) {
        write_resource(json, &rules[i]);
        cli_json_print(
            json, "name: %s, title: %s, mimeType: \"text/plain\"}", rules[i].id, rules[i].name);
    }
    cli_json_close(json, ']');
}

/* 0: no list is called so. */
static int answer_list(const mcp_server *server, const char *id, const char *method, int modern) {
    static const char *const methods[] = {
        "tools/list", "resources/list", "resources/templates/list"};
    size_t which = 0;
    while (which < CLI_COUNT(methods) && strcmp(method, methods[which]) != 0) ++which;
    if (which == CLI_COUNT(methods)) return 0;
    cli_json json = begin_answer(id, modern);
    if (which == 0) mcp_tools_list(&json, server->read_only);
    if (which == 1) list_resources(&json);
    if (which == 2) cli_json_print(&json, "resourceTemplates: []");
    end_constant(&json, modern);
    return 1;
}

/* ---- calls */

static void free_call(waiting_call *call) {
    free(call->id);
    free(call->progress_token);
    cli_json_free(call->message);
    mcp_request_free(&call->request);
    *call = (waiting_call){0};
}

static const norma_rule *mcp_rule_of(const char *uri) {
    const size_t length = strlen(RULE_URI);
    return uri && strncmp(uri, RULE_URI, length) == 0 ? cli_find_rule(uri + length) : NULL;
}

static char *copy_of(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    if (!copy) exit(cli_out_of_memory());
    return strcpy(copy, text);
}

static void queue_call(mcp_server *server, const waiting_call *call) {
    server->waiting[server->waiting_count++] = *call;
}

static void queue_resource(mcp_server *server, const char *id, cli_value params, int modern) {
    const norma_rule *rule = mcp_rule_of(cli_string(cli_get(params, "uri")));
    if (!rule) {
        send_error(id, modern ? INVALID_PARAMS : RESOURCE_NOT_FOUND,
            "no such resource; expected " RULE_URI " and a rule, as resources/list has them");
        return;
    }
    waiting_call call = {.id = copy_of(id), .modern = modern, .rule = rule};
    queue_call(server, &call);
}

static void refuse_call(const char *id, const char *why, int modern) {
    cli_json json = begin_answer(id, modern);
    mcp_write_refusal(&json, why);
    end_answer(&json);
}

/* Takes over the message, if it keeps it: then *message is NULL. */
static void queue_tool(
    mcp_server *server, const char *id, cli_parsed **message, cli_value params, int modern) {
    const char *name = cli_string(cli_get(params, "name"));
    const mcp_tool *tool = name ? mcp_tool_find(name, server->read_only) : NULL;
    if (!tool) {
        send_error(id, INVALID_PARAMS,
            name && mcp_tool_find(name, 0)
                ? "this tool writes files, and the server was started with --read-only"
                : "no such tool; tools/list has their names");
        return;
    }
    const waiting_call call = {.id = copy_of(id),
        .progress_token = json_of(cli_get(cli_get(params, "_meta"), "progressToken")),
        .tool = tool,
        .message = *message,
        .modern = modern};
    *message = NULL;
    queue_call(server, &call);
}

/* ---- the worker of a call */

static void read_captured(captured *from) {
    if (from->room - from->size < 65536) {
        const size_t room = 2 * from->room + 65536;
        char *grown = realloc(from->bytes, room);
        if (!grown) exit(cli_out_of_memory());
        from->bytes = grown;
        from->room = room;
    }
    const ssize_t got =
        read(from->descriptor, from->bytes + from->size, from->room - from->size - 1);
    from->bytes[from->size + (got > 0 ? (size_t)got : 0)] = '\0';
    if (got < 0 && errno == EINTR) return;
    if (got <= 0) {
        close(from->descriptor);
        from->descriptor = -1;
    } else {
        from->size += (size_t)got;
    }
}

static void forget_captured(captured *from) {
    if (from->descriptor >= 0) close(from->descriptor);
    free(from->bytes);
    *from = (captured){.descriptor = -1};
}

/* The subcommand with its own standard streams; its status goes behind the fractions of progress.
 */
static _Noreturn void mcp_run_in_worker(
    const mcp_server *server, const int out[2], const int err[2]) {
    const mcp_request *request = &server->call.request;
    const int nothing = open("/dev/null", O_RDONLY);
    char *words[MCP_MOST_WORDS + 1];
    memcpy((void *)words, (const void *)request->words, sizeof request->words);
    words[request->count] = NULL;
    if (nothing < 0 || dup2(nothing, STDIN_FILENO) < 0 || dup2(out[1], STDOUT_FILENO) < 0 ||
        dup2(err[1], STDERR_FILENO) < 0)
        _exit(CLI_FILE);
    close(out[0]);
    close(err[0]);
    if (server->call.progress_token) cli_progress_send(server->worker.channel);
    int status = request->command->run(request->command, request->count, words);
    if (fflush(stdout)) status = CLI_FILE;
    const double ended = 1000 + status;
    cli_worker_send(&server->worker, &ended, sizeof ended);
    cli_worker_finish(&server->worker);
}

/* The command line of the call whose turn it is. 0: request.fault says what is wrong. */
static int read_call(mcp_server *server) {
    waiting_call *call = &server->call;
    if (call->rule) {
        call->request = (mcp_request){.tool = mcp_tool_find("explain_rule", 1),
            .command = &cli_subcommand_explain,
            .max_bytes = MCP_MOST_BYTES};
        call->request.words[call->request.count++] = copy_of(call->rule->id);
        return 1;
    }
    const cli_value params = cli_get(cli_json_root(call->message), "params");
    return mcp_request_read(
        &call->request, call->tool, cli_get(params, "arguments"), &server->roots);
}

static void begin_call(mcp_server *server) {
    int out[2], err[2];
    server->call = server->waiting[0];
    memmove(
        server->waiting, server->waiting + 1, --server->waiting_count * sizeof server->waiting[0]);
    server->cancelled = server->killed = 0;
    server->told_progress = 0;
    server->status = -1;
    if (!read_call(server)) {
        refuse_call(server->call.id, server->call.request.fault, server->call.modern);
        free_call(&server->call);
        return;
    }
    if (pipe(out)) exit(cli_out_of_memory());
    if (pipe(err)) exit(cli_out_of_memory());
    const int side = cli_worker_start(&server->worker);
    if (side == 0) mcp_run_in_worker(server, out, err);
    close(out[1]);
    close(err[1]);
    if (side < 0) {
        close(out[0]);
        close(err[0]);
        refuse_call(server->call.id, "no process could be started", server->call.modern);
        free_call(&server->call);
        return;
    }
    server->out = (captured){.descriptor = out[0]};
    server->err = (captured){.descriptor = err[0]};
    server->channel = (captured){.descriptor = dup(server->worker.channel)};
    server->running = 1;
}

/* What the worker sends: fractions of its progress, and its status behind them, above all of them.
 */
static void take_progress(mcp_server *server) {
    captured *channel = &server->channel;
    double last = server->told_progress, value;
    for (; channel->taken + sizeof value <= channel->size; channel->taken += sizeof value) {
        memcpy(&value, channel->bytes + channel->taken, sizeof value);
        if (value >= 1000)
            server->status = (int)value - 1000;
        else if (value <= 1 && value > last)
            last = value;
    }
    if (last <= server->told_progress || server->cancelled || !server->call.progress_token) return;
    server->told_progress = last;
    cli_json json = mcp_begin_message();
    cli_json_print(&json, "method: \"notifications/progress\", params: {");
    cli_json_raw(&json, "progressToken", server->call.progress_token);
    cli_json_print(&json, "progress: %g, total: 1}", last);
    end_message(&json);
}

static void answer_resource(mcp_server *server) {
    cli_json json = begin_answer(server->call.id, server->call.modern);
    cli_json_open(&json, "contents", '[');
    write_resource(&json, server->call.rule);
    cli_json_print(&json, "mimeType: \"text/plain\", text: %s}]", server->out.bytes);
    end_constant(&json, server->call.modern);
}

static void answer_call(mcp_server *server, const mcp_printed *printed) {
    if (server->call.rule && printed->status == CLI_OK) {
        answer_resource(server);
        return;
    }
    cli_json json = begin_answer(server->call.id, server->call.modern);
    mcp_write_result(&json, &server->call.request, printed);
    end_answer(&json);
}

static void end_call(mcp_server *server) {
    char why[CLI_WHY_ROOM];
    const int fine = cli_worker_wait(&server->worker, 1, why);
    const mcp_printed printed = {.out = server->out.bytes,
        .err = server->err.bytes,
        .out_size = server->out.size,
        .err_size = server->err.size,
        .status = server->status,
        .lost = fine && server->status >= 0       ? NULL
                : server->out.size > MOST_PRINTED ? "the answer would be larger than 64 MB"
                                                  : why};
    if (!server->cancelled) answer_call(server, &printed); /* else nobody waits for it */
    free_call(&server->call);
    forget_captured(&server->out);
    forget_captured(&server->err);
    forget_captured(&server->channel);
    server->running = 0;
}

static void stop_worker(mcp_server *server, int number) {
    kill((pid_t)server->worker.process, number);
}

static void cancel(mcp_server *server, cli_value params) {
    char *id = json_of(cli_get(params, "requestId"));
    if (id && server->running && !server->cancelled && strcmp(id, server->call.id) == 0) {
        server->cancelled = 1;
        clock_gettime(CLOCK_MONOTONIC, &server->cancelled_at);
        stop_worker(server, SIGTERM);
    }
    for (size_t i = 0; id && i < server->waiting_count; ++i) {
        if (strcmp(id, server->waiting[i].id) != 0) continue;
        free_call(&server->waiting[i]);
        memmove(server->waiting + i, server->waiting + i + 1,
            (--server->waiting_count - i) * sizeof server->waiting[0]);
        break;
    }
    free(id);
}

/* Whether the worker that was cancelled has had its time to tidy up. */
static void insist(mcp_server *server) {
    struct timespec now;
    if (!server->running || server->killed) return;
    const int too_much = server->out.size > MOST_PRINTED || server->err.size > MOST_PRINTED;
    clock_gettime(CLOCK_MONOTONIC, &now);
    const long waited = (long)(now.tv_sec - server->cancelled_at.tv_sec) * 1000 +
                        (now.tv_nsec - server->cancelled_at.tv_nsec) / 1000000;
    if (!too_much && !(server->cancelled && waited >= GRACE_MS)) return;
    server->killed = 1;
    stop_worker(server, SIGKILL);
}

/* ---- requests */

/* Whether a version stands in the request itself, as 2026-07-28 has it. *refused: it is another. */
static int is_modern(const char *id, cli_value params, int *refused) {
    const cli_value version =
        cli_get(cli_get(params, "_meta"), "io.modelcontextprotocol/protocolVersion");
    const char *asked = cli_string(version);
    *refused = version.in && (!asked || strcmp(asked, versions[0]) != 0);
    if (!*refused) return version.in != NULL;
    cli_json json = begin_error(id, UNSUPPORTED_VERSION, "unsupported protocol version");
    cli_json_print(
        &json, "data: {supported: [%s], requested: %s}", versions[0], asked ? asked : "");
    end_answer(&json);
    return 1;
}

static void answer_request(
    mcp_server *server, const char *id, const char *method, cli_parsed **message) {
    const cli_value params = cli_get(cli_json_root(*message), "params");
    int refused;
    const int modern = is_modern(id, params, &refused);
    if (refused || answer_list(server, id, method, modern)) return;
    if (strcmp(method, "initialize") == 0 && !modern)
        answer_initialize(server, id, params);
    else if (strcmp(method, "server/discover") == 0 && modern)
        answer_discover(server, id);
    else if (strcmp(method, "ping") == 0 && !modern)
        answer_empty(id);
    else if (strcmp(method, "tools/call") == 0)
        queue_tool(server, id, message, params, modern);
    else if (strcmp(method, "resources/read") == 0)
        queue_resource(server, id, params, modern);
    else
        send_error(id, METHOD_NOT_FOUND, "no such method");
}

static int is_id(cli_value id) {
    double number;
    return cli_string(id) || (cli_number_of(id, &number) && number >= -9007199254740992.0 &&
                                 number <= 9007199254740992.0 && number == (double)(int64_t)number);
}

static void answer_line(mcp_server *server, const char *line, size_t size) {
    cli_json_fault fault;
    cli_parsed *parsed = cli_json_parse(line, size, &fault);
    if (!parsed) {
        send_error(NULL, PARSE_ERROR, fault.expected ? fault.expected : "out of memory");
        return;
    }
    const cli_value message = cli_json_root(parsed), id = cli_get(message, "id"),
                    params = cli_get(message, "params");
    const char *method = cli_string(cli_get(message, "method")),
               *version = cli_string(cli_get(message, "jsonrpc"));
    char *text = is_id(id) ? json_of(id) : NULL;
    const int is_answer =
        !method && (cli_get(message, "result").in || cli_get(message, "error").in);
    if (!version || strcmp(version, "2.0") != 0 || (id.in && !text) || (!method && !is_answer) ||
        (params.in && !cli_is_object(params)))
        send_error(text, INVALID_REQUEST,
            "expected a JSON-RPC 2.0 request: an object with jsonrpc, method, and id and params "
            "or not");
    else if (method && text)
        answer_request(server, text, method, &parsed);
    else if (method && strcmp(method, "notifications/cancelled") == 0)
        cancel(server, params);
    free(text);
    cli_json_free(parsed);
}

/* ---- lines */

static int is_blank_line(const char *line, size_t size) {
    for (size_t i = 0; i < size; ++i)
        if (!strchr(" \t\r", line[i]) || !line[i]) return 0;
    return 1;
}

static void take_line(mcp_server *server, const char *line, size_t size) {
    if (server->line_is_long)
        send_error(NULL, INVALID_REQUEST, "expected a line of at most 1 MiB");
    else if (!is_blank_line(line, size))
        answer_line(server, line, size);
    server->line_is_long = 0;
}

/* As many lines as there is room for their calls; the rest stays. */
static void take_lines(mcp_server *server) {
    size_t begin = 0;
    while (server->waiting_count < MOST_WAITING) {
        char *from = server->line + begin;
        const size_t left = server->line_size - begin;
        char *stop = left ? memchr(from, '\n', left) : NULL;
        if (!stop) {
            if (left >= LONGEST_LINE) { /* its end is awaited, its bytes are not kept */
                server->line_is_long = 1;
                begin = server->line_size;
            }
            if (server->ended && begin < server->line_size)
                take_line(server, from, left), begin = server->line_size;
            break;
        }
        take_line(server, from, (size_t)(stop - from));
        begin += (size_t)(stop - from) + 1;
    }
    if (begin) memmove(server->line, server->line + begin, server->line_size - begin);
    server->line_size -= begin;
}

static void mcp_read_lines(mcp_server *server) {
    const ssize_t got =
        read(STDIN_FILENO, server->line + server->line_size, server->line_room - server->line_size);
    if (got > 0) server->line_size += (size_t)got;
    if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) server->ended = 1;
}

/* ---- waiting for whatever comes first */

static void serve(mcp_server *server) {
    for (;;) {
        take_lines(server);
        if (!server->running && server->waiting_count) {
            begin_call(server);
            continue;
        }
        if (server->ended && !server->running && !server->line_size) return;
        captured *const from[] = {&server->out, &server->err, &server->channel};
        const int listens = !server->ended && server->line_size < server->line_room;
        struct pollfd polled[4] = {{.fd = listens ? STDIN_FILENO : -1, .events = POLLIN}};
        for (size_t i = 0; i < 3; ++i)
            polled[i + 1] =
                (struct pollfd){.fd = server->running ? from[i]->descriptor : -1, .events = POLLIN};
        if (poll(polled, 4, server->running && server->cancelled ? 100 : -1) < 0 && errno != EINTR)
            return;
        if (polled[0].revents) mcp_read_lines(server);
        for (size_t i = 0; i < 3; ++i)
            if (polled[i + 1].fd >= 0 && polled[i + 1].revents) read_captured(from[i]);
        if (!server->running) continue;
        take_progress(server);
        insist(server);
        if (server->out.descriptor < 0 && server->err.descriptor < 0 &&
            server->channel.descriptor < 0)
            end_call(server);
    }
}

static const char *mcp_add_root(void *settings, const char *value) {
    mcp_server *server = settings;
    return mcp_roots_add(&server->roots, value);
}

static const cli_option mcp_options[] = {
    {"root", CLI_SET(mcp_add_root)},
    {"read-only", CLI_SETS(mcp_server, read_only, 1)},
};

static int mcp_run(const cli_subcommand *command, int count, char **arguments) {
    mcp_server *server = calloc(1, sizeof *server);
    const char *unused[1];
    cli_words words = {.words = calloc((size_t)count + 1, sizeof *unused)};
    int status = CLI_OK;
    if (server) server->line = malloc(server->line_room = LONGEST_LINE + 65536);
    if (!server || !server->line || !words.words) status = cli_out_of_memory();
    const cli_table tables[] = {{mcp_options, CLI_COUNT(mcp_options), server}};
    if (!status) status = cli_parse(command, tables, 1, count, arguments, &words);
    if (!status && words.count)
        status = cli_usage(command, "unexpected word '%s'; --root names a folder", words.words[0]);
    if (!status && !server->roots.count) {
        const char *expected = mcp_roots_add(&server->roots, ".");
        if (expected) status = cli_usage(command, "working folder: expected %s", expected);
    }
    if (!status && chdir(server->roots.paths[0]))
        status = cli_usage(command, "--root: cannot be entered: %s", strerror(errno));
    if (!status) {
        signal(SIGPIPE, SIG_IGN); /* a client that has gone is seen by the write */
        server->out.descriptor = server->err.descriptor = server->channel.descriptor = -1;
        serve(server);
    }
    if (server) {
        mcp_roots_free(&server->roots);
        free(server->line);
    }
    free(server);
    free((void *)words.words);
    return cli_finish(status);
}

const cli_subcommand cli_subcommand_mcp = {
    "mcp", "offers the commands as tools to an agent (Model Context Protocol)", mcp_help, mcp_run};
