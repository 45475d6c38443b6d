/** Bytes on the disk beside the digest that they had when they were written, before they are sent:
 * a file is read once by a thread of its own, and what was found holds for some minutes, so that
 *  ranges and repeated downloads cost nothing more. Small files that stand in the store are read
 *  each time. Thread-safe.
 *
 *  What that costs: one pass of SHA-256 before the first byte, measured in verify.c; HTTP threads
 *  do not wait for it. */
#ifndef VOR_SERVER_WORK_VERIFY_H
#define VOR_SERVER_WORK_VERIFY_H

#include "server/blob/blob.h"
#include "server/work/thread_pool.h"

#include <stdint.h>

struct vor_verify;

/** @param[in] blobs  of vor_fetch; borrowed
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_verify_create(struct vor_verify **out, struct vor_blobs *blobs,
                                           struct vor_error *err);

/** Wakes the requests that still wait. verify may be NULL. */
void vor_verify_destroy(struct vor_verify *verify);

enum vor_verdict {
    VOR_VERDICT_SOUND,
    VOR_VERDICT_DAMAGED,
    VOR_VERDICT_WAIT,  /**< wake will be called; then ask again */
    VOR_VERDICT_FAILED /**< memory is out, or too many are asked about at once: try again later */
};

/** Are the first `size` bytes of a file those of a digest?
 *
 *  @param[in] fd      borrowed for the call
 *  @param[in] sha256  in 64 digits; of anything else (there was none) nothing is asked: sound
 *
 *  Does not wait for the disk. */
enum vor_verdict vor_verify_ask(struct vor_verify *verify, int fd, uint64_t size,
                                const char *sha256, const struct vor_asker *asker);

/** What brings files here that are on another machine (fetch.h): they are checked afterwards. */
struct vor_fetcher;
struct vor_fetcher *vor_verify_fetcher(const struct vor_verify *verify);

#endif
