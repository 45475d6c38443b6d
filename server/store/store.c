#include "server/store/store.h"

#include "server/base/disk.h"
#include "server/store/sqlite.h"

#include <assert.h>
#include <stdio.h>

static const struct vor_store_driver *const drivers[] = {&vor_store_sqlite};

const struct vor_store_driver *vor_store_driver_at(unsigned index)
{
    return index < sizeof drivers / sizeof drivers[0] ? drivers[index] : NULL;
}

static vor_status refuse(const char *where, struct vor_error *err)
{
    const struct vor_store_driver *driver;
    char forms[128] = "";
    size_t at = 0;

    for (unsigned i = 0; (driver = vor_store_driver_at(i)) != NULL && at < sizeof forms; i++)
        at += (size_t)snprintf(forms + at, sizeof forms - at, "%s%s:%s", i > 0 ? " or " : "",
                               driver->scheme, driver->place);
    return vor_fail_param(err, VOR_E_PARAM, "store", "store is \"%.80s\", want %s", where, forms);
}

static vor_status open_with(const struct vor_store_driver *driver, struct vor_store **out,
                            const char *place, long *holder, struct vor_error *err)
{
    vor_status status = driver->open(out, place, holder, err);

    if (status == VOR_OK)
        (*out)->driver = driver;
    return status;
}

vor_status vor_store_open(struct vor_store **out, const char *where, long *holder,
                          struct vor_error *err)
{
    const struct vor_store_driver *driver;

    *holder = 0;
    for (unsigned i = 0; (driver = vor_store_driver_at(i)) != NULL; i++) {
        const char *place = vor_storage_place(where, driver->scheme);

        if (place != NULL)
            return open_with(driver, out, place, holder, err);
    }
    return refuse(where, err);
}

void vor_store_close(struct vor_store *store)
{
    if (store != NULL)
        store->driver->close(store);
}

vor_status vor_store_check(struct vor_store *store, struct vor_error *err)
{
    return store->driver->check(store, err);
}

vor_status vor_store_insert(struct vor_store *store, struct vor_job_view *row,
                            struct vor_error *err)
{
    return store->driver->insert(store, row, err);
}

vor_status vor_store_claim(struct vor_store *store, const struct vor_uuid *id, int64_t now_ms,
                           uint32_t *attempt, int *changed, struct vor_error *err)
{
    return store->driver->claim(store, id, now_ms, attempt, changed, err);
}

vor_status vor_store_beat(struct vor_store *store, const struct vor_job_view *row,
                          struct vor_error *err)
{
    return store->driver->beat(store, row, err);
}

vor_status vor_store_release(struct vor_store *store, const struct vor_uuid *id, uint32_t attempt,
                             int64_t now_ms, int *changed, struct vor_error *err)
{
    return store->driver->release(store, id, attempt, now_ms, changed, err);
}

vor_status vor_store_crashed(struct vor_store *store, const struct vor_uuid *id,
                             struct vor_crashed_run *run, struct vor_error *err)
{
    return store->driver->crashed(store, id, run, err);
}

vor_status vor_store_finish(struct vor_store *store, const struct vor_job_view *row,
                            uint32_t attempt, const struct vor_store_ending *ending, int *changed,
                            struct vor_error *err)
{
    static const struct vor_store_ending nothing;

    assert(vor_job_status_over(row->status));
    return store->driver->finish(store, row, attempt, ending != NULL ? ending : &nothing, changed,
                                 err);
}

vor_status vor_store_get(struct vor_store *store, const struct vor_uuid *id,
                         struct vor_job_view *out, int *found, struct vor_error *err)
{
    return store->driver->get(store, id, out, found, err);
}

vor_status vor_store_find_key(struct vor_store *store, const struct vor_job_key *key,
                              struct vor_job_view *out, int *found, struct vor_error *err)
{
    return store->driver->find_key(store, key, out, found, err);
}

vor_status vor_store_report(struct vor_store *store, const struct vor_uuid *id, char **report,
                            struct vor_error *err)
{
    return store->driver->report(store, id, report, err);
}

vor_status vor_store_trace(struct vor_store *store, const struct vor_uuid *id, uint8_t **trace,
                           size_t *size, struct vor_error *err)
{
    return store->driver->trace(store, id, trace, size, err);
}

vor_status vor_store_list(struct vor_store *store, const struct vor_job_filter *filter,
                          int (*each)(void *ctx, const struct vor_job_view *row), void *ctx,
                          struct vor_error *err)
{
    return store->driver->list(store, filter, each, ctx, err);
}

vor_status vor_store_waiting(struct vor_store *store,
                             int (*each)(void *ctx, const struct vor_job_view *row), void *ctx,
                             struct vor_error *err)
{
    return store->driver->waiting(store, each, ctx, err);
}

vor_status vor_store_remove(struct vor_store *store, const struct vor_uuid *id, int *changed,
                            struct vor_error *err)
{
    return store->driver->remove(store, id, changed, err);
}

vor_status vor_store_expire(struct vor_store *store, int64_t now_ms, struct vor_expired *expired,
                            size_t max, size_t *count, struct vor_error *err)
{
    return store->driver->expire(store, now_ms, expired, max, count, err);
}

vor_status vor_store_shed(struct vor_store *store, uint64_t quota, struct vor_expired *shed,
                          size_t max, size_t *count, struct vor_error *err)
{
    return store->driver->shed(store, quota, shed, max, count, err);
}

vor_status vor_store_recover(struct vor_store *store, const struct vor_crash *crash,
                             struct vor_recovered *recovered, struct vor_error *err)
{
    return store->driver->recover(store, crash, recovered, err);
}
