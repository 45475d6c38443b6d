#include "server/jobs/queue.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct entry {
    struct vor_job *job;
    int64_t seq;
    struct entry *next;
};

/* The jobs of a tenant. The one at the head leaves in round `turn`, each of the others a round
 * after the one before it. A lane without jobs is kept as long as its tenant has had its job of the
 * round that goes on, which turn remembers. */
struct lane {
    char tenant[VOR_JOB_PRINCIPAL_SIZE];
    int64_t turn;
    struct entry *head, *last;
    struct lane *next;
};

struct vor_queue {
    pthread_mutex_t mutex;
    pthread_cond_t ready;
    struct lane *lanes;
    struct entry *spare;      /* one for every booked place: pushing cannot fail */
    struct lane *spare_lanes; /* likewise */
    int64_t round;            /* of the job that left last */
    size_t waiting, booked, capacity;
    int (*may)(void *ctx, struct vor_job *job); /* NULL for always */
    void *may_ctx;
    int closed;
};

struct vor_queue *vor_queue_create(size_t capacity)
{
    struct vor_queue *queue = calloc(1, sizeof *queue);

    if (queue == NULL)
        return NULL;
    pthread_mutex_init(&queue->mutex, NULL);
    pthread_cond_init(&queue->ready, NULL);
    queue->capacity = capacity;
    return queue;
}

void vor_queue_guard(struct vor_queue *queue, int (*may)(void *ctx, struct vor_job *job), void *ctx)
{
    queue->may = may;
    queue->may_ctx = ctx;
}

void vor_queue_look(struct vor_queue *queue)
{
    pthread_mutex_lock(&queue->mutex);
    pthread_cond_broadcast(&queue->ready);
    pthread_mutex_unlock(&queue->mutex);
}

static void free_entries(struct entry *entry)
{
    while (entry != NULL) {
        struct entry *next = entry->next;

        vor_job_release(entry->job);
        free(entry);
        entry = next;
    }
}

static void free_lanes(struct lane *lane)
{
    while (lane != NULL) {
        struct lane *next = lane->next;

        free_entries(lane->head);
        free(lane);
        lane = next;
    }
}

void vor_queue_destroy(struct vor_queue *queue)
{
    if (queue == NULL)
        return;
    free_lanes(queue->lanes);
    free_lanes(queue->spare_lanes);
    free_entries(queue->spare);
    pthread_cond_destroy(&queue->ready);
    pthread_mutex_destroy(&queue->mutex);
    free(queue);
}

/* --- room ------------------------------------------------------------------------------------- */

/* Room for a job, be it the first of its tenant. */
struct room {
    struct entry *entry;
    struct lane *lane;
};

static int room_make(struct room *room)
{
    *room = (struct room){calloc(1, sizeof *room->entry), calloc(1, sizeof *room->lane)};
    return room->entry != NULL && room->lane != NULL;
}

static void room_free(struct room *room)
{
    free(room->entry);
    free(room->lane);
}

/* The mutex is held, here and in what follows. */
static void room_give(struct vor_queue *queue, struct room *room)
{
    room->entry->next = queue->spare;
    queue->spare = room->entry;
    room->lane->next = queue->spare_lanes;
    queue->spare_lanes = room->lane;
    *room = (struct room){NULL, NULL};
}

static struct entry *take_entry(struct vor_queue *queue)
{
    struct entry *entry = queue->spare;

    queue->spare = entry->next;
    return entry;
}

static struct lane *take_lane(struct vor_queue *queue)
{
    struct lane *lane = queue->spare_lanes;

    queue->spare_lanes = lane->next;
    return lane;
}

enum vor_job_outcome vor_queue_reserve(struct vor_queue *queue)
{
    enum vor_job_outcome outcome = VOR_FULL;
    struct room room;
    int is_made = room_make(&room);

    pthread_mutex_lock(&queue->mutex);
    if (queue->closed) {
        outcome = VOR_DRAINING;
    } else if (is_made && queue->waiting + queue->booked < queue->capacity) {
        room_give(queue, &room);
        queue->booked++;
        outcome = VOR_DONE;
    }
    pthread_mutex_unlock(&queue->mutex);
    room_free(&room);
    return outcome;
}

void vor_queue_cancel(struct vor_queue *queue)
{
    struct room room;

    pthread_mutex_lock(&queue->mutex);
    room = (struct room){take_entry(queue), take_lane(queue)};
    queue->booked--;
    pthread_mutex_unlock(&queue->mutex);
    room_free(&room);
}

/* --- in and out ------------------------------------------------------------------------------- */

/* The lane of a tenant. A new one is made of the spare one, which is freed else, and begins with
 * the round that goes on. */
static struct lane *lane_of(struct vor_queue *queue, const char *tenant, struct lane *spare)
{
    struct lane *lane = queue->lanes;

    while (lane != NULL && strcmp(lane->tenant, tenant) != 0)
        lane = lane->next;
    if (lane != NULL) {
        free(spare);
        return lane;
    }
    *spare = (struct lane){.turn = queue->round, .next = queue->lanes};
    (void)snprintf(spare->tenant, sizeof spare->tenant, "%s", tenant);
    queue->lanes = spare;
    return spare;
}

/* Puts an entry where its seq belongs in the lane, which nearly always is the end. */
static void insert(struct vor_queue *queue, struct vor_job *job, int64_t seq)
{
    struct lane *lane = lane_of(queue, vor_job_tenant(job), take_lane(queue));
    struct entry *entry = take_entry(queue), **at = &lane->head;

    if (lane->last != NULL && lane->last->seq < seq)
        at = &lane->last->next;
    while (*at != NULL && (*at)->seq < seq)
        at = &(*at)->next;
    *entry = (struct entry){.job = vor_job_retain(job), .seq = seq, .next = *at};
    *at = entry;
    if (entry->next == NULL)
        lane->last = entry;
    queue->waiting++;
    pthread_cond_signal(&queue->ready);
}

/* Frees the lanes without jobs whose tenant has had no job of the round that goes on. */
static void forget_lanes(struct vor_queue *queue)
{
    struct lane **at = &queue->lanes;

    while (*at != NULL) {
        struct lane *lane = *at;

        if (lane->head != NULL || lane->turn > queue->round) {
            at = &lane->next;
            continue;
        }
        *at = lane->next;
        free(lane);
    }
}

/* Takes the entry at *at, behind `before`, out of its lane. */
static struct entry *take_out(struct vor_queue *queue, struct lane *lane, struct entry **at,
                              struct entry *before)
{
    struct entry *entry = *at;

    *at = entry->next;
    if (lane->last == entry)
        lane->last = before;
    entry->next = NULL;
    queue->waiting--;
    return entry;
}

/* True when the job at the head of a lane leaves before that of another. */
static int goes_before(const struct lane *a, const struct lane *b)
{
    return a->turn != b->turn ? a->turn < b->turn : a->head->seq < b->head->seq;
}

/* The lane whose first job leaves next; NULL when none waits. */
static struct lane *next_lane(struct vor_queue *queue)
{
    struct lane *first = NULL;

    for (struct lane *lane = queue->lanes; lane != NULL; lane = lane->next)
        if (lane->head != NULL && (first == NULL || goes_before(lane, first)))
            first = lane;
    return first;
}

/* Takes out the job at the head of that lane. */
static struct entry *take_next(struct vor_queue *queue, struct lane *lane)
{
    struct entry *entry = take_out(queue, lane, &lane->head, NULL);

    queue->round = lane->turn > queue->round ? lane->turn : queue->round;
    lane->turn++;
    forget_lanes(queue);
    return entry;
}

void vor_queue_push(struct vor_queue *queue, struct vor_job *job, int64_t seq)
{
    pthread_mutex_lock(&queue->mutex);
    queue->booked--;
    insert(queue, job, seq);
    pthread_mutex_unlock(&queue->mutex);
}

vor_status vor_queue_restore(struct vor_queue *queue, struct vor_job *job, int64_t seq,
                             struct vor_error *err)
{
    struct room room;

    if (!room_make(&room)) {
        room_free(&room);
        return vor_fail(err, VOR_E_NOMEM, "a place in the queue");
    }
    pthread_mutex_lock(&queue->mutex);
    room_give(queue, &room);
    insert(queue, job, seq);
    pthread_mutex_unlock(&queue->mutex);
    return VOR_OK;
}

/* The lane of the job that leaves next, if it may leave now. The mutex is held. */
static struct lane *allowed_lane(struct vor_queue *queue)
{
    struct lane *lane = next_lane(queue);

    if (lane != NULL && queue->may != NULL && !queue->may(queue->may_ctx, lane->head->job))
        return NULL;
    return lane;
}

struct vor_job *vor_queue_pop(struct vor_queue *queue)
{
    struct entry *entry = NULL;
    struct vor_job *job = NULL;
    struct lane *lane = NULL;

    pthread_mutex_lock(&queue->mutex);
    while (!queue->closed && (lane = allowed_lane(queue)) == NULL)
        pthread_cond_wait(&queue->ready, &queue->mutex);
    if (lane != NULL) {
        entry = take_next(queue, lane);
        job = entry->job;
    }
    pthread_mutex_unlock(&queue->mutex);
    free(entry);
    return job;
}

/* Takes a job out of a lane; NULL when it does not wait there. */
static struct entry *remove_from(struct vor_queue *queue, struct lane *lane,
                                 const struct vor_job *job)
{
    struct entry **at = &lane->head, *before = NULL;

    while (*at != NULL && (*at)->job != job) {
        before = *at;
        at = &(*at)->next;
    }
    return *at != NULL ? take_out(queue, lane, at, before) : NULL;
}

int vor_queue_remove(struct vor_queue *queue, const struct vor_job *job)
{
    struct entry *entry = NULL;
    int is_removed;

    pthread_mutex_lock(&queue->mutex);
    for (struct lane *lane = queue->lanes; lane != NULL && entry == NULL; lane = lane->next)
        entry = remove_from(queue, lane, job);
    forget_lanes(queue);
    if (entry != NULL)
        pthread_cond_broadcast(&queue->ready); /* the next one may be allowed what it was not */
    pthread_mutex_unlock(&queue->mutex);
    is_removed = entry != NULL;
    free_entries(entry);
    return is_removed;
}

/* --- looking ---------------------------------------------------------------------------------- */

/* Finds the round in which a job leaves, and its seq; false when it does not wait. */
static int find_turn(const struct vor_queue *queue, const struct vor_job *job, int64_t *turn,
                     int64_t *seq)
{
    for (const struct lane *lane = queue->lanes; lane != NULL; lane = lane->next) {
        *turn = lane->turn;
        for (const struct entry *entry = lane->head; entry != NULL; entry = entry->next) {
            *seq = entry->seq;
            if (entry->job == job)
                return 1;
            ++*turn;
        }
    }
    return 0;
}

/* How many jobs of a lane leave before the one of that round and seq. */
static long count_before(const struct lane *lane, int64_t turn, int64_t seq)
{
    int64_t at = lane->turn;
    long count = 0;

    for (const struct entry *entry = lane->head; entry != NULL && at <= turn; entry = entry->next)
        count += at++ < turn || entry->seq < seq;
    return count;
}

long vor_queue_position(struct vor_queue *queue, const struct vor_job *job)
{
    int64_t turn = 0, seq = 0;
    long position = 0;

    pthread_mutex_lock(&queue->mutex);
    if (!find_turn(queue, job, &turn, &seq)) {
        pthread_mutex_unlock(&queue->mutex);
        return -1;
    }
    for (const struct lane *lane = queue->lanes; lane != NULL; lane = lane->next)
        position += count_before(lane, turn, seq);
    pthread_mutex_unlock(&queue->mutex);
    return position;
}

int64_t vor_queue_oldest(struct vor_queue *queue)
{
    struct vor_job_view view = {.created = 0};
    const struct lane *lane;
    struct vor_job *job = NULL;

    pthread_mutex_lock(&queue->mutex);
    lane = next_lane(queue);
    if (lane != NULL)
        job = vor_job_retain(lane->head->job);
    pthread_mutex_unlock(&queue->mutex);
    if (job != NULL) {
        vor_job_view(job, &view);
        vor_job_release(job);
    }
    return view.created;
}

size_t vor_queue_depth(struct vor_queue *queue)
{
    size_t depth;

    pthread_mutex_lock(&queue->mutex);
    depth = queue->waiting + queue->booked;
    pthread_mutex_unlock(&queue->mutex);
    return depth;
}

size_t vor_queue_capacity(const struct vor_queue *queue)
{
    return queue->capacity;
}

void vor_queue_close(struct vor_queue *queue)
{
    pthread_mutex_lock(&queue->mutex);
    queue->closed = 1;
    pthread_cond_broadcast(&queue->ready);
    pthread_mutex_unlock(&queue->mutex);
}
