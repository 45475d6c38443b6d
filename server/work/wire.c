#define _GNU_SOURCE /* memfd_create */
#include "server/work/wire.h"

#include "proto/codec.h"
#include "server/base/disk.h"

#include <assert.h>
#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* --- the board -------------------------------------------------------------------------------- */

struct vor_board *vor_board_map(int fd)
{
    void *at = mmap(NULL, sizeof(struct vor_board), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);

    return at != MAP_FAILED ? at : NULL;
}

void vor_board_unmap(struct vor_board *board)
{
    if (board != NULL)
        (void)munmap(board, sizeof *board);
}

void vor_board_show(struct vor_board *board, unsigned seat, const struct vor_shown *shown)
{
    struct vor_showing *showing = &board->showing[seat];
    unsigned sequence = atomic_load_explicit(&showing->sequence, memory_order_relaxed);
    size_t count = vor_shown_count(shown->moving.n, VOR_PREVIEW_POINTS_MAX);

    /* An exchange: what follows stays behind it. */
    (void)atomic_exchange_explicit(&showing->sequence, sequence + 1, memory_order_acq_rel);
    for (size_t i = 0; i < count; i++) {
        float x[3];
        uint32_t bits[3];

        vor_shown_point(&shown->moving, i, count, x);
        memcpy(bits, x, sizeof bits);
        for (size_t c = 0; c < 3; c++)
            atomic_store_explicit(&board->shown[seat][3 * i + c], bits[c], memory_order_relaxed);
    }
    for (int c = 0; c < 3; c++) {
        uint64_t bits;

        memcpy(&bits, &shown->origin[c], sizeof bits);
        atomic_store_explicit(&showing->origin[c], bits, memory_order_relaxed);
    }
    atomic_store_explicit(&showing->count, (unsigned)count, memory_order_relaxed);
    atomic_store_explicit(&showing->iteration, shown->iteration, memory_order_relaxed);
    atomic_store_explicit(&showing->polish, shown->polish, memory_order_relaxed);
    atomic_store_explicit(&showing->sequence, sequence + 2, memory_order_release);
}

int vor_board_look(struct vor_board *board, unsigned seat, unsigned *sequence,
                   struct vor_shown *out, float *xyz)
{
    struct vor_showing *showing = &board->showing[seat];
    unsigned before = atomic_load_explicit(&showing->sequence, memory_order_acquire);
    size_t count;

    if (before == *sequence || (before & 1) != 0)
        return 0;
    count = vor_shown_count(atomic_load_explicit(&showing->count, memory_order_relaxed),
                            VOR_PREVIEW_POINTS_MAX); /* the worker may have gone mad */
    *out = (struct vor_shown){.moving = {.xyz = xyz, .n = count, .unit = 1}};
    out->iteration = atomic_load_explicit(&showing->iteration, memory_order_relaxed);
    out->polish = atomic_load_explicit(&showing->polish, memory_order_relaxed);
    for (int c = 0; c < 3; c++) {
        uint64_t bits = atomic_load_explicit(&showing->origin[c], memory_order_relaxed);

        memcpy(&out->origin[c], &bits, sizeof bits);
    }
    for (size_t i = 0; i < 3 * count; i++) {
        uint32_t bits = atomic_load_explicit(&board->shown[seat][i], memory_order_relaxed);

        memcpy(&xyz[i], &bits, sizeof bits);
    }
    /* An addition of nothing: what precedes stays before it. */
    if (atomic_fetch_add_explicit(&showing->sequence, 0, memory_order_acq_rel) != before)
        return 0;
    *sequence = before;
    return count > 0;
}

void vor_board_look_away(struct vor_board *board, unsigned seat)
{
    atomic_store(&board->showing[seat].is_looked_at, 0);
    /* Where pages are larger the kernel refuses, and the memory waits for the next run. */
    (void)madvise(board->shown[seat], sizeof board->shown[seat], MADV_REMOVE);
}

vor_status vor_board_create(struct vor_board **out, int *fd, struct vor_error *err)
{
    struct vor_board *board;
    int file = memfd_create("voronoid-board", MFD_CLOEXEC);

    if (file < 0)
        return vor_fail_errno(err, errno, "creating memory that two processes share");
    board = ftruncate(file, sizeof *board) == 0 ? vor_board_map(file) : NULL;
    if (board == NULL) {
        vor_status status = vor_fail_errno(err, errno, "creating memory that two processes share");

        (void)close(file);
        return status;
    }
    *out = board;
    *fd = file;
    return VOR_OK;
}

/* --- orders ----------------------------------------------------------------------------------- */

/* An order on its way: its process by name, its descriptors beside it, in the order of `file`. */
struct packed {
    struct vor_order order;
    char process[32];
};

enum { FILES = sizeof((struct vor_order *)0)->file / sizeof(int) };
_Static_assert((int)FILES <= (int)VOR_CHANNEL_FDS, "one message holds them");

vor_status vor_order_send(int channel, const struct vor_order *order, struct vor_error *err)
{
    struct packed packed = {.order = *order};
    int fds[FILES];
    unsigned count = 0;

    for (unsigned i = 0; i < FILES; i++)
        if (order->file[i] >= 0)
            fds[count++] = order->file[i];
    packed.order.spec.process = NULL;
    (void)snprintf(packed.process, sizeof packed.process, "%s", order->spec.process->id);
    return vor_channel_send(channel, &packed, sizeof packed, fds, count, err);
}

void vor_offer_send(int channel, const struct vor_listener *listener)
{
    const struct vor_job_output none = {.bytes = 0};
    int file = listener->file != NULL ? listener->file(listener->ctx) : -1;

    if (file >= 0 && vor_channel_send(channel, "", 1, &file, 1, NULL) != VOR_OK)
        listener->said(listener->ctx, VOR_SAID_CHECKPOINT, &none);
}

int vor_offer_receive(int channel)
{
    char nothing;
    struct vor_message message = {.bytes = &nothing, .capacity = sizeof nothing};

    if (vor_channel_receive(channel, &message, 0) != VOR_CHANNEL_MESSAGE)
        return -1;
    if (message.fd_count == 1)
        return message.fds[0];
    vor_message_close(&message);
    return -1;
}

void vor_order_forget(struct vor_order *order)
{
    for (unsigned i = 0; i < FILES; i++)
        order->file[i] = -1;
}

vor_status vor_order_receive(struct vor_order *out, int channel, double seconds,
                             struct vor_error *err)
{
    struct packed packed = {.process = ""};
    struct vor_message message = {.bytes = &packed, .capacity = sizeof packed};
    unsigned next = 0;
    int is_whole;

    vor_order_forget(out);
    if (vor_channel_receive(channel, &message, seconds) != VOR_CHANNEL_MESSAGE)
        return vor_fail(err, VOR_E_IO, "no request was received");
    is_whole = message.size == sizeof packed;
    for (unsigned i = 0; i < FILES; i++)
        if (packed.order.file[i] >= 0) {
            is_whole = is_whole && next < message.fd_count;
            packed.order.file[i] = is_whole ? message.fds[next++] : -1;
        }
    packed.process[sizeof packed.process - 1] = '\0';
    packed.order.spec.process = vor_process_find(packed.process);
    if (!is_whole || next != message.fd_count || packed.order.spec.process == NULL) {
        vor_message_close(&message);
        return vor_fail(err, VOR_E_IO, "the request is invalid");
    }
    *out = packed.order;
    return VOR_OK;
}

void vor_order_close(struct vor_order *order)
{
    for (unsigned i = 0; i < FILES; i++)
        if (order->file[i] >= 0)
            (void)close(order->file[i]);
    vor_order_forget(order);
}

/* --- what a run says -------------------------------------------------------------------------- */

enum { HEAD = offsetof(struct vor_message_said, of) };

_Static_assert(sizeof(struct vor_message_said) <= VOR_CHANNEL_BYTES, "one message holds it");

size_t vor_said_size(enum vor_said what)
{
    static const size_t sizes[VOR_SAID_KINDS] = {[VOR_SAID_STAGE] = sizeof(enum vor_stage),
                                                 [VOR_SAID_RECORD] = sizeof(struct vor_record),
                                                 [VOR_SAID_CHECKPOINT] =
                                                     sizeof(struct vor_job_output),
                                                 [VOR_SAID_WAITS] = sizeof(struct vor_error),
                                                 [VOR_SAID_DONE] = sizeof(struct vor_run_result),
                                                 [VOR_SAID_FAILED] = sizeof(struct vor_error)};

    return sizes[what];
}

vor_status vor_say(int channel, enum vor_said what, const void *of, size_t size)
{
    struct vor_message_said said;

    assert(size <= sizeof said.of);
    said.what = what;
    memcpy(&said.of, of, size);
    return vor_channel_send(channel, &said, HEAD + size, NULL, 0, NULL);
}

static int check_result(struct vor_run_result *result)
{
    const struct vor_report *report = &result->report;

    for (unsigned i = 0; i < VOR_OUTPUTS_MAX; i++) {
        if (vor_format(result->output[i].format) == NULL)
            return 0;
        result->output[i].sha256[VOR_DIGEST_SIZE - 1] = '\0';
    }
    result->message[sizeof result->message - 1] = '\0';
    result->report.parameters.process = NULL; /* a pointer of the other process */
    if (report->stages_count > sizeof report->stages / sizeof report->stages[0])
        return 0;
    for (unsigned i = 0; i < report->stages_count; i++)
        if ((unsigned)report->stages[i].stage >= VOR_RUN_STAGE_COUNT)
            return 0;
    return report->stopped < VOR_STOPPED_COUNT;
}

static int check_error(struct vor_error *error)
{
    error->parameter[sizeof error->parameter - 1] = '\0';
    error->message[sizeof error->message - 1] = '\0';
    return error->status > VOR_OK && error->status < VOR_STATUS_COUNT;
}

/* Whether what was said makes sense, `size` bytes of it. */
static int check_said(struct vor_message_said *said, size_t size)
{
    if ((unsigned)said->what >= VOR_SAID_KINDS ||
        (said->what == VOR_SAID_KEPT ? size > sizeof said->of.kept
                                     : size != vor_said_size(said->what)))
        return 0;
    switch (said->what) {
    case VOR_SAID_STAGE:
        return said->of.stage < VOR_STAGES;
    case VOR_SAID_RECORD:
        return said->of.record.stage < VOR_RUN_STAGE_COUNT;
    case VOR_SAID_CHECKPOINT:
        said->of.file.sha256[VOR_DIGEST_SIZE - 1] = '\0';
        return 1;
    case VOR_SAID_DONE:
        return check_result(&said->of.result);
    case VOR_SAID_WAITS:
    case VOR_SAID_FAILED:
        return check_error(&said->of.error);
    default:
        return 1;
    }
}

enum vor_channel_event vor_hear(struct vor_message_said *out, size_t *size, int channel,
                                double seconds)
{
    struct vor_message message = {.bytes = out, .capacity = sizeof *out};
    enum vor_channel_event event = vor_channel_receive(channel, &message, seconds);

    if (event != VOR_CHANNEL_MESSAGE)
        return event;
    vor_message_close(&message);
    if (message.size < HEAD)
        return VOR_CHANNEL_GONE;
    *size = message.size - HEAD;
    return check_said(out, *size) ? VOR_CHANNEL_MESSAGE : VOR_CHANNEL_GONE;
}
