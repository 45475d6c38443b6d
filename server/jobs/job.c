#include "server/jobs/job.h"

#include "server/base/machine.h"
#include "server/jobs/eta.h"

#include <ctype.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

struct vor_job {
    struct vor_uuid id; /* first: jobs are looked up by it */
    atomic_uint references;
    atomic_int asked; /* enum vor_answer */
    struct vor_preview *preview;
    pthread_mutex_t change; /* a change of state and its event are one; taken before `state` */
    pthread_mutex_t state;  /* what follows, which only who holds `change` changes */
    struct vor_job_view view;
    struct vor_eta eta;      /* of this attempt, for the estimate */
    uint32_t stored, newest; /* numbers of events of this attempt: that the store has, and of all */
    struct vor_text piece;   /* those between them */
    int is_here;             /* this attempt runs here; else there may be more than is known */
    pthread_mutex_t waking;  /* subscribers; held while they are woken */
    struct vor_subscriber *subscribers;
};

/* Percent done when a stage ends: preparing is 10 of 100, the stages of the run 80, measuring the
 * result 5, encoding the rest. */
enum { PREPARED = 10, OPTIMIZED = 90, MEASURED = 95 };

/* Seconds from the last change until the run ends, -1 where that is not known; the caller holds
 * job->state. */
static double estimate(const struct vor_job *job)
{
    enum vor_stage stage = job->view.stage;

    if (job->view.status != VOR_JOB_RUNNING || stage == VOR_STAGE_ENCODE)
        return -1;
    return vor_eta_left(&job->eta, &job->view.spec);
}

static void wake_all(struct vor_job *job, enum vor_event_kind kind)
{
    pthread_mutex_lock(&job->waking);
    for (struct vor_subscriber *s = job->subscribers; s != NULL; s = s->next)
        s->wake(s->ctx, kind);
    pthread_mutex_unlock(&job->waking);
}

/* Publishes an event with the state of the job; the caller holds job->change. Out of memory, or
 * beyond VOR_EVENTS_MAX, one point of a chart is missing. */
static void publish(struct vor_job *job, enum vor_event_kind kind, int64_t now_ms)
{
    struct vor_event event = {.kind = kind, .time_ms = now_ms};

    pthread_mutex_lock(&job->state);
    event.attempt = job->view.attempt;
    event.status = job->view.status;
    event.stage = job->view.stage;
    event.progress = job->view.progress;
    if (kind == VOR_EVENT_PROGRESS) {
        event.record = job->view.record;
        event.eta_seconds = estimate(job);
    }
    if (job->newest + 1 < VOR_EVENTS_MAX && vor_events_pack(&job->piece, &event) == VOR_OK)
        job->newest++;
    pthread_mutex_unlock(&job->state);
    wake_all(job, kind);
}

struct vor_job *vor_job_create(const struct vor_job_view *row)
{
    struct vor_job *job = calloc(1, sizeof *job);

    if (job == NULL)
        return NULL;
    job->preview = vor_preview_create();
    if (job->preview == NULL) {
        free(job);
        return NULL;
    }
    atomic_init(&job->references, 1);
    atomic_init(&job->asked, VOR_CONTINUE);
    pthread_mutex_init(&job->change, NULL);
    pthread_mutex_init(&job->state, NULL);
    pthread_mutex_init(&job->waking, NULL);
    vor_text_init(&job->piece, 0);
    job->id = row->id;
    job->view = *row;
    job->view.queue_position = -1;
    if (row->attempt > 1)
        publish(job, VOR_EVENT_REPLACED, row->updated);
    publish(job, VOR_EVENT_STATUS, row->updated);
    return job;
}

struct vor_job *vor_job_retain(struct vor_job *job)
{
    if (job != NULL)
        atomic_fetch_add(&job->references, 1);
    return job;
}

void vor_job_release(struct vor_job *job)
{
    if (job == NULL || atomic_fetch_sub(&job->references, 1) != 1)
        return;
    pthread_mutex_destroy(&job->waking);
    pthread_mutex_destroy(&job->state);
    pthread_mutex_destroy(&job->change);
    vor_preview_destroy(job->preview);
    vor_text_free(&job->piece);
    free(job);
}

const struct vor_uuid *vor_job_id(const struct vor_job *job)
{
    return &job->id;
}

struct vor_preview *vor_job_preview(const struct vor_job *job)
{
    return job->preview;
}

void vor_job_subscribe(struct vor_job *job, struct vor_subscriber *subscriber)
{
    if (job == NULL)
        return;
    pthread_mutex_lock(&job->waking);
    subscriber->next = job->subscribers;
    job->subscribers = subscriber;
    pthread_mutex_unlock(&job->waking);
}

void vor_job_unsubscribe(struct vor_job *job, struct vor_subscriber *subscriber)
{
    struct vor_subscriber **at;

    if (job == NULL)
        return;
    pthread_mutex_lock(&job->waking);
    at = &job->subscribers;
    while (*at != NULL && *at != subscriber)
        at = &(*at)->next;
    if (*at != NULL)
        *at = subscriber->next;
    pthread_mutex_unlock(&job->waking);
}

struct vor_event_piece vor_job_piece(const struct vor_job *job)
{
    return (struct vor_event_piece){job->newest, (const uint8_t *)job->piece.data, job->piece.size};
}

void vor_job_read_end(const struct vor_job_view *row, uint32_t last, struct vor_event_batch *batch)
{
    const struct vor_event end = {.kind = VOR_EVENT_END,
                                  .attempt = row->attempt,
                                  .number = last + 1,
                                  .status = row->status,
                                  .stage = row->stage,
                                  .progress = row->progress,
                                  .time_ms = row->finished};

    if (batch->position.number <= last)
        (void)vor_event_batch_add(batch, &end);
}

int vor_job_read(struct vor_job *job, struct vor_event_batch *batch)
{
    struct vor_event_piece piece;
    int over, is_at_hand = 1;

    pthread_mutex_lock(&job->state);
    over = vor_job_status_over(job->view.status);
    /* The reader may have been at another daemon, which knows more. */
    if (over || job->is_here || batch->position.attempt < job->view.attempt ||
        (batch->position.attempt == job->view.attempt && batch->position.number <= job->newest)) {
        vor_event_batch_begin(batch, job->view.attempt, job->newest + (uint32_t)over);
        is_at_hand = batch->position.number >= job->stored;
        piece = vor_job_piece(job);
        if (is_at_hand && vor_events_unpack(batch, &piece) != 0 && over)
            vor_job_read_end(&job->view, job->newest, batch);
    }
    pthread_mutex_unlock(&job->state);
    return is_at_hand;
}

int vor_job_is_over(struct vor_job *job)
{
    int is_over;

    pthread_mutex_lock(&job->state);
    is_over = vor_job_status_over(job->view.status);
    pthread_mutex_unlock(&job->state);
    return is_over;
}

/* A process without a method places no points: all of its work but that of `register` is done
 * before the first record, and a stop changes nothing. */
void vor_job_describe(struct vor_job_view *view, enum vor_answer asked)
{
    static const char *const sentences[VOR_STAGES] = {
        [VOR_STAGE_QUEUED] = "Waiting for its turn",
        [VOR_STAGE_PREPARE] = "Preparing the input",
        [VOR_STAGE_ENCODE] = "Encoding the result",
    };
    const char *sentence = sentences[view->stage];

    if (view->stage == VOR_STAGE_PREPARE && view->spec.process->methods == 0)
        sentence = "Working on the input";
    else if (view->stage == VOR_STAGE_PREPARE && asked == VOR_STOP)
        sentence = "Preparing the input before it stops";
    if (view->stage == VOR_STAGE_OPTIMIZE) {
        const struct vor_record *record = &view->record; /* "Iteration 3 of at most 12" */
        const char *step = vor_run_stage_info(record->stage)->step;
        char most[32] = "";

        if (record->of > 0 || record->step == 0)
            (void)snprintf(most, sizeof most, " of at most %u", (unsigned)record->of);
        (void)snprintf(view->message, sizeof view->message, "%c%s %u%s",
                       toupper((unsigned char)step[0]), step + 1, (unsigned)record->step, most);
    } else
        (void)snprintf(view->message, sizeof view->message, "%s", sentence);
}

void vor_job_view(struct vor_job *job, struct vor_job_view *out)
{
    pthread_mutex_lock(&job->state);
    *out = job->view;
    out->eta_seconds = estimate(job);
    pthread_mutex_unlock(&job->state);
    if (!vor_job_status_over(out->status))
        vor_job_describe(out, vor_job_asked(job));
}

/* Begins a change: job->change and job->state are held. False, and nothing is held, when the job is
 * over. */
static int begin_change(struct vor_job *job)
{
    pthread_mutex_lock(&job->change);
    pthread_mutex_lock(&job->state);
    if (!vor_job_status_over(job->view.status))
        return 1;
    pthread_mutex_unlock(&job->state);
    pthread_mutex_unlock(&job->change);
    return 0;
}

/* Ends it with an event. */
static void end_change(struct vor_job *job, enum vor_event_kind kind, int64_t now_ms)
{
    pthread_mutex_unlock(&job->state);
    publish(job, kind, now_ms);
    pthread_mutex_unlock(&job->change);
}

static void raise_progress(struct vor_job_view *view, int progress)
{
    if (progress > view->progress)
        view->progress = progress;
}

/* Begins to reckon with the time; the caller holds job->state. */
static void begin_pace(struct vor_job *job)
{
    const struct vor_job_view *view = &job->view;

    job->eta = (struct vor_eta){
        .work = vor_eta_work_of(&view->spec, view->input[0].points, vor_machine_cores())};
}

void vor_job_begin(struct vor_job *job, int64_t now_ms)
{
    if (!begin_change(job))
        return;
    job->is_here = 1;
    job->view.status = VOR_JOB_RUNNING;
    job->view.stage = VOR_STAGE_PREPARE;
    job->view.updated = vor_job_now(&job->view, now_ms);
    if (job->view.started == 0)
        job->view.started = job->view.updated;
    begin_pace(job);
    end_change(job, VOR_EVENT_STATUS, now_ms);
}

int vor_job_restart(struct vor_job *job, int is_suspect, int64_t now_ms)
{
    if (!begin_change(job))
        return 0;
    job->view.attempt++;
    job->is_here = 0;
    job->stored = job->newest = 0;
    vor_text_clear(&job->piece);
    pthread_mutex_unlock(&job->state);
    publish(job, VOR_EVENT_REPLACED, now_ms);
    pthread_mutex_lock(&job->state);
    job->view.status = VOR_JOB_ACCEPTED;
    job->view.stage = VOR_STAGE_QUEUED;
    job->view.updated = now_ms;
    if (is_suspect)
        job->view.alone = 1;
    end_change(job, VOR_EVENT_STATUS, now_ms);
    return 1;
}

void vor_job_stage(struct vor_job *job, enum vor_stage stage, int64_t now_ms)
{
    if (!begin_change(job))
        return;
    job->view.stage = stage;
    job->view.updated = vor_job_now(&job->view, now_ms);
    if (stage == VOR_STAGE_ENCODE)
        raise_progress(&job->view, MEASURED);
    end_change(job, VOR_EVENT_STATUS, now_ms);
}

void vor_job_tell_stop(struct vor_job *job, int64_t now_ms)
{
    int preparing;

    if (!begin_change(job))
        return;
    preparing = job->view.stage == VOR_STAGE_PREPARE;
    if (preparing)
        job->view.updated = vor_job_now(&job->view, now_ms);
    pthread_mutex_unlock(&job->state);
    if (preparing)
        publish(job, VOR_EVENT_STATUS, now_ms);
    pthread_mutex_unlock(&job->change);
}

void vor_job_progress(struct vor_job *job, const struct vor_record *record, int64_t now_ms)
{
    int entered;

    if (!begin_change(job))
        return;
    entered = job->view.stage != VOR_STAGE_OPTIMIZE;
    if (entered)
        begin_pace(job);
    vor_eta_add(&job->eta, record);
    job->view.stage = VOR_STAGE_OPTIMIZE;
    job->view.has_record = 1;
    job->view.record = *record;
    job->view.updated = vor_job_now(&job->view, now_ms);
    /* 0.3 of 80 comes to 23.999...; the small addend makes it 24. */
    raise_progress(
        &job->view,
        PREPARED + (int)((OPTIMIZED - PREPARED) * vor_eta_done(&job->eta, &job->view.spec) + 1e-9));
    pthread_mutex_unlock(&job->state);
    if (entered)
        publish(job, VOR_EVENT_STATUS, now_ms);
    publish(job, VOR_EVENT_PROGRESS, now_ms);
    pthread_mutex_unlock(&job->change);
}

void vor_job_show(struct vor_job *job, const struct vor_shown *shown)
{
    vor_preview_put(job->preview, shown);
    wake_all(job, VOR_EVENT_PROGRESS);
}

void vor_job_show_packed(struct vor_job *job, uint32_t attempt, const struct vor_event_piece *piece)
{
    vor_preview_unpack(job->preview, attempt, piece->last, piece->data, piece->size);
    wake_all(job, VOR_EVENT_PROGRESS);
}

int vor_job_freeze(struct vor_job *job)
{
    if (!begin_change(job))
        return 0;
    pthread_mutex_unlock(&job->state);
    return 1;
}

void vor_job_thaw(struct vor_job *job)
{
    pthread_mutex_unlock(&job->change);
}

int vor_job_is_stored(struct vor_job *job)
{
    int is_stored;

    pthread_mutex_lock(&job->state);
    is_stored = job->stored == job->newest;
    pthread_mutex_unlock(&job->state);
    return is_stored;
}

void vor_job_stored(struct vor_job *job)
{
    pthread_mutex_lock(&job->state);
    job->stored = job->newest;
    vor_text_clear(&job->piece);
    pthread_mutex_unlock(&job->state);
}

void vor_job_end(struct vor_job *job, const struct vor_job_view *row)
{
    pthread_mutex_lock(&job->state);
    job->view = *row;
    job->view.queue_position = -1;
    pthread_mutex_unlock(&job->state);
    wake_all(job, VOR_EVENT_END);
}

uint32_t vor_job_newest(struct vor_job *job, uint32_t attempt)
{
    uint32_t newest;

    pthread_mutex_lock(&job->state);
    newest = job->view.attempt == attempt ? job->newest : 0;
    pthread_mutex_unlock(&job->state);
    return newest;
}

void vor_job_mirror(struct vor_job *job, const struct vor_job_view *row, uint32_t last)
{
    int is_new;

    if (row->status == VOR_JOB_ACCEPTED) {
        struct vor_job_view view;

        /* A job that waits is told as here: its attempt's first events are not in the store before
         * it runs. */
        do
            vor_job_view(job, &view);
        while (view.attempt < row->attempt && vor_job_restart(job, row->alone, row->updated));
        return;
    }
    if (!begin_change(job))
        return;
    is_new =
        job->view.status != row->status || job->view.attempt != row->attempt || job->newest != last;
    job->view = *row;
    job->view.queue_position = -1;
    job->is_here = 0;
    job->stored = job->newest = last;
    vor_text_clear(&job->piece);
    pthread_mutex_unlock(&job->state);
    if (is_new)
        wake_all(job, vor_job_status_over(row->status) ? VOR_EVENT_END : VOR_EVENT_STATUS);
    pthread_mutex_unlock(&job->change);
}

void vor_job_ask(struct vor_job *job, enum vor_answer answer)
{
    int asked = atomic_load(&job->asked);

    while (asked < (int)answer && !atomic_compare_exchange_weak(&job->asked, &asked, (int)answer))
        continue;
}

void vor_job_unask(struct vor_job *job)
{
    atomic_store(&job->asked, VOR_CONTINUE);
}

enum vor_answer vor_job_asked(struct vor_job *job)
{
    return (enum vor_answer)atomic_load(&job->asked);
}
