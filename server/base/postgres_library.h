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

/** Its functions: name, result, parameters. */
#define VOR_PG_TABLE(X)                                                                            \
    X(connectdbParams, PGconn *, (const char *const *, const char *const *, int))                  \
    X(finish, void, (PGconn *))                                                                    \
    X(conninfoParse, void *, (const char *, char **))                                              \
    X(conninfoFree, void, (void *))                                                                \
    X(setNoticeProcessor, void *, (PGconn *, void (*)(void *, const char *), void *))              \
    X(status, int, (const PGconn *))                                                               \
    X(errorMessage, char *, (const PGconn *))                                                      \
    X(exec, PGresult *, (PGconn *, const char *))                                                  \
    X(execParams, PGresult *,                                                                      \
      (PGconn *, const char *, int, const unsigned *, const char *const *, const int *,            \
       const int *, int))                                                                          \
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

/** VOR_E_IO with the first line of a reason; got is ENOSPC where the state (SQLSTATE or NULL) says
 *  that the disk is full. */
vor_status vor_pg_fail(const char *what, const char *why, const char *state, struct vor_error *err);

/** The same, for a statement; result may be NULL. */
vor_status vor_pg_fail_result(const char *what, const PGconn *connection, const PGresult *result,
                              struct vor_error *err);

#endif
