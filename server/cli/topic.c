#include "server/cli/topic.h"

#include "server/base/topics.h"
#include "server/cli/cli_log.h"

#include <ctype.h>
#include <string.h>

enum { MEANING_COLUMN = 6, CODE_COLUMN = 4, EXAMPLES_MAX = 3 };

static void print_block(void *ctx, const struct vor_markup_block *block)
{
    struct vor_span_of_text line, text = block->text;
    FILE *out = ctx;

    switch (block->kind) {
    case VOR_MARKUP_HEADING:
        fprintf(out, "\n%.*s:\n", (int)block->text.length, block->text.at);
        break;
    case VOR_MARKUP_PARAGRAPH:
        fputc('\n', out);
        vor_markup_wrap(out, block->text, 0, 0);
        break;
    case VOR_MARKUP_ITEM:
        fprintf(out, "\n  %.*s\n%*s", (int)block->term.length, block->term.at, MEANING_COLUMN, "");
        vor_markup_wrap(out, block->text, MEANING_COLUMN, MEANING_COLUMN);
        break;
    case VOR_MARKUP_CODE:
        fputc('\n', out);
        while (vor_markup_line(&line, &text))
            fprintf(out, "%*s%.*s\n", line.length > 0 ? CODE_COLUMN : 0, "", (int)line.length,
                    line.at);
        break;
    case VOR_MARKUP_TABLE:
        break;
    }
}

int vor_cli_topic(FILE *out, const char *name)
{
    struct vor_topic topic;

    if (!vor_topic_find(&topic, name))
        return -1;
    fprintf(out, "%.*s\n", topic.title_length, topic.title);
    if (!vor_topic_blocks(&topic, print_block, out) || fflush(out) != 0)
        return VOR_EXIT_FAILED;
    return VOR_EXIT_OK;
}

struct examples {
    FILE *out;
    const char *command;
    size_t length; /* of the command */
    int count;
};

/* Whether a line calls the command: "voronoid wait ..." calls wait. */
static int calls(const struct examples *examples, struct vor_span_of_text line)
{
    static const char program[] = "voronoid ";
    size_t before = sizeof program - 1, length = before + examples->length;

    for (size_t i = 0; i + length <= line.length; i++) {
        const char *at = line.at + i;

        if (memcmp(at, program, before) == 0 &&
            memcmp(at + before, examples->command, examples->length) == 0 &&
            (i + length == line.length || !isalnum((unsigned char)at[length])))
            return 1;
    }
    return 0;
}

static void print_examples(void *ctx, const struct vor_markup_block *block)
{
    struct vor_span_of_text line, text = block->text;
    struct examples *examples = ctx;

    if (block->kind != VOR_MARKUP_CODE)
        return;
    while (examples->count < EXAMPLES_MAX && vor_markup_line(&line, &text)) {
        if (!calls(examples, line))
            continue;
        fprintf(examples->out, "%s  %.*s\n", examples->count == 0 ? "\nExamples:\n" : "",
                (int)line.length, line.at);
        examples->count++;
    }
}

void vor_cli_examples(FILE *out, const char *command)
{
    size_t lengths[] = {strlen(command), strcspn(command, " ")};
    struct examples examples = {out, command, 0, 0};
    struct vor_topic topic;

    for (size_t k = 0; k < sizeof lengths / sizeof lengths[0] && examples.count == 0; k++) {
        examples.length = lengths[k];
        for (unsigned i = 0; examples.count < EXAMPLES_MAX && vor_topic_at(&topic, i); i++)
            (void)vor_topic_blocks(&topic, print_examples, &examples);
    }
}

void vor_cli_topics(FILE *out)
{
    struct vor_topic topic;

    for (unsigned i = 0; vor_topic_at(&topic, i); i++)
        fprintf(out, "  %-12s %.*s\n", topic.name, topic.title_length, topic.title);
}
