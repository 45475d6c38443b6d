/** Objects that are deleted by a thread of their own, one after the other, so that nobody waits for
 *  it. What is not deleted when the process ends is found at the next start, as are all files that
 *  belong to no job. The thread also looks whether the other machine answers (vor_objects_state).
 *  Thread-safe. */
#ifndef VOR_SERVER_BLOB_DROPS_H
#define VOR_SERVER_BLOB_DROPS_H

#include "server/blob/objects.h"

struct vor_drops;

/** @param[in] objects  borrowed
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_drops_create(struct vor_drops **out, struct vor_objects *objects,
                                          struct vor_error *err);

/** Deletes what is left, up to the first failure. drops may be NULL. */
void vor_drops_destroy(struct vor_drops *drops);

/** @param[in] before  an object that goes before it, so that none is left without the other; "" for
 *                      none
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_drop(struct vor_drops *drops, const char *key, const char *before,
                                  struct vor_error *err);

/** The key is about to be written: it will not be deleted, and is not being deleted any more. */
void vor_drop_not(struct vor_drops *drops, const char *key);

#endif
