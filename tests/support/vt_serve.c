#include "tests/support/vt_serve.h"

#include "server/serve.h"
#include "tests/support/vt.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { PATIENCE_MS = 25000, ANSWER_SIZE = 1 << 20 }; /* less than the gate of vt_sync has */

static void run_daemon(const char *dir, int log)
{
    char name[] = "serve", listen[] = "--listen=127.0.0.1:0", one[] = "--http-threads=1",
         jobs[] = "--jobs=1", threads[] = "--threads=2", data[300];
    char *arguments[] = {name, listen, one, jobs, threads, data, NULL};

    (void)snprintf(data, sizeof data, "--data=%s", dir);
    (void)dup2(log, STDERR_FILENO);
    exit(vor_serve_main(6, arguments));
}

const char *vt_serve_log(const struct vt_serve *serve)
{
    static char text[1 << 16];
    char path[300];
    ssize_t size;
    int fd;

    (void)snprintf(path, sizeof path, "%s/log", serve->dir);
    fd = open(path, O_RDONLY);
    size = fd >= 0 ? read(fd, text, sizeof text - 1) : 0;
    if (fd >= 0)
        close(fd);
    text[size > 0 ? size : 0] = '\0';
    return text;
}

/* The port that the log tells, 0 as long as it does not. */
static uint16_t port_of(const struct vt_serve *serve)
{
    static const char mark[] = "\"address\":\"127.0.0.1:";
    const char *at = strstr(vt_serve_log(serve), mark);

    return at != NULL ? (uint16_t)strtol(at + strlen(mark), NULL, 10) : 0;
}

void vt_serve_start(struct vt_serve *serve, const char *dir)
{
    struct timespec pause = {.tv_nsec = 2000000};
    char path[300];
    int log;

    (void)snprintf(serve->dir, sizeof serve->dir, "%s", dir);
    (void)snprintf(path, sizeof path, "%s/log", dir);
    log = open(path, O_CREAT | O_WRONLY | O_APPEND | O_TRUNC, 0600);
    ck_assert_int_ge(log, 0);
    fflush(NULL);
    serve->pid = fork();
    if (serve->pid == 0)
        run_daemon(serve->dir, log);
    close(log);
    while ((serve->port = port_of(serve)) == 0)
        nanosleep(&pause, NULL);
}

int vt_serve_stop(const struct vt_serve *serve)
{
    int status = -1;

    ck_assert_int_eq(kill(serve->pid, SIGTERM), 0);
    ck_assert_int_eq(waitpid(serve->pid, &status, 0), serve->pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

int vt_serve_ask(const struct vt_serve *serve, const char *line, const char *headers,
                 const char *body)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons(serve->port)};
    char head[1024];
    int size, fd = socket(AF_INET, SOCK_STREAM, 0);

    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ck_assert_int_eq(connect(fd, (struct sockaddr *)&at, sizeof at), 0);
    size = snprintf(head, sizeof head,
                    "%s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n%s"
                    "Content-Length: %zu\r\n\r\n",
                    line, headers, strlen(body));
    ck_assert_int_eq(send(fd, head, (size_t)size, MSG_NOSIGNAL), size);
    ck_assert_int_eq(send(fd, body, strlen(body), MSG_NOSIGNAL), (ssize_t)strlen(body));
    return fd;
}

int vt_serve_answer(int fd, const char **text)
{
    static char bytes[ANSWER_SIZE];
    size_t size = 0;
    ssize_t got = 1;

    while (got > 0 && size < sizeof bytes - 1) {
        struct pollfd wait = {.fd = fd, .events = POLLIN};

        if (poll(&wait, 1, PATIENCE_MS) <= 0)
            break;
        got = recv(fd, bytes + size, sizeof bytes - 1 - size, 0);
        size += got > 0 ? (size_t)got : 0;
    }
    close(fd);
    bytes[size] = '\0';
    if (text != NULL)
        *text = bytes;
    return strncmp(bytes, "HTTP/1.1 ", 9) == 0 ? (int)strtol(bytes + 9, NULL, 10) : 0;
}

int vt_serve_answered(int fd)
{
    struct pollfd now = {.fd = fd, .events = POLLIN};

    return poll(&now, 1, 0) > 0;
}

int vt_serve_call(const struct vt_serve *serve, const char *line, const char *headers,
                  const char **text)
{
    return vt_serve_answer(vt_serve_ask(serve, line, headers, ""), text);
}
