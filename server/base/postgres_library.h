/** libpq, loaded when jobs or files in PostgreSQL are opened: nobody else needs it. The only door
 * to the library. What is used of it is declared here, as libpq.so.5 has had it since
 * PostgreSQL 9.2, so that a build needs no package for it. Thread-safe. */
#ifndef VOR_SERVER_BASE_POSTGRES_LIBRARY_H
#define VOR_SERVER_BASE_POSTGRES_LIBRARY_H

#include "core/base/status.h"

#include <stddef.h>

typedef struct pg_conn PGconn;
typedef struct pg_result PGresult;

/** Values of its enums and types. */
enum {
    VOR_PG_OK = 0,            /**< CONNECTION_OK */
    VOR_PG_COMMAND_OK = 1,    /**< PGRES_COMMAND_OK */
    VOR_PG_TUPLES_OK = 2,     /**< PGRES_TUPLES_OK */
    VOR_PG_DISK_FULL = 53100, /**< SQLSTATE, as a number */
    VOR_PG_BYTEA = 17,        /**< types of values */
    VOR_PG_INT8 = 20,
    VOR_PG_TEXT = 25,
    VOR_PG_FLOAT8 = 701
};

/** A notification, as it begins there. */
struct vor_pg_notify {
    char *channel;
    int from; /**< the backend whose client sent it */
};

/** Its functions: name, result, parameters. */
#define VOR_PG_TABLE(X)                                                                            \
    X(connectdbParams, PGconn *, (const char *const *, const char *const *, int))                  \
    X(finish, void, (PGconn *))                                                                    \
    X(conninfoParse, void *, (const char *, char **))                                              \
    X(conninfoFree, void, (void *))                                                                \
    X(setNoticeProcessor, void *, (PGconn *, void (*)(void *, const char *), void *))              \
    X(status, int, (const PGconn *))                                                               \
    X(errorMessage, char *, (const PGconn *))                                                      \
    X(backendPID, int, (const PGconn *))                                                           \
    X(notifies, struct vor_pg_notify *, (PGconn *))                                                \
    X(socket, int, (const PGconn *))                                                               \
    X(setnonblocking, int, (PGconn *, int))                                                        \
    X(sendQuery, int, (PGconn *, const char *))                                                    \
    X(sendQueryParams, int,                                                                        \
      (PGconn *, const char *, int, const unsigned *, const char *const *, const int *,            \
       const int *, int))                                                                          \
    X(flush, int, (PGconn *))                                                                      \
    X(consumeInput, int, (PGconn *))                                                               \
    X(isBusy, int, (PGconn *))                                                                     \
    X(getResult, PGresult *, (PGconn *))                                                           \
    X(resultStatus, int, (const PGresult *))                                                       \
    X(resultErrorField, char *, (const PGresult *, int))                                           \
    X(ntuples, int, (const PGresult *))                                                            \
    X(getvalue, char *, (const PGresult *, int, int))                                              \
    X(getlength, int, (const PGresult *, int, int))                                                \
    X(getisnull, int, (const PGresult *, int, int))                                                \
    X(cmdTuples, char *, (PGresult *))                                                             \
    X(clear, void, (PGresult *))                                                                   \
    X(unescapeBytea, unsigned char *, (const unsigned char *, size_t *))                           \
    X(freemem, void, (void *))

struct vor_pg {
#define VOR_PG_MEMBER(name, result, parameters) result(*name) parameters;
    VOR_PG_TABLE(VOR_PG_MEMBER)
#undef VOR_PG_MEMBER
};

/** Loads the library, once; *out is never freed.
 *
 *  @retval VOR_E_IO it is not installed, or lacks a function */
VOR_NODISCARD vor_status vor_pg_load(const struct vor_pg **out, struct vor_error *err);

/** The connection string of what follows "--store postgres:" or the like: //HOST/DATABASE is the
 *  rest of a URI. malloc; NULL when memory is out. */
char *vor_pg_where(const char *place);

/** Makes a connection.
 *
 *  @param[in] what  that is there, for messages: "the job database"
 *
 *  @return NULL and *err: VOR_E_IO with the server's reason, or what is wrong with the string,
 * never with a password; VOR_E_NOMEM */
PGconn *vor_pg_connect(const char *where, const char *what, struct vor_error *err);

/** A statement, or several without values: who is told of its failure, and how long it may take. */
struct vor_pg_question {
    const char *what, *sql;
    int count; /**< of the values */
    const unsigned *type;
    const char *const *value;
    const int *length, *format;
    int is_binary;               /**< so is the answer; and there is one statement */
    double seconds;              /**< in which it is to be answered */
    int (*is_wanted)(void *ctx); /**< asked several times a second; NULL: it is */
    void *ctx;
};

/** Asks, and waits for the answer. Where it does not come in time, or is not wanted any more, the
 *  connection is closed: vor_pg.status tells, and nobody knows whether it was done.
 *
 *  @param[out] out  the last result, also of a failure, for the caller to clear; NULL for none
 *
 *  @retval VOR_E_IO the server says no, or nothing; `got` of err is ENOSPC where its disk is full,
 *                   ETIMEDOUT where it did not answer in time */
VOR_NODISCARD vor_status vor_pg_ask(PGresult **out, PGconn *connection,
                                    const struct vor_pg_question *question, struct vor_error *err);

#endif
