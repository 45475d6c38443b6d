#include "server/work/codec_run.h"

#include "server/base/clock.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/work/codec_child.h"
#include "server/work/ipc_codec.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* --- what it may take ------------------------------------------------------------------------- */

static const size_t MEMORY_FREE = (size_t)64 << 20;
static const size_t MEMORY_PER_POINT = 40; /* bytes; Draco's decoder takes 27, a cloud 12 */
static const uint64_t POINTS_PER_BYTE = 64, POINTS_FREE = 100000; /* as of draco_precheck.c */

enum { SECONDS_FREE = 10, BYTES_PER_SECOND = 4 << 20 };
static const double WALL_PER_CPU = 4;   /* on a machine that does other things as well */
static const double ASK_SECONDS = 0.05; /* between two questions to the caller */

/* CPU time that work on so many bytes may take. Measured: the slowest that a valid file takes,
 * ASCII PLY with attributes of double, is 45 MB/s; the smallest bomb that fits the ratio of points
 * takes 0.9 s. */
static unsigned seconds_for(uint64_t size)
{
    return SECONDS_FREE + (unsigned)(size / BYTES_PER_SECOND);
}

/* Bytes of address space that the same may take. */
static size_t memory_for(const struct vor_codec_order *order)
{
    uint64_t points = POINTS_PER_BYTE * order->size + POINTS_FREE;
    size_t clouds;

    if (points > order->limits.points)
        points = order->limits.points;
    clouds = MEMORY_PER_POINT * (size_t)points;
    if (order->op == VOR_CODEC_ENCODE || clouds > order->memory)
        clouds = order->memory; /* of a job: it is counted there */
    return MEMORY_FREE + clouds + (size_t)order->size + VOR_RING_SIZE;
}

/* --- in a child ------------------------------------------------------------------------------- */

/* A child at work. */
struct run {
    const struct vor_codec_place *place;
    const struct vor_codec_order *order;
    const struct vor_sink *sink;
    struct vor_child child;
    const uint8_t *ring;
    unsigned slot; /* that comes next */
    uint64_t came; /* bytes */
    double until;
};

/* The status of a child that did not live to tell one. */
static vor_status blame(const struct run *run)
{
    int is_ours = run->order->op == VOR_CODEC_CONVERT || run->order->op == VOR_CODEC_ENCODE;

    return is_ours ? VOR_E_INTERNAL : VOR_E_FORMAT;
}

static const char *what_of(const struct vor_codec_order *order)
{
    static const char *const words[VOR_CODEC_OPS] = {[VOR_CODEC_INFLATE] = "inflating the upload",
                                                     [VOR_CODEC_DECODE] = "reading the upload",
                                                     [VOR_CODEC_CONVERT] = "converting the result",
                                                     [VOR_CODEC_ENCODE] = "writing the result"};

    return words[order->op];
}

static vor_status too_long(const struct run *run, struct vor_error *err)
{
    return vor_fail(err, blame(run), "%s exceeded the limit of %u seconds of CPU time",
                    what_of(run->order), seconds_for(run->order->size));
}

/* The channel is closed: the child has ended, or will not get far. */
static vor_status take_end(struct run *run, struct vor_error *err)
{
    static const double MOMENT = 1; /* s: for a core that is slow to die */
    struct vor_child_end end;
    int has_ended = vor_child_reap(&run->child, &end, MOMENT) == VOR_CHILD_ENDED;
    const char *what = what_of(run->order);

    /* Says how a child ended that told nothing, in the log too. One that was slow to die is as much
     * to blame as one that crashed: the kill that it had was ours. */
    vor_log(VOR_LOG_WARN, "codec child ended", VOR_TEXT("work", what),
            VOR_COUNT("signal", end.signal), VOR_COUNT("exit", end.status),
            VOR_COUNT("bytes", run->order->size), VOR_REAL("cpu_s", end.cpu_seconds),
            VOR_COUNT("peak", end.peak));
    if (!has_ended)
        return vor_fail(err, blame(run), "%s failed: its process did not end", what);
    switch (end.signal) {
    case SIGXCPU:
        return too_long(run, err);
    case SIGSYS:
        return vor_fail(err, blame(run),
                        "%s was stopped: it made a system call that is not allowed", what);
    case SIGKILL:
        return vor_fail(err, VOR_E_NOMEM,
                        "%s: the operating system killed the process, probably because memory "
                        "ran out",
                        what);
    default:
        return vor_fail(err, blame(run), "%s failed: it crashed (signal %d, exit status %d)", what,
                        end.signal, end.status);
    }
}

static vor_status nonsense(struct run *run, struct vor_error *err)
{
    vor_log(VOR_LOG_WARN, "codec child sent an invalid message",
            VOR_TEXT("work", what_of(run->order)));
    return vor_fail(err, blame(run), "%s failed: its process sent an invalid message",
                    what_of(run->order));
}

/* Passes on what the child has put into a slot. */
static vor_status take_part(struct run *run, uint32_t size, struct vor_error *err)
{
    const uint8_t *from = run->ring + (size_t)run->slot * VOR_RING_PART;

    run->came += size;
    if (size < 1 || size > VOR_RING_PART || run->came > run->order->most)
        return nonsense(run, err);
    if (run->sink->write(run->sink->ctx, from, size) < 0)
        return vor_fail(err, VOR_E_IO, "%u bytes could not be written", (unsigned)size);
    run->slot = (run->slot + 1) % VOR_RING_SLOTS;
    if (vor_channel_send(run->child.channel, "", 1, NULL, 0, NULL) != VOR_OK)
        return VOR_OK; /* that it has ended meanwhile is told by the next message */
    return VOR_OK;
}

static int is_box(const struct vor_extent *extent)
{
    for (int k = 0; k < 3; k++)
        if (!isfinite(extent->low[k]) || !isfinite(extent->high[k]) ||
            extent->low[k] > extent->high[k])
            return 0;
    return isfinite(extent->area) && extent->area >= 0;
}

/* What the child says of itself may be anything, once a reader was overrun. */
static int are_sane(const struct vor_codec_facts *facts, const struct vor_codec_order *order)
{
    if (order->op == VOR_CODEC_INFLATE || order->op == VOR_CODEC_ENCODE)
        return 1;
    if (vor_format(facts->format) == NULL || facts->points < 1 || facts->points > VOR_POINTS_MAX ||
        facts->extent.n != facts->points || !is_box(&facts->extent))
        return 0;
    if (order->op == VOR_CODEC_DECODE)
        return facts->points <= order->limits.points;
    return !facts->has_origin ||
           (isfinite(facts->origin[0]) && isfinite(facts->origin[1]) && isfinite(facts->origin[2]));
}

/* Takes messages until the last one. */
static vor_status listen(struct run *run, struct vor_codec_facts *facts, struct vor_error *err)
{
    struct vor_message_said said;
    vor_status status = VOR_OK;
    size_t size;

    while (status == VOR_OK) {
        enum vor_channel_event event =
            vor_hear(&said, &size, NULL, run->child.channel, ASK_SECONDS);

        if (event == VOR_CHANNEL_GONE && said.what != VOR_SAID_KINDS)
            return take_end(run, err);
        if (run->place->has_left != NULL && run->place->has_left(run->place->ctx))
            return vor_fail(err, VOR_E_CANCELLED, "the client disconnected");
        if (vor_clock_seconds() > run->until)
            return too_long(run, err);
        if (event == VOR_CHANNEL_LATE)
            continue;
        switch (said.what) {
        case VOR_SAID_PART:
            status = take_part(run, said.of.part, err);
            break;
        case VOR_SAID_FAILED:
            *err = said.of.error;
            return err->status;
        case VOR_SAID_FOUND:
            if (are_sane(&said.of.facts, run->order)) {
                *facts = said.of.facts;
                return VOR_OK;
            }
            return nonsense(run, err);
        default:
            return nonsense(run, err);
        }
    }
    return status;
}

static vor_status run_in_child(struct run *run, struct vor_codec_facts *facts, int input,
                               struct vor_error *err)
{
    struct vor_codec_start start = {
        .sandbox = {.memory = memory_for(run->order), .cpu_seconds = seconds_for(run->order->size)},
        .kind = run->place->sandbox,
        .order = *run->order};
    double patience = run->place->patience > 0 ? run->place->patience : 1;
    char path[32];
    int fds[2];
    void *ring = vor_share(&fds[0], VOR_RING_SIZE, PROT_READ, vor_ring_flags(run->order->size));
    vor_status status;

    if (ring == NULL)
        return vor_fail_errno(err, errno, "memory to share with a child process");
    /* The same file, for reading only; itself where /proc is not there to open it by. */
    (void)snprintf(path, sizeof path, "/proc/self/fd/%d", input);
    fds[1] = open(path, O_RDONLY | O_CLOEXEC);
    if (fds[1] < 0)
        fds[1] = fcntl(input, F_DUPFD_CLOEXEC, 0);
    if (fds[1] < 0) {
        status = vor_fail_errno(err, errno, "the upload");
    } else {
        status = vor_zygote_spawn(&run->child, run->place->zygote, run->place->kind, fds, 2, err);
        (void)close(fds[1]);
    }
    (void)close(fds[0]);
    run->ring = ring;
    run->until = vor_clock_seconds() + WALL_PER_CPU * patience * start.sandbox.cpu_seconds;
    if (status == VOR_OK) {
        status = vor_channel_send(run->child.channel, &start, sizeof start, NULL, 0, err);
        if (status == VOR_OK)
            status = listen(run, facts, err);
        else if (err->got == EPIPE || err->got == ECONNRESET) /* it ended before it heard a word */
            status = take_end(run, err);
        vor_child_free(&run->child); /* nobody waits until it is gone: it has nothing of ours */
    }
    (void)munmap(ring, VOR_RING_SIZE);
    return status;
}

vor_status vor_codec_run(struct vor_codec_facts *facts, const struct vor_codec_place *place,
                         const struct vor_codec_order *order, int input,
                         const struct vor_sink *sink, struct vor_error *err)
{
    struct vor_codec_order capped = *order;
    struct run run = {.place = place, .order = &capped, .sink = sink};
    struct vor_error unused;
    size_t memory;

    if (place->zygote == NULL) {
        size_t size = (size_t)order->size;
        void *bytes = NULL;
        vor_status status;

        if (size > 0)
            bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, input, 0);
        if (bytes == MAP_FAILED)
            return vor_fail_errno(err, errno, "mapping the upload");
        status = vor_codec_do(facts, sink, order, bytes, err);
        if (bytes != NULL)
            (void)munmap(bytes, size);
        return status;
    }
    memory = memory_for(order);
    if (capped.memory > memory)
        capped.memory = memory;
    if (capped.op != VOR_CODEC_INFLATE && capped.most > memory)
        capped.most = memory; /* what is written was in memory */
    return run_in_child(&run, facts, input, err != NULL ? err : &unused);
}
