#include "server/base/topics.h"

#include "server/base/reference.h"

#include <string.h>

/* The assembler takes each file in; its path is seen from the root of the tree, where make runs. */
#define EMBED(name, section)                                                                       \
    __asm__(".pushsection .rodata, \"a\"\n"                                                        \
            ".global vor_topic_text_" #name "\n"                                                   \
            "vor_topic_text_" #name ":\n"                                                          \
            ".incbin \"server/cli/help/" #name ".txt\"\n"                                          \
            ".byte 0\n"                                                                            \
            ".popsection\n");                                                                      \
    extern const char vor_topic_text_##name[];
VOR_TOPIC_TABLE(EMBED)
#undef EMBED

static const struct {
    const char *name;
    int section;
    const char *text;
} topics[] = {
#define ROW(name, section) {#name, section, vor_topic_text_##name},
    VOR_TOPIC_TABLE(ROW)
#undef ROW
};

enum { TOPICS = sizeof topics / sizeof topics[0] };

int vor_topic_at(struct vor_topic *out, unsigned index)
{
    const char *text;

    if (index >= TOPICS)
        return 0;
    text = topics[index].text;
    *out = (struct vor_topic){topics[index].name, topics[index].section, text,
                              (int)strcspn(text, "\n"), text + strcspn(text, "\n")};
    return 1;
}

int vor_topic_find(struct vor_topic *out, const char *name)
{
    /* Words that people look for, and the topic that has them. */
    static const struct {
        const char *word, *topic;
    } aliases[] = {{"backup", "data"}, {"nginx", "proxies"}};

    for (size_t i = 0; i < sizeof aliases / sizeof aliases[0]; i++)
        if (strcmp(aliases[i].word, name) == 0)
            name = aliases[i].topic;
    for (unsigned i = 0; vor_topic_at(out, i); i++)
        if (strcmp(out->name, name) == 0)
            return 1;
    return 0;
}

static int show_table(struct vor_span_of_text name,
                      void (*show)(void *ctx, const struct vor_markup_block *block), void *ctx)
{
    struct vor_markup_block block;
    struct vor_text table;
    const char *at;
    int is_whole;

    vor_text_init(&table, 0);
    vor_reference_write(&table, name.at, name.length);
    is_whole = !table.failed;
    at = table.data;
    while (is_whole && vor_markup_next(&block, &at))
        show(ctx, &block);
    vor_text_free(&table);
    return is_whole;
}

int vor_topic_blocks(const struct vor_topic *topic,
                     void (*show)(void *ctx, const struct vor_markup_block *block), void *ctx)
{
    struct vor_markup_block block;
    const char *at = topic->text;

    while (vor_markup_next(&block, &at)) {
        if (block.kind != VOR_MARKUP_TABLE)
            show(ctx, &block);
        else if (!show_table(block.term, show, ctx))
            return 0;
    }
    return 1;
}
