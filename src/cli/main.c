/* main.c: finds the command. Every command has a file of its own, with its options, its help and
 * its report. */
#include "cli/options/options.h"
#include "cli/process/process.h"
#include <locale.h>
#include <string.h>

static const cli_subcommand *const commands[] = {&cli_subcommand_compute, &cli_subcommand_seams,
    &cli_subcommand_tangents, &cli_subcommand_pack, &cli_subcommand_transform,
    &cli_subcommand_matrix, &cli_subcommand_check, &cli_subcommand_report, &cli_subcommand_explain,
    &cli_subcommand_info, &cli_subcommand_compare, &cli_subcommand_render, &cli_subcommand_view,
    &cli_subcommand_acid, &cli_subcommand_mcp};

static const char introduction[] =
    "Norma computes, transforms and checks surface normals in OBJ, PLY, STL and glTF files.\n"
    "Everything else in a file stays as it is.\n"
    "\n"
    "Examples\n"
    "  norma info chair.obj                             lists what is in the file\n"
    "  norma compute chair.obj -o out.obj               computes normals, with creases at 60 "
    "degrees\n"
    "  norma transform chair.glb -o out.glb --scale 2,1,1\n"
    "  norma matrix --scale 2,0.5,1                     shows which matrix is correct for normals\n"
    "  norma check models/                              checks every mesh file of a folder\n"
    "\n"
    "Commands\n";

static const char ending[] =
    "\n"
    "'norma help COMMAND' or 'norma COMMAND --help' explains a command. "
    "'norma --version' prints the version.\n"
    "Exit status: 0 fine, 1 findings (check, compare, acid), 2 wrong usage, "
    "3 a file could not be\nread or written, "
    "130 interrupted, 143 terminated.\n";

static void print_help(FILE *out) {
    cli_help(out, introduction);
    for (size_t i = 0; i < CLI_COUNT(commands); ++i) {
        fprintf(out, "  %-11s ", commands[i]->name);
        cli_help(out, commands[i]->summary);
        fputc('\n', out);
    }
    cli_help(out, ending);
}

static const cli_subcommand *find_subcommand(const char *name) {
    for (size_t i = 0; i < CLI_COUNT(commands); ++i)
        if (strcmp(commands[i]->name, name) == 0) return commands[i];
    return NULL;
}

static int unknown_subcommand(const char *name) {
    const char *names[CLI_COUNT(commands)], *meant;
    for (size_t i = 0; i < CLI_COUNT(commands); ++i) names[i] = commands[i]->name;
    meant = cli_suggest(name, names, CLI_COUNT(names), sizeof *names);
    if (meant) return cli_usage(NULL, "unknown command '%s'; did you mean %s?", name, meant);
    return cli_usage(NULL, "unknown command '%s'", name);
}

static int help_about(int count, char **names) {
    if (count == 0) {
        print_help(stdout);
        return cli_finish(CLI_OK);
    }
    const cli_subcommand *command = find_subcommand(names[0]);
    if (!command) return unknown_subcommand(names[0]);
    cli_help(stdout, command->help);
    return cli_finish(CLI_OK);
}

/* Among the words before "--". */
static int asks_for_help(int count, char **arguments) {
    for (int i = 0; i < count && strcmp(arguments[i], "--") != 0; ++i)
        if (strcmp(arguments[i], "--help") == 0 || strcmp(arguments[i], "-h") == 0) return 1;
    return 0;
}

int main(int count, char **arguments) {
    (void)setlocale(LC_ALL, "C"); /* whatever was preloaded may have chosen another */
    cli_startup_checks();
    cli_watch_interrupts();
    if (count < 2) {
        print_help(stderr);
        return CLI_USAGE;
    }
    const char *word = arguments[1];
    if (asks_for_help(1, arguments + 1)) return help_about(0, NULL);
    if (strcmp(word, "help") == 0) return help_about(count - 2, arguments + 2);
    if (strcmp(word, "--version") == 0) {
        printf("norma %s\n", norma_version());
        return cli_finish(CLI_OK);
    }
    if (word[0] == '-') return cli_usage(NULL, "unknown option '%s'; a command comes first", word);
    const cli_subcommand *command = find_subcommand(word);
    if (command && asks_for_help(count - 2, arguments + 2)) return help_about(1, arguments + 1);
    return command ? command->run(command, count - 2, arguments + 2) : unknown_subcommand(word);
}
