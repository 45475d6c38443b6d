/** A whole daemon in a child process, with one HTTP thread, and clients that speak HTTP by hand. */
#ifndef VT_SERVE_H
#define VT_SERVE_H

#include <stdint.h>
#include <sys/types.h>

struct vt_serve {
    char dir[256];
    pid_t pid;
    uint16_t port;
};

/** Starts it on a data directory, with one job at a time; returns once it listens. */
void vt_serve_start(struct vt_serve *serve, const char *dir);

/** Ends it by SIGTERM; its exit status, or the number of the signal that ended it, negative. */
int vt_serve_stop(const struct vt_serve *serve);

/** What it has logged (static). */
const char *vt_serve_log(const struct vt_serve *serve);

/** Sends a request whose answer ends the connection; the socket. line is "GET /path", headers are
 * lines that end in CR LF. */
int vt_serve_ask(const struct vt_serve *serve, const char *line, const char *headers,
                 const char *body);

/** The status of the answer, 0 when none comes in 25 seconds. *text (may be NULL) gets all of it,
 * head and body (static). Closes the socket. */
int vt_serve_answer(int fd, const char **text);

/** True when a part of the answer is there. */
int vt_serve_answered(int fd);

/** One request and its answer, as above. */
int vt_serve_call(const struct vt_serve *serve, const char *line, const char *headers,
                  const char **text);

#endif
