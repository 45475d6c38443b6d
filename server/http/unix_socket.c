#include "server/http/unix_socket.h"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

enum { BACKLOG = 1024 };

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

/* The file is made for nobody but its owner, and opened to others once it listens. */
static int open_at(const struct sockaddr_un *at, unsigned mode)
{
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    int failed;

    if (fd < 0)
        return -1;
    if (fchmod(fd, S_IRUSR | S_IWUSR) == 0 &&
        bind(fd, (const struct sockaddr *)at, sizeof *at) == 0 && listen(fd, BACKLOG) == 0 &&
        chmod(at->sun_path, (mode_t)mode) == 0)
        return fd;
    failed = errno;
    (void)close(fd);
    errno = failed;
    return -1;
}

vor_status vor_unix_socket_open(int *out, const char *path, unsigned mode, struct vor_error *err)
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
    fd = open_at(&at, mode);
    if (fd < 0)
        return refuse(err, path, strerror(errno));
    *out = fd;
    return VOR_OK;
}

void vor_unix_socket_remove(const char *address)
{
    if (strncmp(address, "unix:", 5) == 0)
        (void)unlink(address + 5);
}
