#include "server/blob/dir_lost.h"

#include "server/base/disk.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NAME_SIZE = 256 }; /* bytes of a file's name on Linux, with the NUL */

struct lost {
    char file[NAME_SIZE];
    uint64_t size;
    int64_t since_ms; /* wall clock */
};

struct list {
    struct lost *item;
    size_t count, capacity;
    int failed; /* memory is out */
};

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

/* Room for one more; false when memory is out. */
static int grow(struct list *list)
{
    size_t capacity = list->capacity > 0 ? 2 * list->capacity : 64;
    struct lost *item;

    if (list->count < list->capacity)
        return 1;
    item = realloc(list->item, capacity * sizeof *item);
    if (item == NULL)
        return 0;
    list->item = item;
    list->capacity = capacity;
    return 1;
}

static void note(struct list *list, int folder, const char *file)
{
    struct stat info;
    struct lost *lost;

    if (fstatat(folder, file, &info, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(info.st_mode))
        return;
    if (!grow(list)) {
        list->failed = 1;
        return;
    }
    lost = &list->item[list->count++];
    (void)snprintf(lost->file, sizeof lost->file, "%s", file);
    lost->size = (uint64_t)info.st_size;
    lost->since_ms = (int64_t)info.st_mtim.tv_sec * 1000 + info.st_mtim.tv_nsec / 1000000;
}

static int newest_first(const void *a, const void *b)
{
    const struct lost *x = a, *y = b;

    if (x->since_ms != y->since_ms)
        return x->since_ms < y->since_ms ? 1 : -1;
    return strcmp(x->file, y->file);
}

static void shift_date(int folder, const struct lost *lost, int64_t shift_ms)
{
    int64_t now = lost->since_ms + shift_ms;
    const struct timespec times[2] = {{.tv_nsec = UTIME_OMIT},
                                      {.tv_sec = now / 1000, .tv_nsec = now % 1000 * 1000000}};

    (void)utimensat(folder, lost->file, times, 0);
}

static void trim(int folder, const struct list *list, const struct vor_lost_bounds *bounds)
{
    uint64_t bytes = 0;

    for (size_t i = 0; i < list->count; i++) {
        const struct lost *lost = &list->item[i];

        bytes += lost->size;
        if (lost->since_ms < bounds->oldest_ms || bytes > bounds->bytes)
            (void)unlinkat(folder, lost->file, 0);
        else if (bounds->shift_ms != 0)
            shift_date(folder, lost, bounds->shift_ms);
    }
}

vor_status vor_dir_trim_lost(int parent, const struct vor_lost_bounds *bounds,
                             struct vor_error *err)
{
    int folder = open_lost(parent, 0);
    DIR *stream = folder >= 0 ? fdopendir(folder) : NULL;
    struct list list = {0};
    struct dirent *entry;

    if (stream == NULL) {
        int number = errno;

        if (folder >= 0)
            close(folder);
        return number == ENOENT ? VOR_OK : vor_fail_errno(err, number, "the folder blobs/lost");
    }
    while ((entry = readdir(stream)) != NULL)
        note(&list, folder, entry->d_name);
    if (list.count > 0)
        qsort(list.item, list.count, sizeof *list.item, newest_first);
    if (!list.failed)
        trim(folder, &list, bounds);
    free(list.item);
    closedir(stream);
    return list.failed ? vor_fail(err, VOR_E_NOMEM, "the list of lost files") : VOR_OK;
}
