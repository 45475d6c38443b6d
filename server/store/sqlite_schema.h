/** The schema of the table of jobs, and whether a file has it. */
#ifndef VOR_SERVER_STORE_SQLITE_SCHEMA_H
#define VOR_SERVER_STORE_SQLITE_SCHEMA_H

#include "server/store/sqlite_database.h"

/** Gives an empty database its table, in one transaction.
 *
 *  @retval VOR_E_IO it is of another version (message: both), or the disk refuses */
VOR_NODISCARD vor_status vor_sqlite_prepare_schema(struct vor_sqlite *db, struct vor_error *err);

#endif
