#include "server/blob/dir_lost.h"

#include "server/base/disk.h"
#include "server/blob/aged.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

/* Opens the folder; -1 and an errno when it cannot be, or is missing and shall not be made. */
static int open_lost(int parent, int make)
{
    if (make && mkdirat(parent, "lost", 0700) != 0 && errno != EEXIST)
        return -1;
    return openat(parent, "lost", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

vor_status vor_dir_set_aside(int parent, int keep, const char *file, struct vor_error *err)
{
    int lost = open_lost(parent, 1);
    vor_status status = VOR_OK;

    if (lost < 0)
        return vor_fail_errno(err, errno, "the folder blobs/lost");
    if (renameat(keep, file, lost, file) != 0)
        status = vor_fail_errno(err, errno, file);
    else
        (void)utimensat(lost, file, NULL, 0); /* else it counts from when it was written */
    close(lost);
    return status;
}

static void note(struct vor_aged *list, int folder, const char *file)
{
    struct stat info;

    if (fstatat(folder, file, &info, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(info.st_mode))
        vor_aged_add(list, file, (uint64_t)info.st_size,
                     (int64_t)info.st_mtim.tv_sec * 1000 + info.st_mtim.tv_nsec / 1000000);
}

static void shift_date(int folder, const struct vor_aged_file *lost, int64_t shift_ms)
{
    int64_t now = lost->since_ms + shift_ms;
    const struct timespec times[2] = {{.tv_nsec = UTIME_OMIT},
                                      {.tv_sec = now / 1000, .tv_nsec = now % 1000 * 1000000}};

    (void)utimensat(folder, lost->name, times, 0);
}

static void trim(int folder, const struct vor_aged *list, const struct vor_lost_bounds *bounds)
{
    uint64_t bytes = 0;

    for (size_t i = 0; i < list->count; i++) {
        const struct vor_aged_file *lost = &list->item[i];

        bytes += lost->size;
        if (lost->since_ms < bounds->oldest_ms || bytes > bounds->bytes)
            (void)unlinkat(folder, lost->name, 0);
        else if (bounds->shift_ms != 0)
            shift_date(folder, lost, bounds->shift_ms);
    }
}

vor_status vor_dir_trim_lost(int parent, const struct vor_lost_bounds *bounds,
                             struct vor_error *err)
{
    int folder = open_lost(parent, 0);
    DIR *stream = folder >= 0 ? fdopendir(folder) : NULL;
    struct vor_aged list = {0};
    struct dirent *entry;
    int is_short;

    if (stream == NULL) {
        int number = errno;

        if (folder >= 0)
            close(folder);
        return number == ENOENT ? VOR_OK : vor_fail_errno(err, number, "the folder blobs/lost");
    }
    while ((entry = readdir(stream)) != NULL)
        note(&list, folder, entry->d_name);
    vor_aged_sort(&list);
    is_short = list.is_short;
    if (!is_short)
        trim(folder, &list, bounds);
    vor_aged_free(&list);
    closedir(stream);
    return is_short ? vor_fail(err, VOR_E_NOMEM, "the list of lost files") : VOR_OK;
}
