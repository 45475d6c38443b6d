/** The verbs of a store of rows (driver.h) in SQL, the same for every engine. Only drivers include
 *  this. */
#ifndef VOR_SERVER_STORE_SQL_VERBS_H
#define VOR_SERVER_STORE_SQL_VERBS_H

#include "server/store/driver.h"
#include "server/store/sql.h"

/** What the store of such a driver begins with. */
struct vor_sql_store {
    struct vor_store base;
    struct vor_sql *db;
};

static inline struct vor_sql *vor_sql_of(struct vor_store *store)
{
    return ((struct vor_sql_store *)store)->db;
}

/* One job: sql_verbs.c. */
vor_status vor_sql_insert(struct vor_store *store, struct vor_job_view *row,
                          struct vor_ledger *ledger, struct vor_error *err);
vor_status vor_sql_append_events(struct vor_store *store, const struct vor_job_view *row,
                                 const struct vor_lease *lease, const struct vor_event_piece *piece,
                                 int *changed, struct vor_error *err);
vor_status vor_sql_stop(struct vor_store *store, const struct vor_uuid *id, int *changed,
                        struct vor_error *err);
vor_status vor_sql_hand_back(struct vor_store *store, const struct vor_uuid *id,
                             struct vor_hand_back *run, struct vor_error *err);
vor_status vor_sql_finish(struct vor_store *store, const struct vor_job_view *row,
                          const struct vor_lease *lease, const struct vor_store_ending *ending,
                          int *changed, struct vor_error *err);
vor_status vor_sql_remove(struct vor_store *store, const struct vor_uuid *id, int *changed,
                          struct vor_error *err);
vor_status vor_sql_get(struct vor_store *store, const struct vor_uuid *id, const char *tenant,
                       struct vor_job_view *out, int *found, struct vor_error *err);
vor_status vor_sql_brief(struct vor_store *store, const struct vor_uuid *id,
                         struct vor_job_brief *out, int *found, struct vor_error *err);
vor_status vor_sql_find_key(struct vor_store *store, const struct vor_job_key *key,
                            struct vor_job_view *out, int *found, struct vor_error *err);
vor_status vor_sql_report(struct vor_store *store, const struct vor_uuid *id, char **report,
                          struct vor_error *err);
vor_status vor_sql_list(struct vor_store *store, const struct vor_job_filter *filter,
                        int (*each)(void *ctx, const struct vor_job_view *row), void *ctx,
                        struct vor_error *err);
vor_status vor_sql_claim_next(struct vor_store *store, const struct vor_claim *claim,
                              struct vor_job_view *out, int *found, struct vor_error *err);
vor_status vor_sql_ledger(struct vor_store *store, const char *tenant, struct vor_ledger *ledger,
                          struct vor_error *err);

/* Many at once, what time, quotas and a crash do to the jobs: sql_many.c. */
vor_status vor_sql_evict(struct vor_store *store, enum vor_evict why, int64_t limit,
                         struct vor_evictions *evictions, struct vor_error *err);
vor_status vor_sql_forget_uploads(struct vor_store *store, const struct vor_uuid *id,
                                  struct vor_error *err);
vor_status vor_sql_shift(struct vor_store *store, int64_t by_ms, struct vor_error *err);
vor_status vor_sql_newest(struct vor_store *store, int64_t *newest_ms, struct vor_error *err);
vor_status vor_sql_events(struct vor_store *store, const struct vor_uuid *id,
                          const struct vor_event_query *query, struct vor_error *err);
vor_status vor_sql_waiting(struct vor_store *store, struct vor_waiting *out, struct vor_error *err);
vor_status vor_sql_renew(struct vor_store *store, struct vor_renewal *renewal,
                         struct vor_error *err);
vor_status vor_sql_reap(struct vor_store *store, const char *owner, int is_alone, int64_t now_ms,
                        uint64_t *reaped, struct vor_error *err);

/* Into another database: sql_copy.c. */
vor_status vor_sql_copy_all(struct vor_store *into, struct vor_store *from,
                            struct vor_store_copied *out, struct vor_error *err);

/** The indexes that every engine has, for its schema. */
#define VOR_SQL_INDEXES                                                                            \
    "CREATE INDEX ledger_turn ON ledger (turn);"                                                   \
    "CREATE INDEX job_ready ON job (turn, seq) WHERE status = 'accepted';"                         \
    "CREATE INDEX job_turn ON job (principal, turn) WHERE status = 'accepted';"                    \
    "CREATE INDEX job_status ON job (status, seq) WHERE expired = 0;"                              \
    "CREATE INDEX job_expires ON job (expires) WHERE expires > 0;"                                 \
    "CREATE UNIQUE INDEX job_key ON job (principal, idem_key) WHERE idem_key IS NOT NULL;"         \
    "CREATE INDEX job_kept ON job (finished, seq, kept) WHERE kept > 0;"                           \
    "CREATE INDEX job_held ON job (finished, seq, held) WHERE held > 0;"

/** These rows of a driver's table. */
#define VOR_SQL_VERBS                                                                              \
    .insert = vor_sql_insert, .claim_next = vor_sql_claim_next, .renew = vor_sql_renew,            \
    .append_events = vor_sql_append_events, .stop = vor_sql_stop, .hand_back = vor_sql_hand_back,  \
    .finish = vor_sql_finish, .remove = vor_sql_remove, .get = vor_sql_get,                        \
    .brief = vor_sql_brief, .ledger = vor_sql_ledger, .find_key = vor_sql_find_key,                \
    .report = vor_sql_report, .events = vor_sql_events, .list = vor_sql_list,                      \
    .waiting = vor_sql_waiting, .evict = vor_sql_evict, .forget_uploads = vor_sql_forget_uploads,  \
    .shift = vor_sql_shift, .newest = vor_sql_newest, .reap = vor_sql_reap,                        \
    .copy = vor_sql_copy_all

#endif
