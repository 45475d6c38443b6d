/** The store in a database of PostgreSQL, from version 13 on: its tables stand in the first schema
 *  of the search path, and one daemon at a time has them. So jobs outlive the machine, and a daemon
 *  that starts elsewhere goes on with them.
 *
 *  Cost: a change is one transaction, of three to five round trips; a read one round trip. libpq is
 *  loaded when such a store is opened. */
#ifndef VOR_SERVER_STORE_POSTGRES_H
#define VOR_SERVER_STORE_POSTGRES_H

#include "server/store/driver.h"

extern const struct vor_store_driver vor_store_postgres;

#endif
