/* A write to a pipe that nobody empties waits for ever, and a descriptor that is made non-blocking
 * is so for every process that shares it. So one thread asks for room (poll) and writes no more
 * than a pipe with room takes whole (PIPE_BUF); should it hang all the same, because another
 * process took the room, nobody else does. */
#include "server/base/log_sink.h"

#include "server/base/clock.h"
#include "server/base/machine.h"

#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { LOOK_MS = 50 }; /* how long the writer waits for room before it looks whether it is to end */

enum mode {
    DIRECT,  /* lines are written at once */
    QUEUED,  /* into the ring */
    STOPPING /* likewise, and the writer ends once the ring is empty */
};

static struct {
    pthread_mutex_t mutex; /* everything below but the counter */
    pthread_cond_t changed;
    int fd;
    enum mode mode;
    bool prepared, alive; /* the condition; the writer's thread */
    bool torn;            /* a line was written in part: the next begins with a newline */
    bool failing;         /* the last write failed: the reader has gone, or the disk is full */
    char *ring;           /* VOR_LOG_QUEUE_BYTES */
    size_t first, used;
    uint64_t untold; /* lines dropped since the last line that told of them */
    atomic_uint_least64_t dropped;
} sink = {.mutex = PTHREAD_MUTEX_INITIALIZER, .fd = STDERR_FILENO};

static void drop(uint64_t lines)
{
    sink.untold += lines;
    (void)atomic_fetch_add(&sink.dropped, lines);
}

/* Writes some of the bytes; 0 when there is no room in that time, -1 when it fails. */
static ssize_t write_some(int fd, const char *bytes, size_t size, int milliseconds)
{
    struct pollfd room = {fd, POLLOUT, 0};
    ssize_t wrote;

    if (poll(&room, 1, milliseconds) <= 0)
        return 0;
    wrote = write(fd, bytes, size < PIPE_BUF ? size : PIPE_BUF);
    if (wrote < 0 && (errno == EAGAIN || errno == EINTR))
        return 0;
    return wrote;
}

/* Notes how a piece of `size` bytes went, of which `wrote` were written. */
static void note_written(const char *piece, size_t size, size_t wrote)
{
    if (wrote > 0)
        sink.torn = piece[wrote - 1] != '\n';
    for (size_t i = wrote; i < size; i++)
        if (piece[i] == '\n')
            drop(1);
    sink.failing = wrote < size && sink.mode != DIRECT;
}

/* --- at once ---------------------------------------------------------------------------------- */

static void write_now(const char *line, size_t size)
{
    size_t at = 0;
    ssize_t wrote = 1;

    if (sink.torn)
        sink.torn = write_some(sink.fd, "\n", 1, 0) != 1;
    while (at < size && wrote > 0) {
        wrote = write_some(sink.fd, line + at, size - at, 0);
        if (wrote > 0)
            at += (size_t)wrote;
    }
    note_written(line, size, at);
}

/* --- the ring --------------------------------------------------------------------------------- */

static void push(const char *line, size_t size)
{
    size_t end = (sink.first + sink.used) % VOR_LOG_QUEUE_BYTES;
    size_t before = VOR_LOG_QUEUE_BYTES - end < size ? VOR_LOG_QUEUE_BYTES - end : size;

    memcpy(sink.ring + end, line, before);
    memcpy(sink.ring, line + before, size - before);
    sink.used += size;
}

/* Takes up to `most` bytes: whole lines, or a part of one that is longer. */
static size_t pull(char *out, size_t most)
{
    size_t size = sink.used < most ? sink.used : most;
    size_t before =
        VOR_LOG_QUEUE_BYTES - sink.first < size ? VOR_LOG_QUEUE_BYTES - sink.first : size;
    size_t whole = size;

    memcpy(out, sink.ring + sink.first, before);
    memcpy(out + before, sink.ring, size - before);
    while (whole > 0 && out[whole - 1] != '\n')
        whole--;
    if (whole > 0)
        size = whole;
    sink.used -= size;
    /* One that is empty begins anew, so that a reader who keeps up has its first pages touched and
     * not, line after line, all of them. */
    sink.first = sink.used > 0 ? (sink.first + size) % VOR_LOG_QUEUE_BYTES : 0;
    return size;
}

/* Tells how many lines were dropped, before the next one, where that finds room. */
static void tell_dropped(void)
{
    char time[VOR_CLOCK_TEXT_SIZE], line[192];
    struct pollfd room = {sink.fd, POLLOUT, 0};
    int size;

    if (sink.untold == 0 || sink.failing)
        return;
    size =
        snprintf(line, sizeof line,
                 "{\"ts\":\"%s\",\"level\":\"warn\",\"msg\":\"log lines dropped\",\"lines\":%llu,"
                 "\"total\":%llu}\n",
                 vor_clock_text(vor_clock_wall_ms(), time), (unsigned long long)sink.untold,
                 (unsigned long long)atomic_load(&sink.dropped));
    if (sink.mode == DIRECT && poll(&room, 1, 0) > 0) {
        sink.untold = 0;
        write_now(line, (size_t)size);
    } else if (sink.mode != DIRECT && sink.used + (size_t)size <= VOR_LOG_QUEUE_BYTES) {
        sink.untold = 0;
        push(line, (size_t)size);
    }
}

/* Writes a piece, however long the reader takes, until the log is given up. The mutex is not held.
 * Returns how many bytes were written. */
static size_t write_patiently(int fd, const char *piece, size_t size)
{
    size_t at = 0;
    bool go_on = true;

    while (at < size && go_on) {
        ssize_t wrote = write_some(fd, piece + at, size - at, LOOK_MS);

        if (wrote < 0)
            break;
        at += (size_t)wrote;
        pthread_mutex_lock(&sink.mutex);
        go_on = sink.mode != DIRECT;
        pthread_mutex_unlock(&sink.mutex);
    }
    return at;
}

/* Writes a piece of the ring, or waits for one; false when there is nothing more to do. The mutex
 * is held before and after. */
static bool write_piece(void)
{
    char piece[PIPE_BUF];
    size_t size = 0, wrote;
    int fd = sink.fd;

    if (sink.used == 0)
        tell_dropped();
    if (sink.used == 0) {
        if (sink.mode == QUEUED)
            (void)pthread_cond_wait(&sink.changed, &sink.mutex);
        return sink.used > 0 || sink.mode == QUEUED;
    }
    if (sink.torn && sink.failing)
        piece[size++] = '\n';
    size += pull(piece + size, sizeof piece - size);
    pthread_mutex_unlock(&sink.mutex);
    wrote = write_patiently(fd, piece, size);
    pthread_mutex_lock(&sink.mutex);
    note_written(piece, size, wrote);
    return sink.mode != DIRECT;
}

static void *writer(void *unused)
{
    (void)unused;
    pthread_mutex_lock(&sink.mutex);
    while (write_piece())
        ;
    sink.alive = false;
    pthread_cond_broadcast(&sink.changed);
    pthread_mutex_unlock(&sink.mutex);
    return NULL;
}

/* --- the door --------------------------------------------------------------------------------- */

void vor_log_sink_open(int fd)
{
    pthread_mutex_lock(&sink.mutex);
    sink.fd = fd;
    sink.torn = sink.failing = false;
    pthread_mutex_unlock(&sink.mutex);
}

void vor_log_sink_put(const char *line, size_t size)
{
    pthread_mutex_lock(&sink.mutex);
    tell_dropped();
    if (sink.mode == DIRECT) {
        write_now(line, size);
    } else if (sink.used + size <= VOR_LOG_QUEUE_BYTES && (sink.untold == 0 || sink.failing)) {
        push(line, size);
        pthread_cond_broadcast(&sink.changed);
    } else {
        drop(1);
    }
    pthread_mutex_unlock(&sink.mutex);
}

static void before_fork(void)
{
    pthread_mutex_lock(&sink.mutex);
}

static void after_fork(void)
{
    pthread_mutex_unlock(&sink.mutex);
}

/* A child has no writer, and the lines that wait are its parent's. */
static void in_child(void)
{
    sink.mode = DIRECT;
    sink.alive = false;
    sink.used = 0;
    sink.untold = 0;
    pthread_mutex_unlock(&sink.mutex);
}

static void prepare(void)
{
    if (sink.prepared)
        return;
    sink.prepared = true;
    (void)pthread_atfork(before_fork, after_fork, in_child);
    vor_clock_condition(&sink.changed);
}

vor_status vor_log_sink_start(struct vor_error *err)
{
    pthread_t thread;
    bool alive;

    pthread_mutex_lock(&sink.mutex);
    prepare();
    if (sink.ring == NULL)
        sink.ring = calloc(1, VOR_LOG_QUEUE_BYTES);
    if (sink.ring != NULL && !sink.alive &&
        vor_machine_thread(&thread, "vor-log", writer, NULL) == 0) {
        (void)pthread_detach(thread); /* one that hangs in a write ends with the process */
        sink.alive = true;
    }
    alive = sink.alive;
    if (alive)
        sink.mode = QUEUED;
    pthread_mutex_unlock(&sink.mutex);
    return alive ? VOR_OK
                 : vor_fail(err, VOR_E_NOMEM,
                            "cannot start the thread that writes the log: too little memory, or a "
                            "limit on the number of processes");
}

void vor_log_sink_stop(double seconds)
{
    double until = vor_clock_seconds() + seconds;

    pthread_mutex_lock(&sink.mutex);
    if (sink.mode == QUEUED) {
        sink.mode = STOPPING;
        pthread_cond_broadcast(&sink.changed);
        while (sink.alive && !vor_clock_wait(&sink.changed, &sink.mutex, until))
            ;
        sink.mode = DIRECT;
    }
    pthread_mutex_unlock(&sink.mutex);
}

uint64_t vor_log_sink_dropped(void)
{
    return atomic_load(&sink.dropped);
}
