#include "server/cli/commands.h"

#include "server/base/disk.h"
#include "server/blob/blob.h"
#include "server/cli/cli_log.h"
#include "server/store/store.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct migration {
    const char *data;
    struct vor_store *from_store, *store;
    struct vor_blobs *from_blobs, *blobs;
    struct vor_store_copied jobs;
    size_t files, files_were_there;
    uint64_t bytes;
    long holder;
};

/* One that is there with its size was copied whole. */
static vor_status copy_file(struct migration *move, const struct vor_blob_entry *file,
                            struct vor_error *err)
{
    struct vor_blob_writer *writer = NULL;
    uint64_t size = 0, there = 0;
    int fd = -1, found = 0, is_there = 0;
    vor_status status =
        vor_blob_get(move->from_blobs, &file->id, file->name, &fd, &size, &found, err);

    if (status == VOR_OK && !found)
        status = vor_fail(err, VOR_E_IO, "%s.%s has gone from DATA", file->id.text, file->name);
    VOR_THEN(status,
             vor_blob_get(move->blobs, &file->id, file->name, NULL, &there, &is_there, err));
    if (status == VOR_OK && is_there && there == size) {
        move->files_were_there++;
    } else if (status == VOR_OK) {
        status = vor_blob_create(move->blobs, &writer, err);
        VOR_THEN(status, vor_blob_append_file(writer, fd, 0, size, err));
        if (status == VOR_OK)
            status = vor_blob_commit(writer, &file->id, file->name, err);
        else
            vor_blob_discard(writer);
    }
    if (fd >= 0)
        close(fd);
    move->bytes += size;
    return status;
}

static vor_status copy_files(struct migration *move, struct vor_error *err)
{
    struct vor_blob_list files = {.entry = NULL}, copies = {.entry = NULL};
    vor_status status = vor_blobs_list(move->from_blobs, &files, err);

    for (size_t i = 0; status == VOR_OK && i < files.count; i++)
        status = copy_file(move, &files.entry[i], err);
    VOR_THEN(status, vor_blobs_list(move->blobs, &copies, err));
    if (status == VOR_OK && copies.count != files.count)
        status = vor_fail(
            err, VOR_E_IO,
            "--blobs has %zu files, want exactly the %zu files that DATA refers to: choose "
            "another prefix or folder",
            copies.count, files.count);
    move->files = files.count;
    free(files.entry);
    free(copies.entry);
    return status;
}

static vor_status open_all(struct migration *move, const struct vor_cli *cli, struct vor_error *err)
{
    const struct vor_blob_cache cache = {.data = move->data};
    char where[PATH_MAX];
    vor_status status = VOR_OK;

    (void)snprintf(where, sizeof where, "sqlite:%.4000s/jobs.sqlite", move->data);
    if (access(where + strlen("sqlite:"), R_OK | W_OK) != 0) {
        (void)vor_fail_errno(err, errno, where + strlen("sqlite:"));
        return VOR_E_IO;
    }
    status = vor_store_open(&move->from_store, where, 0, &move->holder, err);
    (void)snprintf(where, sizeof where, "dir:%.4000s/blobs", move->data);
    VOR_THEN(status, vor_blobs_open(&move->from_blobs, where, &cache, &move->holder, err));
    VOR_THEN(status,
             vor_blobs_keep_small(move->from_blobs, vor_store_small_files(move->from_store), err));
    VOR_THEN(status,
             vor_store_open(&move->store, cli->option[VOR_OPTION_STORE], 0, &move->holder, err));
    return status == VOR_OK ? vor_blobs_open(&move->blobs, cli->option[VOR_OPTION_BLOBS], &cache,
                                             &move->holder, err)
                            : status;
}

int vor_cli_migrate(const struct vor_cli *cli)
{
    struct migration move = {.data = cli->operands[0]};
    const char *const none = cli->option[VOR_OPTION_STORE] == NULL   ? "--store"
                             : cli->option[VOR_OPTION_BLOBS] == NULL ? "--blobs"
                                                                     : NULL;
    struct vor_error err;
    vor_status status;
    int code = VOR_EXIT_OK;

    if (none != NULL) {
        char line[64];

        (void)snprintf(line, sizeof line, "no %s: say where the jobs and files go", none);
        vor_cli_say(cli->command->name, line);
        return VOR_EXIT_USAGE;
    }
    status = open_all(&move, cli, &err);
    VOR_THEN(status, copy_files(&move, &err));
    if (status == VOR_OK) /* a job's files are there before it */
        status = vor_store_copy(move.store, move.from_store, &move.jobs, &err);
    if (status == VOR_OK) {
        printf("%llu jobs (%llu were there already) and %zu files (%zu), %.1f MB\n",
               (unsigned long long)move.jobs.jobs, (unsigned long long)move.jobs.were_there,
               move.files, move.files_were_there, (double)move.bytes / 1e6);
        code = fflush(stdout) == 0 ? VOR_EXIT_OK : VOR_EXIT_FAILED;
    } else {
        code = vor_cli_fail(cli->command->name, &err);
        code = move.holder != 0 ? VOR_EXIT_IN_USE : code;
    }
    vor_blobs_close(move.blobs);
    vor_store_close(move.store);
    vor_blobs_close(move.from_blobs);
    vor_store_close(move.from_store);
    return code;
}
