#define _GNU_SOURCE /* memfd_create */
#include "server/work/ipc_codec.h"

#include "proto/codec.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* --- shared memory
 * -------------------------------------------------------------------------------- */

struct vor_shared_state *vor_shared_state_map(int fd)
{
    void *at =
        mmap(NULL, sizeof(struct vor_shared_state), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);

    return at != MAP_FAILED ? at : NULL;
}

void *vor_share(int *fd, size_t size, int protection, int flags)
{
    void *at = MAP_FAILED;
    int failed;

    *fd = memfd_create("shared", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (*fd >= 0 && ftruncate(*fd, (off_t)size) == 0 &&
        fcntl(*fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) == 0)
        at = mmap(NULL, size, protection, MAP_SHARED | flags, *fd, 0);
    if (at != MAP_FAILED)
        return at;
    failed = errno;
    if (*fd >= 0)
        (void)close(*fd);
    *fd = -1;
    errno = failed;
    return NULL;
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
                                                 [VOR_SAID_POINTS] = sizeof(struct vor_shown),
                                                 [VOR_SAID_DONE] = sizeof(struct vor_run_result),
                                                 [VOR_SAID_FAILED] = sizeof(struct vor_error),
                                                 [VOR_SAID_PART] = sizeof(uint32_t),
                                                 [VOR_SAID_FOUND] = sizeof(struct vor_codec_facts)};

    return sizes[what];
}

/* Puts points into a file, as one message does not hold them; -1: they are not shown. */
static int file_of(struct vor_shown *shown)
{
    const struct vor_moving moving = shown->moving;
    size_t count = vor_shown_count(moving.n, VOR_PREVIEW_POINTS_MAX);
    size_t size = 3 * count * sizeof(float);
    int fd = -1;
    float *xyz = count > 0 ? vor_share(&fd, size, PROT_READ | PROT_WRITE, 0) : NULL;

    if (xyz == NULL)
        return -1;
    for (size_t i = 0; i < count; i++)
        vor_shown_point(&moving, i, count, &xyz[3 * i]);
    (void)munmap(xyz, size);
    shown->moving = (struct vor_moving){.n = count, .unit = 1};
    return fd;
}

vor_status vor_say(int channel, enum vor_said what, const void *of, size_t size)
{
    struct vor_message_said said;
    vor_status status;
    int fd;

    assert(size <= sizeof said.of);
    said.what = what;
    memcpy(&said.of, of, size);
    if (what != VOR_SAID_POINTS)
        return vor_channel_send(channel, &said, HEAD + size, NULL, 0, NULL);
    fd = file_of(&said.of.shown);
    if (fd < 0)
        return VOR_OK;
    status = vor_channel_send(channel, &said, HEAD + size, &fd, 1, NULL);
    (void)close(fd);
    return status;
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

/* Whether what was said makes sense, `size` bytes of it. */
static int check_said(struct vor_message_said *said, size_t size)
{
    static const char controls[] = VOR_CONTROLS "\t";
    const struct vor_error *error = &said->of.error;

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
    case VOR_SAID_POINTS:
        return said->of.shown.moving.n - 1 < VOR_PREVIEW_POINTS_MAX;
    case VOR_SAID_DONE:
        return check_result(&said->of.result);
    case VOR_SAID_WAITS:
    case VOR_SAID_FAILED:
        return error->status > VOR_OK && error->status < VOR_STATUS_COUNT &&
               memchr(error->message, '\0', sizeof error->message) != NULL &&
               memchr(error->parameter, '\0', sizeof error->parameter) != NULL &&
               strpbrk(error->message, controls) == NULL &&
               strpbrk(error->parameter, controls) == NULL;
    default:
        return 1;
    }
}

enum vor_channel_event vor_hear(struct vor_message_said *out, size_t *size, float *xyz, int channel,
                                double seconds)
{
    struct vor_message message = {.bytes = out, .capacity = sizeof *out};
    enum vor_channel_event event = vor_channel_receive(channel, &message, seconds);
    struct vor_moving *moving = &out->of.shown.moving;

    if (event != VOR_CHANNEL_MESSAGE) {
        out->what = VOR_SAID_STAGE;
        return event;
    }
    *size = message.size - HEAD;
    if (message.size < HEAD || !check_said(out, *size)) {
        out->what = VOR_SAID_KINDS;
        event = VOR_CHANNEL_GONE;
    } else if (out->what == VOR_SAID_POINTS) {
        ssize_t want = (ssize_t)(3 * moving->n * sizeof *xyz);

        if (xyz == NULL || message.fd_count == 0 || pread(message.fds[0], xyz, want, 0) != want)
            event = VOR_CHANNEL_LATE; /* they are not shown */
        *moving = (struct vor_moving){.xyz = xyz, .n = moving->n, .unit = 1};
    }
    vor_message_close(&message);
    return event;
}
