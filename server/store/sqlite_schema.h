/** The schema of the table of jobs, and how a file of each former version becomes one of this. */
#ifndef VOR_SERVER_STORE_SQLITE_SCHEMA_H
#define VOR_SERVER_STORE_SQLITE_SCHEMA_H

#include "server/store/sqlite_database.h"

/** Brings a database up to this program's version, in one transaction; an empty one gets its table.
 *
 *  @retval VOR_E_IO it is of a newer version (message: both), or the disk refuses */
VOR_NODISCARD vor_status vor_sqlite_migrate(struct vor_sqlite *db, struct vor_error *err);

#endif
