/* Any bytes as an event stream, once in one piece and once cut up (the first byte says how): the
 * same events must arrive; and what has arrived, formatted, arrives again. */
#include "proto/sse.h"
#include "tests/fuzz/fuzz.h"

static int format_again(void *ctx, const struct vor_sse_arrival *event)
{
    require(event->size == 0 || event->data != NULL, "an event without data");
    vor_sse_event(ctx, event->id, event->name, event->data, event->size);
    return 0;
}

/* The stream of bytes, cut into pieces, read and formatted again. */
static vor_status again(struct vor_text *out, const uint8_t *bytes, size_t size, size_t piece)
{
    struct vor_sse_parser parser;
    vor_status status = VOR_OK;

    vor_text_init(out, 0);
    vor_text_puts(out, "");
    vor_sse_parser_init(&parser, format_again, out);
    for (size_t at = 0; at < size && status == VOR_OK; at += piece)
        status = vor_sse_feed(&parser, bytes + at, size - at < piece ? size - at : piece, NULL);
    vor_sse_parser_free(&parser);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    struct vor_text whole, cut, twice;
    size_t piece;

    if (size == 0)
        return 0;
    piece = 1 + bytes[0] % 31;
    bytes++;
    size--;
    require(again(&whole, bytes, size, size + 1) == again(&cut, bytes, size, piece),
            "a cut changes the outcome");
    require(whole.size == cut.size && memcmp(whole.data, cut.data, cut.size) == 0,
            "a cut changes the events");
    require(again(&twice, (uint8_t *)whole.data, whole.size, piece) == VOR_OK,
            "our own stream is refused");
    require(whole.size == twice.size && memcmp(whole.data, twice.data, twice.size) == 0,
            "a stream changes when it is read and formatted again");
    vor_text_free(&whole);
    vor_text_free(&cut);
    vor_text_free(&twice);
    return 0;
}
