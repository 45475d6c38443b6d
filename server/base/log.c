#include "server/base/log.h"

#include "proto/json/json.h"
#include "server/base/clock.h"
#include "server/base/log_sink.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

enum {
    LINE_MAX_BYTES = 65536,
    HEAD_BYTES = 160, /* kept of a text that is too long, before what is left out */
    TAIL_BYTES = 64   /* and behind it */
};

static const char *const words[VOR_LOG_LEVELS] = {
#define WORD_ROW(name, word) word,
    VOR_LOG_TABLE(WORD_ROW)
#undef WORD_ROW
};

static atomic_int lowest = VOR_LOG_INFO;

void vor_log_set_level(enum vor_log_level level)
{
    atomic_store(&lowest, level);
}

void vor_log_open(int fd, enum vor_log_level level)
{
    vor_log_sink_open(fd);
    vor_log_set_level(level);
}

void vor_log_plain(const char *line)
{
    struct vor_text text;

    vor_text_init(&text, LINE_MAX_BYTES);
    vor_text_printf(&text, "%s\n", line);
    if (vor_text_status(&text, NULL) == VOR_OK)
        vor_log_sink_put(text.data, text.size);
    vor_text_free(&text);
}

static int is_continuation(char c)
{
    return ((unsigned char)c & 0xc0) == 0x80;
}

/* A long text without its middle: "/v1/aaaa [7936 bytes] aaaa". No character is cut. */
static void put_text(struct vor_text *line, const char *name, const char *text)
{
    char cut[VOR_LOG_TEXT_MAX];
    size_t size = text != NULL ? strlen(text) : 0;
    size_t head = HEAD_BYTES, tail = size - TAIL_BYTES;

    if (size > VOR_LOG_TEXT_MAX) {
        while (head > HEAD_BYTES - 4 && is_continuation(text[head]))
            head--;
        while (tail < size - TAIL_BYTES + 4 && is_continuation(text[tail]))
            tail++;
        (void)snprintf(cut, sizeof cut, "%.*s [%zu bytes] %s", (int)head, text, tail - head,
                       text + tail);
        text = cut;
    }
    vor_json_put_string(line, name, text);
}

void vor_log_write(enum vor_log_level level, const char *message,
                   const struct vor_log_field *fields)
{
    char time[VOR_CLOCK_TEXT_SIZE];
    struct vor_text line;

    if ((int)level < atomic_load(&lowest) || level >= VOR_LOG_OFF)
        return;
    vor_text_init(&line, LINE_MAX_BYTES);
    vor_json_begin_object(&line);
    vor_json_put_string(&line, "ts", vor_clock_text(vor_clock_wall_ms(), time));
    vor_json_put_string(&line, "level", words[level]);
    put_text(&line, "msg", message);
    for (; fields->name != NULL; fields++) {
        switch (fields->kind) {
        case VOR_LOG_KIND_TEXT:
            put_text(&line, fields->name, fields->text);
            break;
        case VOR_LOG_KIND_KNOWN:
            if (fields->text != NULL && fields->text[0] != '\0')
                put_text(&line, fields->name, fields->text);
            break;
        case VOR_LOG_KIND_COUNT:
            vor_json_put_i64(&line, fields->name, fields->count);
            break;
        case VOR_LOG_KIND_REAL:
            vor_json_put_double(&line, fields->name, fields->real);
            break;
        }
    }
    vor_json_end_object(&line);
    vor_text_add(&line, "\n", 1);
    if (vor_text_status(&line, NULL) == VOR_OK)
        vor_log_sink_put(line.data, line.size);
    vor_text_free(&line);
}
