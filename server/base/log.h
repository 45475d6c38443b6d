/** The daemon's log: one JSON object a line, {"ts","level","msg", fields}. Thread-safe. Nobody
 * waits for the reader of the log: a line for which there is no room is dropped and counted, and
 * the next one that finds room follows a line that tells the count. Every text is escaped and cut
 * to VOR_LOG_TEXT_MAX bytes. */
#ifndef VOR_SERVER_BASE_LOG_H
#define VOR_SERVER_BASE_LOG_H

#include <stdint.h>

/** Levels: identifier, word. */
#define VOR_LOG_TABLE(X)                                                                           \
    X(DEBUG, "debug")                                                                              \
    X(INFO, "info")                                                                                \
    X(WARN, "warn")                                                                                \
    X(ERROR, "error")                                                                              \
    X(OFF, "off")

enum vor_log_level {
#define VOR_LOG_ENUM(name, word) VOR_LOG_##name,
    VOR_LOG_TABLE(VOR_LOG_ENUM)
#undef VOR_LOG_ENUM
        VOR_LOG_LEVELS
};

/** Bytes of a text in a line: of a longer one the middle is left out, and how much is said in its
 *  place. Escaped it has six times as many at most. */
enum { VOR_LOG_TEXT_MAX = 256 };

/** Where lines go (a file descriptor, borrowed) and which: level and above. Until then standard
 *  error, info. */
void vor_log_open(int fd, enum vor_log_level level);

/** Lines dropped since the start of the process. */
uint64_t vor_log_dropped(void);

/** Changes the level alone. */
void vor_log_set_level(enum vor_log_level level);

/** Writes one line of plain text for people, with a newline behind it, if there is room. */
void vor_log_plain(const char *line);

struct vor_log_field {
    const char *name; /**< NULL ends a list */
    enum { VOR_LOG_KIND_TEXT, VOR_LOG_KIND_KNOWN, VOR_LOG_KIND_COUNT, VOR_LOG_KIND_REAL } kind;
    const char *text; /**< NULL is written as null */
    int64_t count;
    double real;
};

#define VOR_TEXT(field, value)                                                                     \
    {                                                                                              \
        .name = (field), .kind = VOR_LOG_KIND_TEXT, .text = (value)                                \
    }
/** A text that is left out where it is NULL or empty. */
#define VOR_KNOWN(field, value)                                                                    \
    {                                                                                              \
        .name = (field), .kind = VOR_LOG_KIND_KNOWN, .text = (value)                               \
    }
#define VOR_COUNT(field, value)                                                                    \
    {                                                                                              \
        .name = (field), .kind = VOR_LOG_KIND_COUNT, .count = (int64_t)(value)                     \
    }
#define VOR_REAL(field, value)                                                                     \
    {                                                                                              \
        .name = (field), .kind = VOR_LOG_KIND_REAL, .real = (value)                                \
    }

/** vor_log(VOR_LOG_INFO, "job ended", VOR_TEXT("job", id), VOR_REAL("dur_s", seconds)); */
#define vor_log(level, ...) VOR_LOG_SPLIT(level, __VA_ARGS__, {.name = NULL})
#define VOR_LOG_SPLIT(level, message, ...)                                                         \
    vor_log_write(level, message, (const struct vor_log_field[]){__VA_ARGS__})

void vor_log_write(enum vor_log_level level, const char *message,
                   const struct vor_log_field *fields);

#endif
