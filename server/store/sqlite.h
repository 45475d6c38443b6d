/** The store in a file of SQLite: WAL mode with synchronous=FULL. PATH.lock says that the file is
 *  ours. One connection writes and others read, so that no reader waits for an fsync.
 *
 *  Cost: a change is one transaction and one fsync, 0.2 to 5 ms; a read some 20 microseconds. */
#ifndef VOR_SERVER_STORE_SQLITE_H
#define VOR_SERVER_STORE_SQLITE_H

#include "server/store/driver.h"

extern const struct vor_store_driver vor_store_sqlite;

#endif
