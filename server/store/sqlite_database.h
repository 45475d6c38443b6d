/** The engine of SQLite: each connection prepares a statement once. The only door to the library;
 *  only the other files of the driver include this. Thread-safe. */
#ifndef VOR_SERVER_STORE_SQLITE_DATABASE_H
#define VOR_SERVER_STORE_SQLITE_DATABASE_H

#include "server/store/sql.h"

struct vor_sqlite;

/** Opens or makes the file, in WAL mode with synchronous=FULL.
 *
 *  @retval VOR_E_IO not a database, or the disk refuses; VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_sqlite_open(struct vor_sqlite **out, const char *path,
                                         struct vor_error *err);

/** db may be NULL. */
void vor_sqlite_close(struct vor_sqlite *db);

/** True since an fsync failed or the file proved damaged: what is on the disk is not known any more
 *  and every change is refused. A want of memory is no such failure. */
int vor_sqlite_broken(struct vor_sqlite *db);

/** Runs statements without parameters; a transaction that they have not ended is taken back.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_sqlite_run(struct vor_sqlite *db, const char *sql,
                                        struct vor_error *err);

/** The database, for statements. */
struct vor_sql *vor_sqlite_sql(struct vor_sqlite *db);

/** Gives an empty database its table, in one transaction.
 *
 *  @retval VOR_E_IO it is of another version (message: both), or the disk refuses */
VOR_NODISCARD vor_status vor_sqlite_prepare_schema(struct vor_sqlite *db, struct vor_error *err);

#endif
