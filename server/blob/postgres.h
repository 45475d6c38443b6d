/** Objects as rows of a PostgreSQL database, in pieces of 1 MiB, each with its SHA-256: every piece
 *  is compared before it is passed on. The tables voronoid_file and voronoid_piece stand in the
 *  first schema of the search path, and are made if missing. The place is a connection string or
 * URI as libpq has it.
 *
 *  A put is one transaction; a get reads piece by piece and is begun anew where the object was
 *  replaced meanwhile. Works through pgbouncer in transaction mode. libpq is loaded when such a
 * place is opened. */
#ifndef VOR_SERVER_BLOB_POSTGRES_H
#define VOR_SERVER_BLOB_POSTGRES_H

#include "server/blob/objects.h"

extern const struct vor_objects_kind vor_postgres_objects;

#endif
