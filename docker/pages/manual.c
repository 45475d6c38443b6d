/* The manual: pages in roff's man macros. */
#include "docker/pages/pages.h"
#include "server/base/topics.h"
#include "server/cli/cli.h"
#include "server/cli/cli_log.h"
#include "server/cli/help.h"

#include <ctype.h>
#include <string.h>

enum { LINE_MAX_BYTES = 78 /* of the source, as its own linters want it */ };

/* One word with what roff would take for something else escaped; returns its bytes. What is between
 * backticks is bold. A word that begins a line must not look like a request. */
static int print_word(FILE *out, struct vor_span_of_text word, int begins_line, int *is_bold)
{
    int bytes = 0;

    if (begins_line && word.length > 0 && (word.at[0] == '.' || word.at[0] == '\''))
        bytes += fprintf(out, "\\&");
    for (size_t i = 0; i < word.length; i++) {
        if (word.at[i] == '-') {
            bytes += fprintf(out, "\\-");
        } else if (word.at[i] == '\\') {
            bytes += fprintf(out, "\\e");
        } else if (word.at[i] == '`' && is_bold != NULL) {
            *is_bold = !*is_bold;
            bytes += fprintf(out, *is_bold ? "\\fB" : "\\fR");
        } else {
            bytes += fprintf(out, "%c", word.at[i]);
        }
    }
    return bytes;
}

/* Text in lines that are not too long; roff fills them anew. Ends its last line. */
static void print_span(FILE *out, struct vor_span_of_text text)
{
    struct vor_span_of_text word;
    int column = 0, is_bold = 0;

    while (vor_markup_word(&word, &text)) {
        if (column > 0 && column + 1 + (int)word.length > LINE_MAX_BYTES) {
            fputc('\n', out);
            column = 0;
        } else if (column > 0) {
            fputc(' ', out);
            column++;
        }
        column += print_word(out, word, column == 0, &is_bold);
    }
    if (column > 0)
        fputc('\n', out);
}

static void print_text(FILE *out, const char *text)
{
    print_span(out, (struct vor_span_of_text){text, strlen(text)});
}

static void print_heading(FILE *out, const char *macro, const char *title)
{
    fprintf(out, "%s \"%s\"\n", macro, title);
}

/* The tag of a paragraph: "-o, --output OUT". */
static void print_tag(FILE *out, char letter, const char *name, const char *value)
{
    fputs(".TP\n", out);
    if (letter != 0)
        fprintf(out, "\\fB\\-%c\\fR, ", letter);
    fputs("\\fB\\-\\-", out);
    print_word(out, (struct vor_span_of_text){name, strlen(name)}, 0, NULL);
    fputs("\\fR", out);
    if (value[0] == '[')
        fprintf(out, "%s", value);
    else if (value[0] != '\0')
        fprintf(out, " \\fI%s\\fR", value);
    fputc('\n', out);
}

static void print_head(FILE *out, const char *section, const char *title, const char *what)
{
    /* Without a date: a page is the same whenever it is built. */
    fprintf(out, ".TH VORONOID %s \"\" \"voronoid %s\" \"%s\"\n", section, VOR_VERSION, title);
    print_heading(out, ".SH", "NAME");
    fprintf(out, "voronoid \\- ");
    print_text(out, what);
}

static void print_exit_codes(FILE *out, int of_serve)
{
    static const struct {
        int code;
        const char *sentence[2];
    } rows[] = {
#define EXIT_ROW(id, code, command, serve) {code, {command, serve}},
        VOR_EXIT_TABLE(EXIT_ROW)
#undef EXIT_ROW
    };

    print_heading(out, ".SH", "EXIT STATUS");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].sentence[of_serve][0] == '\0')
            continue;
        fprintf(out, ".TP\n%d\n", rows[i].code);
        print_text(out, rows[i].sentence[of_serve]);
    }
}

static void print_synopsis(FILE *out)
{
    struct vor_command command;

    print_heading(out, ".SH", "SYNOPSIS");
    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++) {
        fprintf(out, "%s.B voronoid %s\n", i > 0 ? ".br\n" : "", command.name);
        if (command.operands[0] != '\0')
            fprintf(out, ".I %s\\&\n", command.operands + 1);
        fputs(".RI [ OPTION ]...\n", out);
    }
}

static void print_commands(FILE *out)
{
    struct vor_command command;

    print_heading(out, ".SH", "COMMANDS");
    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++) {
        fprintf(out, ".TP\n\\fB%s\\fR\n", command.name);
        print_text(out, command.sentence);
    }
}

/* The names of what `takes` is true for, in a line of their own. */
static void print_takers(FILE *out, int (*takes)(const struct vor_command *command, int row),
                         int row)
{
    char line[512] = "";
    struct vor_command command;
    int count = 0;

    for (unsigned i = 0; vor_cli_command(&command, i) != NULL; i++) {
        size_t at = strlen(line);

        if (takes(&command, row))
            (void)snprintf(line + at, sizeof line - at, "%s%s", count++ > 0 ? ", " : "",
                           command.name);
    }
    fputs(count == 1 ? ".br\nCommand:\n" : ".br\nCommands:\n", out);
    print_text(out, line);
}

static int takes_option(const struct vor_command *command, int row)
{
    return vor_command_takes(command, (enum vor_option)row);
}

static void print_options(FILE *out)
{
    char range[VOR_OPTION_RANGE_SIZE];

    print_heading(out, ".SH", "OPTIONS");
    print_text(out, VOR_HELP_WORDS);
    for (int i = 0; i < VOR_OPTION_COUNT; i++) {
        const struct vor_option_row *o = vor_option_info((enum vor_option)i);

        print_tag(out, o->letter, o->name, vor_option_value(o));
        print_text(out, o->sentence);
        if (vor_option_range(o, range)[0] != '\0')
            fprintf(out, "(%s)\n", range);
        if (o->variable[0] != '\0')
            fprintf(out, "(environment: %s)\n", o->variable);
        if (o->commands != ~0u)
            print_takers(out, takes_option, i);
    }
}

/* Inputs that are options. */
static void print_inputs(FILE *out)
{
    const struct vor_process_info *process;

    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++)
        for (unsigned k = 1; process->inputs[k].name != NULL; k++) {
            print_tag(out, 0, process->inputs[k].name, "FILE");
            print_text(out, process->inputs[k].sentence);
            fprintf(out, ".br\nCommand: %s\n", process->id);
        }
}

/* Lines as they are: example code. */
static void print_code(FILE *out, struct vor_span_of_text text)
{
    struct vor_span_of_text line;

    fputs(".RS 4\n.nf\n", out);
    while (vor_markup_line(&line, &text)) {
        print_word(out, line, 1, NULL);
        fputc('\n', out);
    }
    fputs(".fi\n.RE\n", out);
}

/* Where the topics go; a paragraph that follows a heading needs no macro. */
struct page {
    FILE *out;
    int is_fresh;
};

static void print_block(void *ctx, const struct vor_markup_block *block)
{
    struct page *page = ctx;
    FILE *out = page->out;

    switch (block->kind) {
    case VOR_MARKUP_HEADING:
        fprintf(out, ".SS %.*s\n", (int)block->text.length, block->text.at);
        break;
    case VOR_MARKUP_PARAGRAPH:
        if (!page->is_fresh)
            fputs(".PP\n", out);
        print_span(out, block->text);
        break;
    case VOR_MARKUP_ITEM:
        fputs(".TP\n\\fB", out);
        print_word(out, block->term, 0, NULL);
        fputs("\\fR\n", out);
        print_span(out, block->text);
        break;
    case VOR_MARKUP_CODE:
        if (!page->is_fresh)
            fputs(".PP\n", out);
        print_code(out, block->text);
        break;
    case VOR_MARKUP_TABLE:
        break;
    }
    page->is_fresh = block->kind == VOR_MARKUP_HEADING;
}

/* The topics of one section of the manual, each a section of the page. */
static int print_topics(FILE *out, int section)
{
    struct vor_topic topic;

    for (unsigned i = 0; vor_topic_at(&topic, i); i++) {
        struct page page = {out, 1};

        if (topic.section != section && topic.section != 0)
            continue;
        fputs(".SH \"", out);
        for (int k = 0; k < topic.title_length; k++)
            fputc(toupper((unsigned char)topic.title[k]), out);
        fputs("\"\n", out);
        if (!vor_topic_blocks(&topic, print_block, &page))
            return -1;
    }
    return 0;
}

static int print_commands_page(FILE *out)
{
    print_head(out, "1", "User Commands", "resample 3D point clouds, locally or on a daemon");
    print_synopsis(out);
    print_heading(out, ".SH", "DESCRIPTION");
    print_text(out, "voronoid reads point clouds (PLY or Draco), fits a surface to each cloud "
                    "and spreads the requested number of points evenly over the surface. By "
                    "default it works on this machine; with --server, a daemon does the work. "
                    "Some commands manage the jobs of a daemon. The file name - means stdin or "
                    "stdout. " VOR_HELP_JOBS);
    print_commands(out);
    print_options(out);
    print_inputs(out);
    if (print_topics(out, 1) != 0)
        return -1;
    print_exit_codes(out, 0);
    fputs(".PP\n", out);
    print_text(out, "If a command has several operands and one of them fails, the others still "
                    "run. The exit code is then the code of the first failure.");
    print_heading(out, ".SH", "SEE ALSO");
    fputs(".BR voronoid (8)\n", out);
    return 0;
}

static int print_daemon_page(FILE *out)
{
    print_head(out, "8", "System Administration", "daemon that resamples 3D point clouds");
    print_heading(out, ".SH", "SYNOPSIS");
    fputs(".B voronoid serve\n.RI [ SETTING ]...\n", out);
    print_heading(out, ".SH", "DESCRIPTION");
    print_text(out, "Serves the processes of voronoid(1) over HTTP. The API contract is at "
                    "/openapi.yaml. The daemon writes a job and its input to the disk before "
                    "it accepts the job. Jobs that a crash interrupts run again when the "
                    "daemon restarts, long ones from a checkpoint.");
    if (print_topics(out, 8) != 0)
        return -1;
    print_heading(out, ".SH", "SIGNALS");
    fputs(".TP\nSIGTERM, SIGINT\n", out);
    print_text(out, "The daemon waits for running jobs, but not longer than --drain-timeout. "
                    "Jobs that have not ended run when the daemon starts again. A second "
                    "signal ends the daemon at once.");
    fputs(".TP\nSIGHUP\n", out);
    print_text(
        out,
        "Reads the settings again and applies --log-level, then reloads the file of "
        "--api-keys. If a setting is wrong, nothing changes. If the file of keys is wrong, the "
        "previous keys stay valid.");
    print_exit_codes(out, 1);
    print_heading(out, ".SH", "SEE ALSO");
    fputs(".BR voronoid (1)\n", out);
    return 0;
}

int vor_page_manual(FILE *out, const char *section)
{
    return strcmp(section, "1") == 0   ? print_commands_page(out)
           : strcmp(section, "8") == 0 ? print_daemon_page(out)
                                       : -1;
}
