#include "server/base/log.h"

#include "proto/json/json.h"
#include "server/base/clock.h"

#include <errno.h>
#include <pthread.h>
#include <string.h>
#include <unistd.h>

static const char *const words[VOR_LOG_LEVELS] = {
#define WORD_ROW(name, word) word,
    VOR_LOG_TABLE(WORD_ROW)
#undef WORD_ROW
};

/* The one log of the process. */
static struct {
    pthread_mutex_t mutex;
    int fd;
    enum vor_log_level level;
} sink = {PTHREAD_MUTEX_INITIALIZER, STDERR_FILENO, VOR_LOG_INFO};

void vor_log_open(int fd, enum vor_log_level level)
{
    pthread_mutex_lock(&sink.mutex);
    sink.fd = fd;
    sink.level = level;
    pthread_mutex_unlock(&sink.mutex);
}

static void put_field(struct vor_text *line, const struct vor_log_field *field)
{
    switch (field->kind) {
    case VOR_LOG_KIND_TEXT:
        vor_json_put_string(line, field->name, field->text);
        break;
    case VOR_LOG_KIND_COUNT:
        vor_json_put_i64(line, field->name, field->count);
        break;
    case VOR_LOG_KIND_REAL:
        vor_json_put_double(line, field->name, field->real);
        break;
    }
}

/* A log that cannot be written must not stop the daemon: the line is lost. */
static void write_all(int fd, const char *bytes, size_t size)
{
    while (size > 0) {
        ssize_t wrote = write(fd, bytes, size);

        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote <= 0)
            return;
        bytes += wrote;
        size -= (size_t)wrote;
    }
}

void vor_log_write(enum vor_log_level level, const char *message,
                   const struct vor_log_field *fields)
{
    char time[VOR_CLOCK_TEXT_SIZE];
    struct vor_text line;
    int wanted;

    pthread_mutex_lock(&sink.mutex);
    wanted = level >= sink.level && level < VOR_LOG_OFF;
    pthread_mutex_unlock(&sink.mutex);
    if (!wanted)
        return;
    vor_text_init(&line, 65536);
    vor_json_begin_object(&line);
    vor_json_put_string(&line, "ts", vor_clock_text(vor_clock_wall_ms(), time));
    vor_json_put_string(&line, "level", words[level]);
    vor_json_put_string(&line, "msg", message);
    for (; fields->name != NULL; fields++)
        put_field(&line, fields);
    vor_json_end_object(&line);
    vor_text_add(&line, "\n", 1);
    if (vor_text_status(&line, NULL) == VOR_OK) {
        pthread_mutex_lock(&sink.mutex);
        write_all(sink.fd, line.data, line.size);
        pthread_mutex_unlock(&sink.mutex);
    }
    vor_text_free(&line);
}
