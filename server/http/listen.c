/* The door to the network: the socket, the library's threads on it, and their end. */
#include "server/http/conn_guard.h"
#include "server/http/http.h"
#include "server/http/mhd_callbacks.h"
#include "server/http/mhd_library.h"
#include "server/http/state.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

enum {
    BACKLOG = 1024,
    STUCK_SECONDS = 45,
    SPARE = 128 /* connections: the reserve for health checks, and some that are being closed */
};

static const double grace_seconds = 0.5; /* a client far away needs as long to send its head */

static vor_status refuse(struct vor_error *err, const char *path, const char *why)
{
    return vor_fail(err, VOR_E_IO, "cannot listen on unix:%.110s: %s", path, why);
}

/* Removes a socket whose daemon is gone: nobody accepts on it. */
static vor_status remove_stale(const struct sockaddr_un *at, struct vor_error *err)
{
    struct stat info;
    int fd, answered;

    if (lstat(at->sun_path, &info) != 0)
        return VOR_OK;
    if (!S_ISSOCK(info.st_mode))
        return refuse(err, at->sun_path, "there is a file that is not a socket");
    fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0)
        return refuse(err, at->sun_path, strerror(errno));
    answered = connect(fd, (const struct sockaddr *)at, sizeof *at) == 0 || errno == EAGAIN;
    (void)close(fd);
    if (answered)
        return refuse(err, at->sun_path, "a daemon answers there already");
    if (unlink(at->sun_path) != 0)
        return refuse(err, at->sun_path, strerror(errno));
    return VOR_OK;
}

/* The file of a path is made for nobody but its owner, and opened to others once it listens. */
static int open_listener(int family, const struct sockaddr *at, socklen_t size, const char *path,
                         unsigned mode)
{
    int fd = socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    int on = 1, failed;

    if (fd < 0)
        return -1;
    if (path == NULL)
        (void)setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if ((path == NULL || fchmod(fd, S_IRUSR | S_IWUSR) == 0) && bind(fd, at, size) == 0 &&
        listen(fd, BACKLOG) == 0 && (path == NULL || chmod(path, (mode_t)mode) == 0))
        return fd;
    failed = errno;
    (void)close(fd);
    errno = failed;
    return -1;
}

/* Listens on a path. A socket that nobody answers on is replaced. */
static vor_status open_unix_socket(int *out, const char *path, unsigned mode, struct vor_error *err)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd;
    vor_status status;

    if (strlen(path) >= sizeof at.sun_path)
        return refuse(err, path, "the path is too long");
    memcpy(at.sun_path, path, strlen(path) + 1);
    status = remove_stale(&at, err);
    if (status != VOR_OK)
        return status;
    fd = open_listener(AF_UNIX, (const struct sockaddr *)&at, sizeof at, path, mode);
    if (fd < 0)
        return refuse(err, path, strerror(errno));
    *out = fd;
    return VOR_OK;
}

static vor_status open_socket(int *out, const struct vor_http_options *options,
                              struct vor_error *err)
{
    struct addrinfo hints = {.ai_flags = AI_PASSIVE, .ai_socktype = SOCK_STREAM};
    struct addrinfo *list = NULL;
    char port[8];
    int fd = -1, failed;

    if (options->path != NULL && options->path[0] != '\0')
        return open_unix_socket(out, options->path, options->mode, err);
    (void)snprintf(port, sizeof port, "%u", options->port);
    failed = getaddrinfo(options->host, port, &hints, &list);
    if (failed != 0)
        return vor_fail(err, VOR_E_IO, "cannot listen on %.80s: %s", options->host,
                        gai_strerror(failed));
    for (const struct addrinfo *at = list; at != NULL && fd < 0; at = at->ai_next)
        fd = open_listener(at->ai_family, at->ai_addr, at->ai_addrlen, NULL, 0);
    failed = errno;
    freeaddrinfo(list);
    if (fd < 0)
        return vor_fail(err, VOR_E_IO, "cannot listen on %.80s port %u: %s", options->host,
                        options->port, strerror(failed));
    *out = fd;
    return VOR_OK;
}

static void read_address(struct vor_http *http)
{
    char *out = http->address;
    int fd = http->fd;
    struct sockaddr_storage bound;
    socklen_t size = sizeof bound;
    char host[64] = "", port[8] = "";

    memset(&bound, 0, sizeof bound);
    if (http->options.path != NULL && http->options.path[0] != '\0') {
        (void)snprintf(out, sizeof http->address, "unix:%s", http->options.path);
        return;
    }
    if (getsockname(fd, (struct sockaddr *)&bound, &size) == 0)
        (void)getnameinfo((struct sockaddr *)&bound, size, host, sizeof host, port, sizeof port,
                          NI_NUMERICHOST | NI_NUMERICSERV);
    (void)snprintf(out, sizeof http->address, bound.ss_family == AF_INET6 ? "[%s]:%s" : "%s:%s",
                   host, port);
}

static void on_connection(void *cls, struct MHD_Connection *connection, void **socket_context,
                          enum MHD_ConnectionNotificationCode code)
{
    struct vor_http *http = cls;
    const union MHD_ConnectionInfo *info;
    struct vor_address from;
    bool known;

    if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
        vor_watchdog_enter(&http->watchdog);
        vor_conn_leave(*socket_context);
        vor_watchdog_leave(&http->watchdog);
        *socket_context = NULL;
        return;
    }
    info = vor_mhd->get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    known = info != NULL && info->client_addr != NULL &&
            vor_address_of_socket(&from, info->client_addr);
    info = vor_mhd->get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    if (info == NULL)
        return;
    *socket_context = vor_conn_enter(http->guard, info->connect_fd, known ? &from : NULL);
    if (*socket_context == NULL) /* nobody would watch how slowly its head comes */
        (void)shutdown(info->connect_fd, SHUT_RDWR);
}

static void on_log(void *cls, const char *format, va_list args) VOR_PRINTF(2, 0);

static void on_log(void *cls, const char *format, va_list args)
{
    struct vor_http *http = cls;
    char line[512];

    (void)vsnprintf(line, sizeof line, format, args);
    line[strcspn(line, "\n")] = '\0';
    http->options.log(line);
}

vor_status vor_http_open(struct vor_http **out, const struct vor_http_options *options,
                         struct vor_error *err)
{
    struct vor_http *http = calloc(1, sizeof *http);
    vor_status status;

    if (http == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the HTTP threads");
    http->options = *options;
    http->options.limits.grace_seconds = grace_seconds;
    http->fd = -1;
    status = vor_mhd_load(err);
    VOR_THEN(status, open_socket(&http->fd, options, err));
    VOR_THEN(status, vor_conn_guard_start(&http->guard, &http->options.limits, err));
    if (status != VOR_OK) {
        vor_http_stop(http);
        return status;
    }
    read_address(http);
    *out = http;
    return VOR_OK;
}

vor_status vor_http_start(struct vor_http *http, struct vor_error *err)
{
    const struct vor_http_options *options = &http->options;

    /* The library divides its limit of connections among its threads and stops accepting at it. As
     * many for each as there may be in all, and those which are cut and not closed yet: the limit
     * that is met is ours. */
    unsigned most = options->limits.connections + options->streams + SPARE;

    http->daemon = vor_mhd->start_daemon(
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG, 0, NULL, NULL,
        vor_mhd_step, http, MHD_OPTION_EXTERNAL_LOGGER, on_log, http, MHD_OPTION_LISTEN_SOCKET,
        http->fd, MHD_OPTION_THREAD_POOL_SIZE, options->threads > 1 ? options->threads : 0u,
#if MHD_VERSION >= 0x01000000
        MHD_OPTION_CLIENT_DISCIPLINE_LVL, 1,
#else
        MHD_OPTION_STRICT_FOR_CLIENT, 0, /* all it adds is to refuse a missing Host, which the
                                            request check does with a problem, once */
#endif
        MHD_OPTION_CONNECTION_LIMIT, most * (options->threads > 1 ? options->threads : 1),
        MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)STUCK_SECONDS, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
        (size_t)VOR_CONNECTION_BYTES, MHD_OPTION_NOTIFY_CONNECTION, on_connection, http,
        MHD_OPTION_NOTIFY_COMPLETED, vor_mhd_end, http, MHD_OPTION_URI_LOG_CALLBACK, vor_mhd_begin,
        http, MHD_OPTION_END);
    if (http->daemon == NULL)
        return vor_fail(err, VOR_E_NOMEM,
                        "cannot start the HTTP threads: too little memory, or a limit on the "
                        "number of processes");
    http->fd = -1;
    return VOR_OK;
}

const char *vor_http_address(const struct vor_http *http)
{
    return http->address;
}

void vor_http_quiesce(struct vor_http *http)
{
    struct sockaddr_storage from;
    socklen_t size = sizeof from;
    int fd;

    atomic_store(&http->quiesced, true);
    http->fd = vor_mhd->quiesce_daemon(http->daemon);
    if (http->fd < 0)
        return;
    /* Takes in whom the system has let in, and then nobody any more. Closing the socket would cut
     * those who wait there, who may have sent their request; it is closed when the library has
     * stopped. */
    (void)listen(http->fd, 0); /* hardly anybody comes in between the two calls at the end */
    while ((fd = accept(http->fd, (struct sockaddr *)&from, &size)) >= 0) {
        (void)fcntl(fd, F_SETFD, FD_CLOEXEC);
        (void)fcntl(fd, F_SETFL, O_NONBLOCK);
        (void)vor_mhd->add_connection(http->daemon, fd, (struct sockaddr *)&from, size);
        size = sizeof from;
    }
    (void)shutdown(http->fd, SHUT_RD);
}

unsigned vor_http_connections(const struct vor_http *http)
{
    return vor_conn_guard_count(http->guard);
}

double vor_http_stuck(const struct vor_http *http)
{
    return vor_watchdog_longest(&http->watchdog);
}

void vor_http_close_waiting(struct vor_http *http)
{
    atomic_store(&http->closing, true);
    vor_http_wake_all(http);
}

void vor_http_stop(struct vor_http *http)
{
    if (http == NULL)
        return;
    if (http->daemon != NULL) {
        vor_http_close_waiting(http);
        vor_mhd->stop_daemon(http->daemon);
    }
    if (http->fd >= 0)
        (void)close(http->fd);
    if (strncmp(http->address, "unix:", 5) == 0)
        (void)unlink(http->address + 5);
    vor_conn_guard_stop(http->guard);
    free(http);
}
