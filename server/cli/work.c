#include "server/cli/work.h"

#include "server/base/clock.h"
#include "server/cli/files.h"
#include "server/cli/interrupt.h"

#include <string.h>

static enum vor_answer on_poll(VOR_UNUSED void *ctx)
{
    if (vor_interrupt_seen())
        return VOR_CANCEL;
    return vor_interrupt_stops() ? VOR_STOP : VOR_CONTINUE;
}

static enum vor_answer on_progress(void *ctx, const struct vor_record *record)
{
    if (ctx != NULL)
        vor_progress_record(ctx, record);
    return on_poll(NULL);
}

static double on_clock(VOR_UNUSED void *ctx)
{
    return vor_clock_seconds();
}

vor_status vor_work_start(struct vor_work *work, const struct vor_cli *cli,
                          struct vor_progress *progress, struct vor_error *err)
{
    memset(work, 0, sizeof *work);
    vor_memory_init(&work->memory, SIZE_MAX);
    work->watch = (struct vor_watch){
        .ctx = progress, .progress = on_progress, .poll = on_poll, .clock = on_clock};
    work->run.memory = &work->memory;
    work->run.watch = &work->watch;
    work->limits = (struct vor_limits)VOR_LIMITS_DEFAULT;
    work->limits.points = VOR_POINTS_MAX;
    vor_limits_want(&work->limits, &cli->spec);
    return vor_pool_create(&work->run.pool, cli->threads, err);
}

void vor_work_end(struct vor_work *work)
{
    vor_pool_destroy(work->run.pool);
    work->run.pool = NULL;
}

vor_status vor_work_load(struct vor_work *work, struct vor_cloud *cloud,
                         const struct vor_format **format, const char *path, struct vor_error *err)
{
    struct vor_input input;
    vor_status status;

    vor_cloud_init(cloud, &work->memory);
    status = vor_input_read(&input, path, err);
    if (status == VOR_OK)
        status = vor_codec_read(cloud, format, input.bytes, input.size, &work->limits, err);
    vor_input_free(&input);
    return status;
}
