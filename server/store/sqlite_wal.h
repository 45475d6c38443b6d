/** Is the write-ahead log of a database whole? SQLite itself takes a damaged one up to the damage
 * and says nothing of the changes behind it. */
#ifndef VOR_SERVER_STORE_SQLITE_WAL_H
#define VOR_SERVER_STORE_SQLITE_WAL_H

/** True when changes that were written to PATH-wal are lost: a frame of the log's present round
 * (its salts say so) does not continue the chain of checksums, or the log's own head does not.
 * False when there is no log. Call before the database is opened.
 *
 *  A last frame that a crash cut short counts only if it was to end a change: that looks the same
 * as one that has lost it, and what is done about it must do no harm.
 *
 *  Cost: reads the file once. Source: the file format at sqlite.org/fileformat2.html, sec. 4. */
int vor_sqlite_wal_is_damaged(const char *path);

#endif
