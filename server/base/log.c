/* A write to a pipe that nobody empties waits for ever, and a descriptor that is made non-blocking
 * is so for every process that shares it. So each write asks for room first, and has no more bytes
 * than a pipe with room takes whole (PIPE_BUF). What a slow reader has not read yet is in the pipe,
 * which is made as large as an ordinary user may have it. */
#define _GNU_SOURCE /* F_SETPIPE_SZ */
#include "server/base/log.h"

#include "proto/json/json.h"
#include "server/base/clock.h"

#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum {
    PIPE_BYTES = 1 << 20, /* some 4,000 lines */
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

static struct {
    pthread_mutex_t mutex; /* the next three */
    int fd;
    bool is_torn;    /* a line was written in part: the next begins with a newline */
    uint64_t untold; /* lines dropped since the last line that told of them */
    atomic_uint_least64_t dropped;
} sink = {.mutex = PTHREAD_MUTEX_INITIALIZER, .fd = STDERR_FILENO};

void vor_log_open(int fd, enum vor_log_level level)
{
    pthread_mutex_lock(&sink.mutex);
    sink.fd = fd;
    sink.is_torn = false;
    pthread_mutex_unlock(&sink.mutex);
    (void)fcntl(fd, F_SETPIPE_SZ, PIPE_BYTES);
    vor_log_set_level(level);
}

uint64_t vor_log_dropped(void)
{
    return atomic_load(&sink.dropped);
}

/* True when all bytes were written, false when there is no room for all, or the write fails. */
static bool write_whole(const char *bytes, size_t size)
{
    struct pollfd room = {sink.fd, POLLOUT, 0};
    ssize_t wrote = 1;

    for (size_t at = 0; at < size && wrote > 0; at += wrote > 0 ? (size_t)wrote : 0) {
        size_t piece = size - at < PIPE_BUF ? size - at : PIPE_BUF;

        wrote = poll(&room, 1, 0) > 0 ? write(sink.fd, bytes + at, piece) : 0;
        if (wrote > 0)
            sink.is_torn = bytes[at + (size_t)wrote - 1] != '\n';
    }
    return wrote > 0;
}

/* True when the lines that were dropped are told, or there are none. */
static bool tell_dropped(void)
{
    char time[VOR_CLOCK_TEXT_SIZE], line[192];
    int size;

    if (sink.untold == 0)
        return true;
    size =
        snprintf(line, sizeof line,
                 "{\"ts\":\"%s\",\"level\":\"warn\",\"msg\":\"log lines dropped\",\"lines\":%llu,"
                 "\"total\":%llu}\n",
                 vor_clock_text(vor_clock_wall_ms(), time), (unsigned long long)sink.untold,
                 (unsigned long long)atomic_load(&sink.dropped));
    if (!write_whole(line, (size_t)size))
        return false;
    sink.untold = 0;
    return true;
}

/* Writes a line, with its newline, or drops it. */
static void put_line(const struct vor_text *line)
{
    if (vor_text_status(line, NULL) != VOR_OK)
        return;
    pthread_mutex_lock(&sink.mutex);
    if ((sink.is_torn && !write_whole("\n", 1)) || !tell_dropped() ||
        !write_whole(line->data, line->size)) {
        sink.untold++;
        (void)atomic_fetch_add(&sink.dropped, 1);
    }
    pthread_mutex_unlock(&sink.mutex);
}

void vor_log_plain(const char *line)
{
    struct vor_text text;

    vor_text_init(&text, LINE_MAX_BYTES);
    vor_text_printf(&text, "%s\n", line);
    put_line(&text);
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
    put_line(&line);
    vor_text_free(&line);
}
