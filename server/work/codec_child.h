/** The child that does one piece of work with bytes (codec_work.h), shut in (proc/sandbox.h), and
 * what it says to the front on its channel.
 *
 *  Its first message from the front is struct vor_codec_start; its descriptors are the ring, then
 * the input. What comes of the work goes into the ring, VOR_RING_SLOTS parts of VOR_RING_PART bytes
 * each that are filled one behind the other; after each, it says so (VOR_SAID_PART). It reuses a
 * slot only after the front has acknowledged it, by any message. Its last message is VOR_SAID_FOUND
 * or VOR_SAID_FAILED. The front believes nothing of all this before it has checked it. */
#ifndef VOR_SERVER_WORK_CODEC_CHILD_H
#define VOR_SERVER_WORK_CODEC_CHILD_H

#include "server/proc/sandbox.h"
#include "server/proc/zygote.h"
#include "server/work/codec_work.h"

#include <sys/mman.h>

/** Small enough to stay in a core's cache: of 64, 128 and 256 KiB and 1 MiB none is faster. */
enum {
    VOR_RING_PART = 128 << 10,
    VOR_RING_SLOTS = 4,
    VOR_RING_SIZE = VOR_RING_PART * VOR_RING_SLOTS
};

/** Flags for mapping the ring, and an input of that size: all pages at once, where many are used.
 */
static inline int vor_ring_flags(uint64_t size)
{
    return size > VOR_RING_PART ? MAP_POPULATE : 0;
}

struct vor_codec_start {
    struct vor_sandbox sandbox;
    enum vor_sandbox_kind kind;
    struct vor_codec_order order;
};

_Static_assert(sizeof(struct vor_codec_start) <= VOR_CHANNEL_BYTES, "it goes in one message");

/** The function of its kind. */
int vor_codec_child(int channel, const int *fds, unsigned fd_count);

#endif
