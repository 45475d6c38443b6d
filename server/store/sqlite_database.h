/** A database of SQLite: one connection that writes, durably, and some that read, so that no reader
 *  waits for an fsync, or for another reader. Statements are literals: each connection prepares one
 *  once. The only door to the library; only the other files of the driver include this.
 *  Thread-safe. */
#ifndef VOR_SERVER_STORE_SQLITE_DATABASE_H
#define VOR_SERVER_STORE_SQLITE_DATABASE_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

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

/** A row of a query: its columns, one after the other. Texts and bytes last until each returns. */
struct vor_sqlite_row;
int64_t vor_sqlite_number(struct vor_sqlite_row *row);
double vor_sqlite_real(struct vor_sqlite_row *row);
const char *vor_sqlite_text(struct vor_sqlite_row *row); /**< NULL for null */
const void *vor_sqlite_bytes(struct vor_sqlite_row *row, size_t *size);
/** The next text into a place of so many bytes, cut where it is longer; "" for null. */
void vor_sqlite_copy(struct vor_sqlite_row *row, char *out, size_t size);
/** For a query of one number: ctx is an int64_t. */
int vor_sqlite_take_number(void *ctx, struct vor_sqlite_row *row);

/** Makes what follows on this thread, up to the end, one change: durable when VOR_OK is returned,
 * or none of it happened.
 *
 *  @param[in] status  of what was done between; unless it is VOR_OK all is taken back, and it is
 *                     what is returned
 *
 *  @param[in] how     lazy: a kill of the process undoes nothing, a crash of the machine may undo
 *                     the change, unless a durable one has followed
 *
 *  @retval VOR_E_IO   of begin: nothing has begun, and no end may follow */
enum vor_sqlite_how { VOR_SQLITE_DURABLE, VOR_SQLITE_LAZY };
VOR_NODISCARD vor_status vor_sqlite_begin(struct vor_sqlite *db, enum vor_sqlite_how how,
                                          struct vor_error *err);
VOR_NODISCARD vor_status vor_sqlite_end(struct vor_sqlite *db, vor_status status,
                                        struct vor_error *err);

/** One statement, one transaction unless one has begun: durable when VOR_OK is returned. `types`
 * says what follows, for the statement's parameters from the first on: t text (or NULL), i int64_t,
 * r double, b bytes (pointer or NULL, then size_t); all borrowed for the call.
 *
 *  @param[out] rows  how many the statement changed
 *
 *  @retval VOR_E_IO nothing was changed; `got` of err is ENOSPC when the disk is full */
VOR_NODISCARD vor_status vor_sqlite_change(struct vor_sqlite *db, int *rows, struct vor_error *err,
                                           const char *sql, const char *types, ...);

/** The same for a statement with RETURNING, or a SELECT within a transaction: each gets every row
 * that it returns, before the change is durable. What each was told is void unless VOR_OK is
 * returned. */
VOR_NODISCARD vor_status vor_sqlite_change_each(struct vor_sqlite *db,
                                                void (*each)(void *ctx, struct vor_sqlite_row *row),
                                                void *ctx, struct vor_error *err, const char *sql,
                                                const char *types, ...);

/** Calls each for every row while it answers not 0. each must not query the same database.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_sqlite_query(struct vor_sqlite *db,
                                          int (*each)(void *ctx, struct vor_sqlite_row *row),
                                          void *ctx, struct vor_error *err, const char *sql,
                                          const char *types, ...);

#endif
