/* A datagram to a Unix socket is the whole protocol; libsystemd, which would bring 900 KB and
 * compression libraries into the image, does no more for these words. */
#include "server/base/notify.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

void vor_notify(const char *lines)
{
    const char *path = getenv("NOTIFY_SOCKET");
    size_t size = path != NULL ? strlen(path) : 0;
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd;

    /* A path, or an abstract name: "@name" there, a NUL and the name here. */
    if (size < 2 || size >= sizeof at.sun_path || (path[0] != '/' && path[0] != '@'))
        return;
    memcpy(at.sun_path, path, size);
    if (path[0] == '@')
        at.sun_path[0] = '\0';
    fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0)
        return;
    size += offsetof(struct sockaddr_un, sun_path) + (path[0] == '/');
    (void)sendto(fd, lines, strlen(lines), MSG_DONTWAIT | MSG_NOSIGNAL,
                 (const struct sockaddr *)&at, (socklen_t)size);
    (void)close(fd);
}

void vor_notify_reloading(void)
{
    struct timespec now = {0, 0};
    char lines[64];

    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    (void)snprintf(lines, sizeof lines, "RELOADING=1\nMONOTONIC_USEC=%lld",
                   (long long)now.tv_sec * 1000000 + now.tv_nsec / 1000);
    vor_notify(lines);
}

double vor_notify_watchdog(void)
{
    const char *allowed = getenv("WATCHDOG_USEC"), *pid = getenv("WATCHDOG_PID");
    char *end = NULL;
    unsigned long long microseconds = allowed != NULL ? strtoull(allowed, &end, 10) : 0;

    if (allowed == NULL || allowed[0] < '0' || allowed[0] > '9' || *end != '\0')
        return 0;
    if (pid != NULL && strtol(pid, NULL, 10) != (long)getpid())
        return 0;
    return (double)microseconds / 2e6;
}
