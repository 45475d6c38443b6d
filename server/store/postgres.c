#include "server/base/postgres_library.h"
#include "server/store/postgres_database.h"
#include "server/store/sql_verbs.h"

#include <stdlib.h>

/* The driver's store. */
struct postgres_store {
    struct vor_sql_store base; /* its db is server's base */
    struct vor_postgres *server;
};

static void close_store(struct vor_store *store)
{
    vor_postgres_close(((struct postgres_store *)store)->server);
    free(store);
}

static int take_secret(void *ctx, struct vor_sql_row *row)
{
    vor_sql_copy(row, ctx, sizeof((struct vor_store *)0)->secret);
    return 1;
}

static vor_status open_server(struct postgres_store *store, const char *where, int may_share,
                              long *holder, struct vor_error *err)
{
    vor_status status = vor_postgres_open(&store->server, where, err);
    int held = 0;

    if (status != VOR_OK)
        return status;
    store->base.db = vor_postgres_sql(store->server);
    if (may_share)
        vor_postgres_share(store->server);
    status = vor_postgres_hold(store->server, &held, err);
    if (status == VOR_OK && !held) {
        *holder = -1;
        return vor_fail(err, VOR_E_IO, "another daemon is already using the job store");
    }
    if (status == VOR_OK)
        status = vor_postgres_prepare_schema(store->server, err);
    return status == VOR_OK ? vor_sql_query(store->base.db, take_secret, store->base.base.secret,
                                            err, "SELECT secret FROM voronoid_schema", "")
                            : status;
}

static vor_status open_store(struct vor_store **out, const char *place, int may_share, long *holder,
                             struct vor_error *err)
{
    struct postgres_store *store = calloc(1, sizeof *store);
    char *where = vor_pg_where(place);
    vor_status status;

    if (store == NULL || where == NULL) {
        free(where);
        free(store);
        return vor_fail(err, VOR_E_NOMEM, "the job store");
    }
    status = open_server(store, where, may_share, holder, err);
    free(where);
    if (status != VOR_OK) {
        close_store(&store->base.base);
        return status;
    }
    *out = &store->base.base;
    return VOR_OK;
}

/* A server that is away may come back. One that was started anew has forgotten whose the tables
 * are: the first daemon that asks then has them. */
static vor_status check(struct vor_store *store, int *is_lost, struct vor_error *err)
{
    int64_t rows;
    int held = 0;
    vor_status status = vor_postgres_hold(((struct postgres_store *)store)->server, &held, err);

    *is_lost = status == VOR_OK && !held;
    if (*is_lost)
        return vor_fail(err, VOR_E_IO, "another daemon is already using the job store");
    if (status != VOR_OK)
        return status;
    return vor_sql_query(vor_sql_of(store), vor_sql_take_number, &rows, err,
                         "SELECT seq FROM job LIMIT 1", "");
}

static vor_status listen_to(struct vor_store *store, const char *where, void (*heard)(void *ctx),
                            void *ctx, struct vor_error *err)
{
    return vor_postgres_listen(((struct postgres_store *)store)->server, where, heard, ctx, err);
}

const struct vor_store_driver vor_store_postgres = {
    .scheme = "postgres",
    .place = "URI",
    .open = open_store,
    .close = close_store,
    .check = check,
    .listen = listen_to,
};
