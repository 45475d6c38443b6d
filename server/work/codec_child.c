#include "server/work/codec_child.h"

#include "server/work/ipc_codec.h"

#include <limits.h>
#include <malloc.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

enum { FD_RING, FD_INPUT, FD_COUNT };
_Static_assert(VOR_SANDBOX_CHANNEL == 3 && VOR_SANDBOX_SHARED == 4 + FD_RING,
               "where the zygote puts them");

/* The bytes on their way to the front. */
struct ring {
    int channel;
    uint8_t *bytes;
    unsigned slot;   /* that is being filled */
    unsigned unread; /* parts that the front has not told to have emptied */
    size_t used;     /* bytes in the slot */
};

/* Hands over what is in the slot, and waits until the next one is free. */
static int flush(struct ring *ring)
{
    uint32_t part = (uint32_t)ring->used;
    char told[16];
    struct vor_message message = {.bytes = told, .capacity = sizeof told};

    if (part == 0)
        return 0;
    if (vor_say(ring->channel, VOR_SAID_PART, &part, sizeof part) != VOR_OK)
        return -1;
    ring->used = 0;
    ring->slot = (ring->slot + 1) % VOR_RING_SLOTS;
    if (++ring->unread < VOR_RING_SLOTS)
        return 0;
    ring->unread--;
    return vor_channel_receive(ring->channel, &message, -1) == VOR_CHANNEL_MESSAGE ? 0 : -1;
}

static int put(void *ctx, const void *bytes, size_t size)
{
    struct ring *ring = ctx;
    const uint8_t *at = bytes;

    while (size > 0) {
        size_t room = VOR_RING_PART - ring->used, now = size < room ? size : room;

        memcpy(ring->bytes + (size_t)ring->slot * VOR_RING_PART + ring->used, at, now);
        ring->used += now;
        at += now;
        size -= now;
        if (ring->used == VOR_RING_PART && flush(ring) != 0)
            return -1;
    }
    return 0;
}

/* Bytes of memory that a byte of a file takes: 27 a point while Draco decodes, of files of 2. */
enum { HEAP_PER_BYTE = 16 };

/* Those that every format touches: its points in a cloud; the file itself is mapped. At 0 / 1 / 2 a
 * child computes 31.4 / 30.8 / 37.4 ms for a PLY of 12 MB (medians). */
enum { TOUCHED_PER_BYTE = 1 };

static char *next_multiple(char *at, size_t of)
{
    return (char *)(((uintptr_t)at + of - 1) & ~(uintptr_t)(of - 1));
}

/* The heap as it is in a process that has decoded a file of `size` bytes before: blocks of some MB
 * come from it and go back to it, instead of being mapped and unmapped each time. A part of it is
 * made of large pages, of which the kernel clears one faster than the 512 small ones that it stands
 * for. */
static void warm_heap(size_t size)
{
    enum { LARGEST = 32 << 20, LARGE_PAGE = 2 << 20 }; /* the C library takes no larger threshold */
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    size_t bytes = HEAP_PER_BYTE * size, touched = TOUCHED_PER_BYTE * size;
    char *heap;

    (void)mallopt(M_MMAP_THRESHOLD, LARGEST);
    (void)mallopt(M_TRIM_THRESHOLD, INT_MAX);
    if (bytes < LARGE_PAGE)
        return;
    if (bytes > LARGEST - LARGE_PAGE)
        bytes = LARGEST - LARGE_PAGE;
    heap = malloc(bytes);
    if (heap != NULL) {
        (void)madvise(next_multiple(heap, LARGE_PAGE), bytes & ~(size_t)(LARGE_PAGE - 1),
                      MADV_HUGEPAGE);
        touched = touched < bytes - page ? touched : bytes - page;
#ifdef MADV_POPULATE_WRITE
        /* The kernel gives pages at once in a third of the time that it takes when each is asked
         * for as it is touched: of the 1,300 faults of a PLY of 960 KB 350 are left. Kernels before
         * 5.14 do not know how. */
        (void)madvise(next_multiple(heap, page), touched & ~(page - 1), MADV_POPULATE_WRITE);
#endif
    }
    free(heap);
}

static vor_status shut_in_and_do(struct vor_codec_facts *facts, struct ring *ring,
                                 const struct vor_codec_start *start, const int *fds,
                                 struct vor_error *err)
{
    const struct vor_sink sink = {.ctx = ring, .write = put};
    size_t size = (size_t)start->order.size;
    void *ring_bytes, *input = NULL;
    vor_status status;

    /* Large uploads give way to small ones, and to the front; the last step of a job does not. */
    enum { LARGE = 1 << 20, NICENESS = 5 };

    if (start->order.size > LARGE && start->order.op != VOR_CODEC_ENCODE)
        (void)setpriority(PRIO_PROCESS, 0, NICENESS);
    status = vor_sandbox_enter(&start->sandbox, start->kind, err);
    if (status != VOR_OK)
        return status;
    ring_bytes = mmap(NULL, VOR_RING_SIZE, PROT_READ | PROT_WRITE,
                      MAP_SHARED | vor_ring_flags(size), fds[FD_RING], 0);
    if (size > 0)
        input = mmap(NULL, size, PROT_READ, MAP_PRIVATE | vor_ring_flags(size), fds[FD_INPUT], 0);
    if (ring_bytes == MAP_FAILED || input == MAP_FAILED)
        return vor_fail(err, VOR_E_NOMEM, "reading %zu bytes", size);
    ring->bytes = ring_bytes;
    warm_heap(size);
    status = vor_codec_do(facts, &sink, &start->order, input, err);
    if (status == VOR_OK && flush(ring) != 0)
        status = vor_fail(err, VOR_E_IO, "the bytes were not received");
    return status;
}

int vor_codec_child(int channel, const int *fds, unsigned fd_count)
{
    static struct vor_codec_start start;
    static struct vor_codec_facts facts;
    static struct vor_error error;
    struct vor_message message = {.bytes = &start, .capacity = sizeof start};
    struct ring ring = {.channel = channel};
    vor_status status;

    if (fd_count != FD_COUNT || vor_channel_receive(channel, &message, -1) != VOR_CHANNEL_MESSAGE ||
        message.size != sizeof start || message.fd_count != 0)
        return 1;
    status = shut_in_and_do(&facts, &ring, &start, fds, &error);
    status = status == VOR_OK ? vor_say(channel, VOR_SAID_FOUND, &facts, sizeof facts)
                              : vor_say(channel, VOR_SAID_FAILED, &error, sizeof error);
    return status == VOR_OK ? 0 : 1;
}
