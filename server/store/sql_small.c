/* Small files beside the rows. A change of them waits for no disk: the log is one file, so that
 * the next durable change makes what was written before it durable as well. */
#include "server/store/sql_verbs.h"
#include "server/store/store.h"

struct taking {
    void (*take)(void *of, const void *bytes, size_t size);
    void (*each)(void *of, const char *name, size_t size);
    void *of;
    int only_size;
};

static int take_file(void *ctx, struct vor_sql_row *row)
{
    const struct taking *taking = ctx;
    size_t size = (size_t)vor_sql_number(row), read;
    const void *bytes = vor_sql_bytes(row, &read); /* of no bytes NULL as well */

    taking->take(taking->of, bytes != NULL || taking->only_size ? bytes : "", size);
    return 0;
}

static int take_name(void *ctx, struct vor_sql_row *row)
{
    const struct taking *taking = ctx;
    const char *name = vor_sql_text(row);

    taking->each(taking->of, name, (size_t)vor_sql_number(row));
    return 1;
}

static vor_status take_out(void *ctx, const char *name, uint64_t *was, struct vor_error *err)
{
    int64_t size = 0;
    vor_status status =
        vor_sql_change_each(ctx, vor_sql_take_number, &size, err,
                            "DELETE FROM small_file WHERE name = ? RETURNING size", "t", name);

    *was = (uint64_t)size;
    return status;
}

static vor_status put(void *ctx, const char *name, const void *bytes, size_t size, uint64_t *was,
                      struct vor_error *err)
{
    vor_status status = vor_sql_begin(ctx, VOR_SQL_LAZY, err);

    if (status != VOR_OK)
        return status;
    status = take_out(ctx, name, was, err);
    VOR_THEN(status, vor_sql_change(ctx, NULL, err, "INSERT INTO small_file VALUES (?, ?, ?)",
                                    "tib", name, (int64_t)size, bytes, size));
    return vor_sql_end(ctx, status, err);
}

static vor_status get(void *ctx, const char *name, int only_size,
                      void (*take)(void *of, const void *bytes, size_t size), void *of,
                      struct vor_error *err)
{
    struct taking taking = {.take = take, .of = of, .only_size = only_size};

    return vor_sql_query(ctx, take_file, &taking, err,
                         "SELECT size, CASE ?2 WHEN 0 THEN data END FROM small_file"
                         " WHERE name = ?1",
                         "ti", name, (int64_t)only_size);
}

/* Most names that are dropped were never there: a look is cheaper than a change. */
static vor_status drop(void *ctx, const char *name, uint64_t *was, struct vor_error *err)
{
    struct vor_error why = {.status = VOR_OK};
    int64_t found = 0;
    vor_status status = vor_sql_query(ctx, vor_sql_take_number, &found, err,
                                      "SELECT 1 FROM small_file WHERE name = ?", "t", name);

    *was = 0;
    if (status != VOR_OK || !found)
        return status;
    err = err != NULL ? err : &why; /* which says whether the disk is full */
    do {
        status = vor_sql_begin(ctx, VOR_SQL_LAZY, err);
        if (status == VOR_OK)
            status = vor_sql_end(ctx, take_out(ctx, name, was, err), err);
    } while (vor_store_made_room(ctx, status, err));
    return status;
}

static vor_status list(void *ctx, void (*each)(void *of, const char *name, size_t size), void *of,
                       struct vor_error *err)
{
    struct taking taking = {.each = each, .of = of};

    return vor_sql_query(ctx, take_name, &taking, err, "SELECT name, size FROM small_file", "");
}

const struct vor_small_files *vor_store_small_files(struct vor_store *store)
{
    if (!store->driver->is_file)
        return NULL;
    store->small =
        (struct vor_small_files){.ctx = store, .put = put, .get = get, .drop = drop, .list = list};
    return &store->small;
}
