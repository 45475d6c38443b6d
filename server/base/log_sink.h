/** Where the log's lines go: a file descriptor, and a queue before it. Nobody who logs ever waits
 *  for whoever reads. log.h is what the rest of the daemon includes. Thread-safe. */
#ifndef VOR_SERVER_BASE_LOG_SINK_H
#define VOR_SERVER_BASE_LOG_SINK_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** Lines that wait, in bytes: some 4,000 lines. */
enum { VOR_LOG_QUEUE_BYTES = 1 << 20 };

/** The descriptor, borrowed. Until then it is standard error. */
void vor_log_sink_open(int fd);

/** Takes a line, with its newline: into the queue once vor_log_sink_start was called; else, and in
 * a forked child, it is written at once. It is dropped and counted where there is no room, and the
 *  next one that finds room follows a line that tells the count. */
void vor_log_sink_put(const char *line, size_t size);

/** Starts the thread that writes the queue.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_log_sink_start(struct vor_error *err);

/** Gives the thread up to `seconds` to write what waits, and ends it. Does nothing unless started.
 */
void vor_log_sink_stop(double seconds);

/** Lines dropped since the start of the process. */
uint64_t vor_log_sink_dropped(void);

#endif
