#include "server/work/live.h"

#include "server/base/clock.h"

/* Jobs that wait or have booked a place. The mutex is held, here and in the next. */
static size_t depth_of(const struct vor_worker *worker)
{
    int64_t depth = worker->capacity.waiting + worker->capacity.booked;

    return depth > 0 ? (size_t)depth : 0;
}

static enum vor_job_outcome room_of(const struct vor_worker *worker)
{
    if (worker->draining)
        return VOR_DRAINING;
    return depth_of(worker) < worker->config.queue ? VOR_DONE : VOR_FULL;
}

/* Which limit a ledger that is over has passed, and the words for it. */
static enum vor_job_outcome refuse(const char *tenant, const struct vor_ledger *ledger,
                                   uint64_t bytes, struct vor_error *err)
{
    if (ledger->jobs_max > 0 && ledger->jobs >= ledger->jobs_max) {
        (void)vor_fail(err, VOR_E_LIMIT,
                       "the key %s has %llu waiting or running jobs; it may not have more", tenant,
                       (unsigned long long)ledger->jobs_max);
        return VOR_CROWDED;
    }
    (void)vor_fail(err, VOR_E_LIMIT,
                   "the key %s stores %llu bytes of inputs and results, and this request would add "
                   "%llu, want at most %llu in all: dismiss jobs, or wait until they expire",
                   tenant, (unsigned long long)ledger->bytes, (unsigned long long)bytes,
                   (unsigned long long)ledger->bytes_max);
    return VOR_OVER_BYTES;
}

enum vor_job_outcome vor_worker_room(struct vor_worker *worker, const struct vor_job_label *label,
                                     uint64_t bytes, struct vor_error *err)
{
    struct vor_job_view view;
    struct vor_ledger ledger;
    enum vor_job_outcome room;
    int found;

    pthread_mutex_lock(&worker->mutex);
    room = room_of(worker);
    if (worker->capacity.bytes >= worker->config.queue_bytes && room == VOR_DONE)
        room = VOR_FULL;
    pthread_mutex_unlock(&worker->mutex);
    if (label == NULL)
        return room;
    ledger = (struct vor_ledger){.jobs_max = label->jobs_max, .bytes_max = label->bytes_max};
    if (room == VOR_DONE && (ledger.jobs_max > 0 || ledger.bytes_max > 0)) {
        const char *tenant = label->key->principal;

        if (vor_store_ledger(worker->config.store, tenant, &ledger, err) != VOR_OK)
            room = VOR_FAILED;
        else if (!vor_ledger_fits(&ledger, bytes))
            room = refuse(tenant, &ledger, bytes, err);
    }
    if (room != VOR_DONE && room != VOR_FAILED && label->key->text[0] != '\0' &&
        vor_store_find_key(worker->config.store, label->key, &view, &found, NULL) == VOR_OK &&
        found)
        return VOR_DONE;
    return room;
}

enum vor_job_outcome vor_worker_book(struct vor_worker *worker)
{
    enum vor_job_outcome room;

    pthread_mutex_lock(&worker->mutex);
    room = room_of(worker);
    worker->capacity.booked += room == VOR_DONE;
    pthread_mutex_unlock(&worker->mutex);
    return room;
}

void vor_worker_unbook(struct vor_worker *worker)
{
    pthread_mutex_lock(&worker->mutex);
    worker->capacity.booked--;
    pthread_mutex_unlock(&worker->mutex);
}

void vor_worker_load(struct vor_worker *worker, struct vor_worker_load *out)
{
    struct vor_waiting waiting;

    if (vor_store_waiting(worker->config.store, &waiting, NULL) != VOR_OK)
        waiting.oldest_ms = 0;
    out->oldest_ms = waiting.oldest_ms;
    pthread_mutex_lock(&worker->mutex);
    out->waiting = depth_of(worker);
    out->running = worker->capacity.running;
    out->reserved = worker->capacity.used;
    pthread_mutex_unlock(&worker->mutex);
    out->budget = worker->config.budget;
}

void vor_capacity_begin(struct vor_worker *worker, const struct vor_waiting *waiting)
{
    pthread_mutex_lock(&worker->mutex);
    worker->capacity.waiting = (int64_t)waiting->jobs;
    worker->capacity.bytes = waiting->decoded;
    pthread_mutex_unlock(&worker->mutex);
}

enum vor_job_outcome vor_capacity_insert(struct vor_worker *worker, struct vor_job_view *row,
                                         struct vor_ledger *ledger, struct vor_error *err)
{
    struct vor_capacity *capacity = &worker->capacity;
    uint64_t most = worker->config.queue_bytes;
    enum vor_job_outcome outcome = VOR_DONE;
    int fits;

    pthread_mutex_lock(&worker->mutex);
    fits = capacity->bytes <= most && row->decoded <= most - capacity->bytes;
    capacity->bytes += fits ? row->decoded : 0;
    pthread_mutex_unlock(&worker->mutex);
    if (!fits)
        return VOR_FULL;
    if (vor_store_insert(worker->config.store, row, ledger, err) != VOR_OK)
        outcome = VOR_FAILED;
    else if (ledger->is_over)
        outcome = refuse(row->key.principal, ledger, row->kept, err);
    pthread_mutex_lock(&worker->mutex);
    if (outcome == VOR_DONE) {
        capacity->booked--;
        capacity->waiting++;
        worker->news++;
        pthread_cond_signal(&worker->ready);
    } else {
        capacity->bytes -= row->decoded;
    }
    pthread_mutex_unlock(&worker->mutex);
    return outcome;
}

/* The count may have been made anew meanwhile (vor_capacity_begin). */
static void take_bytes(struct vor_capacity *capacity, uint64_t bytes)
{
    capacity->bytes -= bytes < capacity->bytes ? bytes : capacity->bytes;
}

void vor_capacity_wait(struct vor_worker *worker, const struct vor_job_view *row, int by)
{
    pthread_mutex_lock(&worker->mutex);
    worker->capacity.waiting += by;
    if (by > 0)
        worker->capacity.bytes += row->decoded;
    else
        take_bytes(&worker->capacity, row->decoded);
    worker->news++;
    pthread_cond_signal(&worker->ready);
    pthread_mutex_unlock(&worker->mutex);
}

int vor_capacity_claim(struct vor_worker *worker, struct vor_claim *claim)
{
    const struct vor_capacity *capacity = &worker->capacity;
    int may;

    *claim = (struct vor_claim){
        .owner = worker->owner.text, .now_ms = vor_clock_wall_ms(), .build = vor_build_own()};
    pthread_mutex_lock(&worker->mutex);
    may = capacity->waiting > 0 && !worker->draining && !atomic_load(&worker->is_late) &&
          !(capacity->running > 0 && capacity->runs_alone);
    if (capacity->running == 0)
        claim->memory = UINT64_MAX;
    else if (capacity->used < worker->config.budget)
        claim->memory = worker->config.budget - capacity->used;
    /* A suspect need not wait where it is apart anyway. */
    claim->may_be_alone = capacity->running == 0 || worker->config.executor->is_apart;
    pthread_mutex_unlock(&worker->mutex);
    return may && vor_blobs_reach(worker->config.blobs, NULL) == VOR_OK;
}

void vor_capacity_run(struct vor_worker *worker, const struct vor_job_view *row)
{
    struct vor_capacity *capacity = &worker->capacity;

    capacity->waiting--;
    take_bytes(capacity, row->decoded);
    capacity->running++;
    capacity->used += row->memory;
    capacity->runs_alone = row->alone && !worker->config.executor->is_apart;
}

void vor_capacity_leave(struct vor_worker *worker, const struct vor_job_view *row)
{
    struct vor_capacity *capacity = &worker->capacity;

    capacity->running--;
    capacity->used -= row->memory;
    capacity->runs_alone = 0; /* who was alone was the only one */
    worker->news++;
    pthread_cond_broadcast(&worker->ready);
    pthread_cond_broadcast(&worker->changed);
}
