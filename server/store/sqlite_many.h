/** Questions about many rows and changes of them at once: what time, the quota of kept uploads and
 * a crash do to the jobs. Each does what the function of store.h with its name promises; sqlite.c
 * alone includes this. */
#ifndef VOR_SERVER_STORE_SQLITE_MANY_H
#define VOR_SERVER_STORE_SQLITE_MANY_H

#include "server/store/driver.h"
#include "server/store/sqlite_database.h"

VOR_NODISCARD vor_status vor_sqlite_expire(struct vor_sqlite *db, int64_t now_ms,
                                           struct vor_expired *expired, size_t max, size_t *count,
                                           struct vor_error *err);

VOR_NODISCARD vor_status vor_sqlite_held(struct vor_sqlite *db, const char *tenant, uint64_t *bytes,
                                         struct vor_error *err);

VOR_NODISCARD vor_status vor_sqlite_shed(struct vor_sqlite *db, uint64_t quota,
                                         struct vor_expired *shed, size_t max, size_t *count,
                                         struct vor_error *err);

VOR_NODISCARD vor_status vor_sqlite_crowd(struct vor_sqlite *db, uint64_t quota,
                                          struct vor_expired *crowded, size_t max, size_t *count,
                                          struct vor_error *err);
vor_status vor_sqlite_shift(struct vor_sqlite *db, int64_t by_ms, struct vor_error *err);
vor_status vor_sqlite_newest(struct vor_sqlite *db, int64_t *newest_ms, struct vor_error *err);
VOR_NODISCARD vor_status vor_sqlite_recover(struct vor_sqlite *db, int64_t now_ms,
                                            uint64_t *requeued, struct vor_error *err);
VOR_NODISCARD vor_status vor_sqlite_crashed(struct vor_sqlite *db, const struct vor_uuid *id,
                                            struct vor_crashed_run *run, struct vor_error *err);

#endif
