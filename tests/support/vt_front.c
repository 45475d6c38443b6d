#include "tests/support/vt_front.h"

#include "server/base/metrics.h"
#include "tests/support/vt.h"

#include <stdlib.h>
#include <string.h>

struct vt_front vt_front_start(const struct vor_child_kind *kinds, unsigned count,
                               struct vor_supervisor_config config)
{
    struct vt_front front = {.zygote = malloc(sizeof *front.zygote)};

    config.zygote = front.zygote;
    if (config.codec.kind != 0)
        config.codec.zygote = front.zygote;
    config.threads = 2;
    config.memory = (size_t)1 << 28;
    vt_assert_ok(vor_zygote_start(front.zygote, kinds, count, &vt_err));
    vt_assert_ok(vor_supervisor_create(&front.supervisor, &config, &vt_err));
    return front;
}

void vt_front_stop(struct vt_front *front)
{
    vor_supervisor_destroy(front->supervisor);
    vor_zygote_stop(front->zygote);
    free(front->zygote);
}

unsigned vt_front_crashes(void)
{
    struct vor_text numbers;
    const char *at;
    unsigned count = 0;

    vor_text_init(&numbers, 0);
    vor_metrics_write(&numbers);
    at = numbers.size == 0 ? NULL : strstr(numbers.data, "\nvoronoid_worker_restarts_total ");
    if (at != NULL)
        (void)sscanf(at, "%*s %u", &count);
    vor_text_free(&numbers);
    return count;
}

static enum vor_answer answer(void *ctx)
{
    return (enum vor_answer)atomic_load(&((struct vt_heard *)ctx)->asked);
}

static void hear(void *ctx, enum vor_said what, const void *of)
{
    struct vt_heard *heard = ctx;

    if (what == VOR_SAID_RECORD) {
        heard->records++;
        heard->record = *(const struct vor_record *)of;
    }
    if (what == VOR_SAID_STAGE && *(const enum vor_stage *)of == VOR_STAGE_ENCODE)
        atomic_fetch_add(&heard->stages, 1);
    if (what == VOR_SAID_CHECKPOINT)
        heard->saved = ((const struct vor_job_output *)of)->bytes;
    heard->waits += what == VOR_SAID_WAITS;
    heard->resumed += what == VOR_SAID_RESUMED;
}

static int offer(void *ctx)
{
    struct vt_heard *heard = ctx;

    return heard->offered != NULL && heard->offers++ == 0 ? fileno(heard->offered) : -1;
}

struct vor_listener vt_listener_of(struct vt_heard *heard)
{
    return (struct vor_listener){.ctx = heard, .asked = answer, .said = hear, .file = offer};
}

void vt_heard_run(struct vt_heard *heard, struct vor_run_executor *executor,
                  const struct vor_order *order)
{
    const struct vor_listener listener = vt_listener_of(heard);

    vor_text_init(&heard->kept, 0);
    heard->end =
        executor->run(executor, order, &listener, &heard->result, &heard->kept, &heard->err);
}

struct vor_order vt_order_of(size_t memory)
{
    struct vor_order order = {.memory = memory, .saved = -1};

    vor_spec_init(&order.spec);
    for (int i = 0; i < VOR_INPUTS_MAX; i++)
        order.input[i] = -1;
    for (int i = 0; i < VOR_OUTPUTS_MAX; i++)
        order.output[i] = -1;
    return order;
}
