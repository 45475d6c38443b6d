/** A disk that takes its time: fsync and fdatasync of the whole process, SQLite's among them, pass
 *  through a gate. It is open until a test closes it, and shared with the children of the test. */
#ifndef VT_SYNC_H
#define VT_SYNC_H

/** From now on syncs of rows (fdatasync, SQLite's), or of bytes (fsync), fail with EIO, or do not.
 */
void vt_sync_fail(int rows, int bytes);

/** Lets so many syncs pass from now on; those that come after them wait, 30 seconds at most. */
void vt_sync_close_after(int passing);

/** How many may still pass. */
int vt_sync_left(void);

/** Lets all pass again, those that wait first of all. False when one of them waited all of its
 *  30 seconds: whoever should have opened the gate waited for that sync. */
int vt_sync_open(void);

/** How many wait at the gate. */
int vt_sync_waiting(void);

#endif
