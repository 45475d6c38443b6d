/** A store whose rows are in a database that speaks SQL: one connection that writes and some that
 * read, so that no reader waits for a durable change, or for another reader. Each kind of database
 * is a table of functions (struct vor_sql_engine) that its own files declare; statements are the
 * same for all. Statements are literals, in the words of SQLite: ?1, max(a, b), INDEXED BY;
 * clock_ms() is the time of the database in milliseconds since 1970. An engine that has others
 * translates them. Only drivers of stores include this. Thread-safe. */
#ifndef VOR_SERVER_STORE_SQL_H
#define VOR_SERVER_STORE_SQL_H

#include "server/store/driver.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

/** Connections to read by. Lists read two at a time, off the threads of HTTP, so that these find
 * one that is free. */
enum { VOR_SQL_READERS = 4 };

/** What the store of such a driver begins with. */
struct vor_sql {
    struct vor_store base;
    const struct vor_sql_engine *engine;
    pthread_mutex_t writing; /**< the engine's; recursive: a transaction has several statements */
    pthread_mutex_t reader[VOR_SQL_READERS]; /**< who reads by which */
    atomic_uint next_reader;                 /**< to wait for where none is free */
    atomic_int is_unsure; /**< the engine's: of some change nobody knows whether it was made */
};

/** A row that a statement returns: its columns, one after the other. Texts and bytes last until the
 *  function that got the row returns. */
struct vor_sql_row {
    const struct vor_sql_engine *engine;
    void *of;   /**< the engine's */
    int column; /**< the next one */
};

/** Whether a kill of the process alone undoes nothing (lazy), or a crash of the machine either; or
 *  lazy, and of rows of this process alone, so that it need not wait for changes of others. */
enum vor_sql_how { VOR_SQL_DURABLE, VOR_SQL_LAZY, VOR_SQL_APART };

/** The values of a statement's parameters, from the first on; borrowed. */
enum { VOR_SQL_VALUES_MAX = 21 };
struct vor_sql_values {
    unsigned count;
    struct vor_sql_value {
        char type; /**< as in the types of vor_sql_change */
        int64_t number;
        double real;
        const void *bytes; /**< of a text, with its NUL; NULL for null */
        size_t size;       /**< of bytes that are no text */
    } value[VOR_SQL_VALUES_MAX];
};

/** A change: who gets the rows that it returns (each may be NULL), and how many it changed. */
struct vor_sql_changing {
    int (*each)(void *ctx, struct vor_sql_row *row);
    void *ctx;
    int rows;
};

/** The functions of an engine; each does what the function below with its name promises. */
struct vor_sql_engine {
    const char *name; /**< label of the metrics */
    int64_t (*number)(void *of, int column);
    double (*real)(void *of, int column);
    const char *(*text)(void *of, int column);
    const void *(*bytes)(void *of, int column, size_t *size);
    vor_status (*begin)(struct vor_sql *db, enum vor_sql_how how, struct vor_error *err);
    vor_status (*end)(struct vor_sql *db, vor_status status, struct vor_error *err);
    vor_status (*change)(struct vor_sql *db, struct vor_sql_changing *changing,
                         struct vor_error *err, const char *sql,
                         const struct vor_sql_values *values);
    vor_status (*run)(struct vor_sql *db, const char *sql, struct vor_error *err);
    /** By that reader, which no other thread uses meanwhile. */
    vor_status (*query)(struct vor_sql *db, unsigned reader,
                        int (*each)(void *ctx, struct vor_sql_row *row), void *ctx,
                        struct vor_error *err, const char *sql,
                        const struct vor_sql_values *values);
};

/** Of a database that is all zero; of one that no thread uses any more. */
void vor_sql_init(struct vor_sql *db, const struct vor_sql_engine *engine);
void vor_sql_destroy(struct vor_sql *db);

/** The next column of a row. */
int64_t vor_sql_number(struct vor_sql_row *row);
double vor_sql_real(struct vor_sql_row *row);
const char *vor_sql_text(struct vor_sql_row *row); /**< NULL for null */
const void *vor_sql_bytes(struct vor_sql_row *row, size_t *size);
/** The next text into a place of so many bytes, cut where it is longer; "" for null. */
void vor_sql_copy(struct vor_sql_row *row, char *out, size_t size);
/** For a statement that returns one number: ctx is an int64_t. */
int vor_sql_take_number(void *ctx, struct vor_sql_row *row);

/** Makes what follows on this thread, up to the end, one change: durable when VOR_OK is returned,
 * or none of it happened.
 *
 *  @param[in] status  of what was done between; unless it is VOR_OK all is taken back, and it is
 *                     what is returned
 *
 *  @param[in] how     a lazy change is durable once a durable one has followed
 *
 *  @retval VOR_E_IO   of begin: nothing has begun, and no end may follow */
VOR_NODISCARD vor_status vor_sql_begin(struct vor_store *store, enum vor_sql_how how,
                                       struct vor_error *err);
VOR_NODISCARD vor_status vor_sql_end(struct vor_store *store, vor_status status,
                                     struct vor_error *err);

/** One statement, one transaction unless one has begun: durable when VOR_OK is returned. `types`
 * says what follows, for the statement's parameters from the first on: t text (or NULL), i int64_t,
 * r double, b bytes (pointer or NULL, then size_t); all borrowed for the call.
 *
 *  @param[out] rows  how many the statement changed; may be NULL
 *
 *  @retval VOR_E_IO nothing was changed; `got` of err is ENOSPC when the disk is full */
VOR_NODISCARD vor_status vor_sql_change(struct vor_store *store, int *rows, struct vor_error *err,
                                        const char *sql, const char *types, ...);

/** The same for a statement with RETURNING, or a SELECT within a transaction: each gets the rows
 * that it returns, at least until it answers 0, before the change is durable. What each got is void
 * unless VOR_OK is returned.
 */
VOR_NODISCARD vor_status vor_sql_change_each(struct vor_store *store,
                                             int (*each)(void *ctx, struct vor_sql_row *row),
                                             void *ctx, struct vor_error *err, const char *sql,
                                             const char *types, ...);

/** Calls each for every row while it answers not 0. each must not query the same database.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_sql_query(struct vor_store *store,
                                       int (*each)(void *ctx, struct vor_sql_row *row), void *ctx,
                                       struct vor_error *err, const char *sql, const char *types,
                                       ...);

/** Runs statements without parameters, all or none: changes of the tables themselves. */
VOR_NODISCARD vor_status vor_sql_run(struct vor_store *store, const char *sql,
                                     struct vor_error *err);

#endif
