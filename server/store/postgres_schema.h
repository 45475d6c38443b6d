/** The tables of jobs in PostgreSQL, and whether a schema has them. */
#ifndef VOR_SERVER_STORE_POSTGRES_SCHEMA_H
#define VOR_SERVER_STORE_POSTGRES_SCHEMA_H

#include "server/store/postgres_database.h"

/** Gives an empty schema its tables, in one transaction.
 *
 *  @retval VOR_E_IO they are of another version or program (message: which), or the server refuses
 */
VOR_NODISCARD vor_status vor_postgres_prepare_schema(struct vor_postgres *db,
                                                     struct vor_error *err);

#endif
