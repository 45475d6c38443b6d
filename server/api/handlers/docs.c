/* /docs: the topics of the help as a page. A script renders the contract beside them; without it
 * the links to the contract remain. */
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/base/topics.h"

struct page {
    struct vor_text *text;
    int in_list;
};

/* Text as it is, with what is between backticks as code. */
static void put_text(struct vor_text *out, struct vor_span_of_text text)
{
    int in_code = 0;

    for (size_t i = 0; i < text.length; i++) {
        switch (text.at[i]) {
        case '&':
            vor_text_puts(out, "&amp;");
            break;
        case '<':
            vor_text_puts(out, "&lt;");
            break;
        case '>':
            vor_text_puts(out, "&gt;");
            break;
        case '`':
            vor_text_puts(out, in_code ? "</code>" : "<code>");
            in_code = !in_code;
            break;
        default:
            vor_text_append(out, &text.at[i], 1);
        }
    }
}

static void put_element(struct vor_text *out, const char *name, struct vor_span_of_text text)
{
    vor_text_printf(out, "<%s>", name);
    put_text(out, text);
    vor_text_printf(out, "</%s>\n", name);
}

static void keep_list(struct page *page, int in_list)
{
    if (page->in_list != in_list)
        vor_text_puts(page->text, in_list ? "<dl>\n" : "</dl>\n");
    page->in_list = in_list;
}

static void put_block(void *ctx, const struct vor_markup_block *block)
{
    struct vor_span_of_text line, text = block->text;
    struct page *page = ctx;

    keep_list(page, block->kind == VOR_MARKUP_ITEM);
    switch (block->kind) {
    case VOR_MARKUP_HEADING:
        put_element(page->text, "h3", block->text);
        break;
    case VOR_MARKUP_PARAGRAPH:
        put_element(page->text, "p", block->text);
        break;
    case VOR_MARKUP_ITEM:
        put_element(page->text, "dt", block->term);
        put_element(page->text, "dd", block->text);
        break;
    case VOR_MARKUP_CODE:
        vor_text_puts(page->text, "<pre>");
        while (vor_markup_line(&line, &text)) {
            put_text(page->text, line);
            vor_text_puts(page->text, "\n");
        }
        vor_text_puts(page->text, "</pre>\n");
        break;
    case VOR_MARKUP_TABLE:
        break;
    }
}

enum vor_next vor_handle_docs(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    struct vor_text text;
    struct vor_topic topic;

    vor_text_init(&text, 0);
    vor_text_puts(&text, "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
                         "<meta name=\"viewport\" content=\"width=device-width\">\n"
                         "<title>voronoid: documentation</title>\n"
                         "<link rel=\"icon\" href=\"assets/icon.svg\">\n"
                         "<link rel=\"stylesheet\" href=\"assets/docs.css\">\n"
                         "<script type=\"module\" src=\"assets/docs.js\"></script>\n");
    vor_text_puts(&text, "<nav>\n<p><a href=\".\">voronoid " VOR_VERSION "</a></p>\n<ul>\n");
    for (unsigned i = 0; vor_topic_at(&topic, i); i++)
        vor_text_printf(&text, "<li><a href=\"#%s\">%.*s</a></li>\n", topic.name,
                        topic.title_length, topic.title);
    vor_text_puts(&text,
                  "<li><a href=\"#contract\">The contract</a></li>\n</ul>\n</nav>\n<main>\n");
    for (unsigned i = 0; vor_topic_at(&topic, i); i++) {
        struct page page = {&text, 0};

        vor_text_printf(&text, "<section id=\"%s\">\n<h2>%.*s</h2>\n", topic.name,
                        topic.title_length, topic.title);
        if (!vor_topic_blocks(&topic, put_block, &page))
            text.failed = 1;
        keep_list(&page, 0);
        vor_text_puts(&text, "</section>\n");
    }
    vor_text_puts(&text,
                  "<section id=\"contract\">\n<h2>The contract</h2>\n<p>OpenAPI 3.0, for programs: "
                  "<a href=\"openapi.yaml\">openapi.yaml</a>, "
                  "<a href=\"openapi.json\">openapi.json</a>.</p>\n</section>\n</main>\n</html>\n");
    vor_page_headers(request);
    return vor_app_reply(request, 200, "text/html; charset=utf-8", &text);
}
