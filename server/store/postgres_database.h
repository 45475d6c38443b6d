/** The engine of PostgreSQL. A connection that broke is made anew by the next statement; what was
 *  under way on it fails. Works through pgbouncer in transaction mode: nothing is prepared, and
 *  nothing is set for longer than a transaction. Only the other files of the driver include this.
 *  Thread-safe. */
#ifndef VOR_SERVER_STORE_POSTGRES_DATABASE_H
#define VOR_SERVER_STORE_POSTGRES_DATABASE_H

#include "server/store/sql.h"

struct vor_postgres;

/** Connects to a database.
 *
 *  @param[out] out    free with vor_postgres_close
 *  @param[in]  where  a connection string or URI as libpq has it; copied
 *
 *  @retval VOR_E_IO no libpq, or the server refuses (message: its reason, never a password)
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_postgres_open(struct vor_postgres **out, const char *where,
                                           struct vor_error *err);

/** db may be NULL. */
void vor_postgres_close(struct vor_postgres *db);

/** The database, for statements. */
struct vor_sql *vor_postgres_sql(struct vor_postgres *db);

/** Runs statements without parameters, all or none.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_postgres_run(struct vor_postgres *db, const char *sql,
                                          struct vor_error *err);

/** Other daemons may have the tables as well: the lock that vor_postgres_hold takes excludes only
 *  those that want them for themselves, and the changes of all daemons are made one after the
 *  other. Call it before vor_postgres_hold and before any change. */
void vor_postgres_share(struct vor_postgres *db);

/** Takes the lock that says whose the tables are, on a connection of its own, or makes sure that it
 *  is still there. The server gives it up when that connection ends, so not behind pgbouncer in
 *  transaction mode.
 *
 *  @param[out] held  0: another daemon has it
 *
 *  @retval VOR_E_IO  also while the process of a former connection of this one has it, which the
 *                    server is told to end */
VOR_NODISCARD vor_status vor_postgres_hold(struct vor_postgres *db, int *held,
                                           struct vor_error *err);

/** Has the other daemons told of each change, and this one of theirs (postgres_hints.h); where
 * NULL: ends that. For one thread. */
VOR_NODISCARD vor_status vor_postgres_listen(struct vor_postgres *db, const char *where,
                                             void (*heard)(void *ctx), void *ctx,
                                             struct vor_error *err);

/** Gives an empty schema its tables, in one transaction.
 *
 *  @retval VOR_E_IO they are of another version or program (message: which), or the server refuses
 */
VOR_NODISCARD vor_status vor_postgres_prepare_schema(struct vor_postgres *db,
                                                     struct vor_error *err);

#endif
