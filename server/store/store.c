#include "server/store/store.h"

#include "server/base/disk.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const struct vor_store_driver *const drivers[] = {&vor_store_sqlite, &vor_store_postgres};

const struct vor_store_driver *vor_store_driver_at(unsigned index)
{
    return index < sizeof drivers / sizeof drivers[0] ? drivers[index] : NULL;
}

static vor_status open_reserve(struct vor_reserve **out, const char *place, struct vor_error *err)
{
    char path[4096];

    if ((size_t)snprintf(path, sizeof path, "%s.reserve", place) >= sizeof path)
        return vor_fail_errno(err, ENAMETOOLONG,
                              "the file that reserves space for the job "
                              "store");
    return vor_reserve_open(out, path, err);
}

static vor_status open_with(const struct vor_store_driver *driver, struct vor_store **out,
                            const char *place, int may_share, long *holder, struct vor_error *err)
{
    struct vor_reserve *reserve = NULL;
    vor_status status = driver->is_file ? open_reserve(&reserve, place, err) : VOR_OK;

    if (status == VOR_OK)
        do
            status = driver->open(out, place, may_share, holder, err);
        while (vor_reserve_made_room(reserve, 1, status, err));
    if (status != VOR_OK) {
        vor_reserve_close(reserve);
        return status;
    }
    (*out)->driver = driver;
    (*out)->is_shared = may_share && !driver->is_file;
    (*out)->reserve = reserve;
    return VOR_OK;
}

vor_status vor_store_open(struct vor_store **out, const char *where, int may_share, long *holder,
                          struct vor_error *err)
{
    const struct vor_store_driver *driver;
    char forms[128] = "";
    size_t at = 0;

    *holder = 0;
    if (strncmp(where, "postgresql://", 13) == 0) /* the other form of its URIs */
        return open_with(&vor_store_postgres, out, where, may_share, holder, err);
    for (unsigned i = 0; (driver = vor_store_driver_at(i)) != NULL; i++) {
        const char *place = vor_storage_place(where, driver->scheme);

        if (place != NULL)
            return open_with(driver, out, place, may_share, holder, err);
    }
    for (unsigned i = 0; (driver = vor_store_driver_at(i)) != NULL && at < sizeof forms; i++)
        at += (size_t)snprintf(forms + at, sizeof forms - at, "%s%s:%s", i > 0 ? " or " : "",
                               driver->scheme, driver->place);
    /* What follows the scheme may hold a password. */
    return vor_fail_param(err, VOR_E_IO, "store", "store is \"%.*s%s\", want %s",
                          (int)strcspn(where, ":"), where, strchr(where, ':') != NULL ? ":..." : "",
                          forms);
}

void vor_store_close(struct vor_store *store)
{
    if (store != NULL)
        store->driver->close(store);
}

void vor_store_set_reserve(struct vor_store *store, uint64_t bytes)
{
    if (store->reserve != NULL)
        vor_reserve_want(store->reserve, bytes);
}

vor_status vor_store_keep_reserve(struct vor_store *store, struct vor_error *err)
{
    return store->reserve != NULL ? vor_reserve_make(store->reserve, err) : VOR_OK;
}

vor_status vor_store_check_reserve(struct vor_store *store, struct vor_error *err)
{
    return vor_reserve_check(store->reserve, err);
}

vor_status vor_store_give_back(struct vor_store *store, int64_t *left, struct vor_error *err)
{
    *left = 0;
    return store->driver->give_back != NULL ? store->driver->give_back(store, left, err) : VOR_OK;
}

int vor_store_made_room(struct vor_store *store, vor_status status, const struct vor_error *err)
{
    int64_t left;

    if (!vor_reserve_made_room(store->reserve, 0, status, err))
        return 0;
    /* Before others take what was given up. */
    (void)(vor_store_give_back(store, &left, NULL) == VOR_OK);
    return 1;
}
