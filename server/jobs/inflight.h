/** Keys of requests under way: from the head of a request until its job has a row, or there will be
 *  none. After that the store knows the key. */
#ifndef VOR_SERVER_JOBS_INFLIGHT_H
#define VOR_SERVER_JOBS_INFLIGHT_H

#include "server/jobs/job.h"

/** A set of keys. Thread-safe. */
struct vor_inflight;

/** NULL when memory is out. */
struct vor_inflight *vor_inflight_create(void);

/** inflight may be NULL. */
void vor_inflight_destroy(struct vor_inflight *inflight);

/** Adds a key; the fingerprint does not matter.
 *
 *  @retval VOR_DONE      it is the caller's until vor_inflight_end
 *  @retval VOR_CONFLICT  it is somebody else's
 *  @retval VOR_FAILED    memory is out */
VOR_NODISCARD enum vor_job_outcome vor_inflight_begin(struct vor_inflight *inflight,
                                                      const struct vor_job_key *key);

/** Takes a key off, which must be there. */
void vor_inflight_end(struct vor_inflight *inflight, const struct vor_job_key *key);

#endif
