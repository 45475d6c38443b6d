/** Questions about many rows and changes of them at once: what time, quotas and a crash do to the
 *  jobs. Functions of the driver (driver.h); sqlite.c alone includes this. */
#ifndef VOR_SERVER_STORE_SQLITE_MANY_H
#define VOR_SERVER_STORE_SQLITE_MANY_H

#include "server/store/driver.h"
#include "server/store/sqlite_database.h"

/** The driver's store. */
struct vor_sqlite_store {
    struct vor_store base;
    int lock;
    struct vor_sqlite *db;
};

static inline struct vor_sqlite *vor_sqlite_of(struct vor_store *store)
{
    return ((struct vor_sqlite_store *)store)->db;
}

vor_status vor_sqlite_evict(struct vor_store *store, enum vor_evict why, int64_t limit,
                            struct vor_evictions *evictions, struct vor_error *err);
vor_status vor_sqlite_forget_uploads(struct vor_store *store, const struct vor_uuid *id,
                                     struct vor_error *err);
vor_status vor_sqlite_shift(struct vor_store *store, int64_t by_ms, struct vor_error *err);
vor_status vor_sqlite_newest(struct vor_store *store, int64_t *newest_ms, struct vor_error *err);
vor_status vor_sqlite_waiting(struct vor_store *store, struct vor_waiting *out,
                              struct vor_error *err);
vor_status vor_sqlite_events(struct vor_store *store, const struct vor_uuid *id,
                             const struct vor_event_query *query, struct vor_error *err);
vor_status vor_sqlite_renew(struct vor_store *store, struct vor_renewal *renewal,
                            struct vor_error *err);
vor_status vor_sqlite_reap(struct vor_store *store, const char *owner, int64_t until_ms,
                           int64_t now_ms, uint64_t *reaped, struct vor_error *err);

#endif
