#include "server/base/disk.h"
#include "server/store/sql_verbs.h"
#include "server/store/sqlite_database.h"
#include "server/store/sqlite_wal.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The driver's store. */
struct sqlite_store {
    struct vor_sql_store base; /* its db is file's base */
    struct vor_sqlite *file;
    int lock;
};

static vor_status open_file(struct sqlite_store *store, const char *path, long *holder,
                            struct vor_error *err)
{
    const char *slash = strrchr(path, '/');
    char name[4096];
    vor_status status = VOR_OK;

    if ((size_t)snprintf(name, sizeof name, "%s.lock", path) >= sizeof name)
        return vor_fail_errno(err, ENAMETOOLONG, "the job store");
    if (slash != NULL && slash != path) {
        char *folder = strndup(path, (size_t)(slash - path));

        status = folder != NULL ? vor_storage_directory(folder, err)
                                : vor_fail(err, VOR_E_NOMEM, "the path of the job store");
        free(folder);
    }
    if (status == VOR_OK)
        status = vor_storage_lock(&store->lock, name, holder, err);
    if (status != VOR_OK)
        return status;
    store->base.base.is_damaged = vor_sqlite_wal_is_damaged(path);
    status = vor_sqlite_open(&store->file, path, err);
    if (status != VOR_OK)
        return status;
    store->base.db = vor_sqlite_sql(store->file);
    return vor_sqlite_prepare_schema(store->file, err);
}

static void free_store(struct sqlite_store *store)
{
    vor_sqlite_close(store->file);
    if (store->lock >= 0)
        close(store->lock);
    free(store);
}

static void close_store(struct vor_store *store)
{
    free_store((struct sqlite_store *)store);
}

static vor_status open_store(struct vor_store **out, const char *place, VOR_UNUSED int may_share,
                             long *holder, struct vor_error *err)
{
    struct sqlite_store *store = calloc(1, sizeof *store);
    vor_status status;

    if (store == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the job store");
    store->lock = -1;
    status = open_file(store, place, holder, err);
    if (status != VOR_OK) {
        free_store(store);
        return status;
    }
    *out = (struct vor_store *)store;
    return VOR_OK;
}

static vor_status check(struct vor_store *store, int *is_lost, struct vor_error *err)
{
    int64_t rows;
    vor_status status;

    if (vor_sqlite_broken(((struct sqlite_store *)store)->file))
        status = vor_fail(err, VOR_E_IO, "the job store cannot be used because its disk failed");
    else
        status = vor_sql_query(vor_sql_of(store), vor_sql_take_number, &rows, err,
                               "SELECT seq FROM job LIMIT 1", "");
    *is_lost = status != VOR_OK;
    return status;
}

const struct vor_store_driver vor_store_sqlite = {
    .scheme = "sqlite",
    .place = "PATH",
    .is_file = 1,
    .open = open_store,
    .close = close_store,
    .check = check,
};
