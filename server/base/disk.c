#include "server/base/disk.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

vor_status vor_fail_errno(struct vor_error *err, int number, const char *what)
{
    char reason[96];

    if (strerror_r(number, reason, sizeof reason) != 0)
        (void)snprintf(reason, sizeof reason, "error %d", number);
    (void)vor_fail(err, VOR_E_IO, "%s: %s", what, reason);
    if (err != NULL)
        err->got = (uint64_t)number;
    return VOR_E_IO;
}

/* Cuts the last segment off; the folder is then what is left, "." for none, "/" at the root. */
static const char *cut_folder(char *path)
{
    char *slash = strrchr(path, '/');

    if (slash == NULL)
        return ".";
    slash[slash == path] = '\0';
    return path;
}

/* path is there: it, or the folder that the file is in, has to be given to us. */
static void say_owner(struct vor_error *err, char *path, const struct stat *info)
{
    unsigned user = (unsigned)geteuid();
    char name[512];

    (void)snprintf(name, sizeof name, "%s", path);
    if (info->st_uid == user)
        (void)vor_fail(err, VOR_E_IO,
                       "%s belongs to user %u, who runs this process, but its mode is %04o. "
                       "Run chmod u+rwX %s",
                       name, user, (unsigned)info->st_mode & 07777, name);
    else
        (void)vor_fail(err, VOR_E_IO,
                       "%s belongs to user %u, but this process runs as user %u, who may not "
                       "write there. Run chown -R %u:%u %s (in a container, on the folder that "
                       "is mounted there)",
                       name, (unsigned)info->st_uid, user, user, (unsigned)getegid(),
                       S_ISDIR(info->st_mode) ? name : cut_folder(path));
}

vor_status vor_fail_access(struct vor_error *err, int number, const char *path)
{
    unsigned user = (unsigned)geteuid();
    char *copy = number == EACCES || number == EPERM ? strdup(path) : NULL;
    const char *above = copy;
    struct stat info;

    while (above != NULL && stat(above, &info) != 0)
        above = strcmp(above, ".") == 0 || strcmp(above, "/") == 0 ? NULL : cut_folder(copy);
    if (above == NULL)
        (void)vor_fail_errno(err, number, path);
    else if (strcmp(above, path) == 0)
        say_owner(err, copy, &info);
    else
        /* path is not there, and the folder above it may not be written. */
        (void)vor_fail(err, VOR_E_IO,
                       "there is no %s, and this process runs as user %u, who may not create it in "
                       "%s, which belongs to user %u (mode %04o). Run install -d -o %u -g %u %s",
                       path, user, above, (unsigned)info.st_uid, (unsigned)info.st_mode & 07777,
                       user, (unsigned)getegid(), path);
    if (err != NULL)
        err->got = (uint64_t)number;
    free(copy);
    return VOR_E_IO;
}

int vor_error_storage_full(const struct vor_error *err)
{
    return err->status == VOR_E_IO && (err->got == ENOSPC || err->got == EDQUOT);
}

int vor_error_storage_away(const struct vor_error *err)
{
    return err->status == VOR_E_IO && err->got == EAGAIN;
}

int vor_error_storage_refused(const struct vor_error *err)
{
    return err->status == VOR_E_IO && err->got == EKEYREJECTED;
}

int vor_error_may_be_done(const struct vor_error *err)
{
    return err->status == VOR_E_IO && err->got == EINPROGRESS;
}

int vor_error_storage_absent(const struct vor_error *err)
{
    return vor_error_storage_away(err) || vor_error_storage_refused(err);
}

const char *vor_storage_place(const char *where, const char *scheme)
{
    size_t length = strlen(scheme);

    if (strncmp(where, scheme, length) != 0 || where[length] != ':' || where[length + 1] == '\0')
        return NULL;
    return where + length + 1;
}

/* 0, or an errno. */
static int make_one(const char *path)
{
    if (mkdir(path, 0700) == 0) {
        const char *slash = strrchr(path, '/');
        char *parent = slash == NULL ? strdup(".") : strndup(path, (size_t)(slash - path) + 1);
        int fd = parent != NULL ? open(parent, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
        int failed = fd < 0 || fsync(fd) != 0 ? errno : 0;

        /* Makes the entry of path in its parent directory durable. */
        if (fd >= 0)
            close(fd);
        free(parent);
        return failed;
    }
    return errno == EEXIST ? 0 : errno;
}

vor_status vor_storage_directory(const char *path, struct vor_error *err)
{
    size_t length = strlen(path);
    char *part = strdup(path);
    int failed = 0;

    if (part == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a path of %zu bytes", length);
    for (size_t i = 1; i <= length && !failed; i++) {
        if (path[i] != '/' && path[i] != '\0')
            continue;
        part[i] = '\0';
        failed = make_one(part);
        part[i] = path[i];
    }
    free(part);
    return failed ? vor_fail_access(err, failed, path) : VOR_OK;
}

vor_status vor_storage_lock(int *fd, const char *path, int is_shared, long *holder,
                            struct vor_error *err)
{
    int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    vor_status status;

    *holder = 0;
    if (file < 0) {
        int number = errno;
        char *copy = access(path, F_OK) != 0 ? strdup(path) : NULL;

        /* A file that cannot be opened or, where there is none, be made in its folder. */
        status = vor_fail_access(err, number, copy != NULL ? cut_folder(copy) : path);
        free(copy);
        return status;
    }
    if (flock(file, (is_shared ? LOCK_SH : LOCK_EX) | LOCK_NB) == 0) {
        char text[24];
        int size = is_shared ? 0 : snprintf(text, sizeof text, "%ld\n", (long)getpid());

        /* On a full disk the lock holds all the same; it just does not say who has it. */
        if (ftruncate(file, 0) == 0 && pwrite(file, text, (size_t)size, 0) != size)
            (void)!ftruncate(file, 0);
        *fd = file;
        return VOR_OK;
    }
    if (errno == EWOULDBLOCK) {
        char text[24] = "";
        ssize_t size = pread(file, text, sizeof text - 1, 0);

        *holder = size > 0 ? strtol(text, NULL, 10) : 0;
        if (*holder <= 0)
            *holder = -1; /* it does not say who wrote it */
        status =
            *holder > 0
                ? vor_fail(err, VOR_E_IO,
                           "%s is in use by process %ld, another daemon; choose another --data",
                           path, *holder)
                : vor_fail(err, VOR_E_IO, "%s is in use by another daemon; choose another --data",
                           path);
    } else {
        status = vor_fail_errno(err, errno, path);
    }
    close(file);
    return status;
}
