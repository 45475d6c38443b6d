#include "server/http/internal.h"

#include <errno.h>
#include <netdb.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { BACKLOG = 1024 };

static int open_listener(const struct addrinfo *at)
{
    int fd = socket(at->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    int on = 1;

    if (fd < 0)
        return -1;
    (void)setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(fd, at->ai_addr, at->ai_addrlen) == 0 && listen(fd, BACKLOG) == 0)
        return fd;
    (void)close(fd);
    return -1;
}

vor_status vor_listen(int *out, const struct vor_http_options *options, struct vor_error *err)
{
    struct addrinfo hints = {.ai_flags = AI_PASSIVE, .ai_socktype = SOCK_STREAM};
    struct addrinfo *list = NULL;
    char port[8];
    int fd = -1, failed;

    (void)snprintf(port, sizeof port, "%u", options->port);
    failed = getaddrinfo(options->host, port, &hints, &list);
    if (failed != 0)
        return vor_fail_param(err, VOR_E_PARAM, "listen", "no address %.80s: %s", options->host,
                              gai_strerror(failed));
    for (const struct addrinfo *at = list; at != NULL && fd < 0; at = at->ai_next)
        fd = open_listener(at);
    failed = errno;
    freeaddrinfo(list);
    if (fd < 0)
        return vor_fail_param(err, VOR_E_PARAM, "listen", "cannot listen on %.80s port %u: %s",
                              options->host, options->port, strerror(failed));
    *out = fd;
    return VOR_OK;
}

void vor_listen_address(int fd, char out[80])
{
    struct sockaddr_storage bound;
    socklen_t size = sizeof bound;
    char host[64] = "", port[8] = "";

    memset(&bound, 0, sizeof bound);
    if (getsockname(fd, (struct sockaddr *)&bound, &size) == 0)
        (void)getnameinfo((struct sockaddr *)&bound, size, host, sizeof host, port, sizeof port,
                          NI_NUMERICHOST | NI_NUMERICSERV);
    (void)snprintf(out, 80, bound.ss_family == AF_INET6 ? "[%s]:%s" : "%s:%s", host, port);
}
