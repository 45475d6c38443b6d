#include "server/jobs/queue.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A job that waits, in a treap: a search tree by seq, a heap by the hash of seq, which keeps it
 * about as deep as a balanced one. With the counts, whatever is asked is O(log n). */
struct entry {
    struct vor_job *job;
    int64_t seq;
    size_t count;               /* of the entries at and below it */
    struct entry *left, *right; /* a list goes on at right */
};

/* The jobs of a tenant. The first one leaves in round `turn`, each of the others a round after the
 * one before it. A lane without jobs is kept as long as its tenant has had its job of the
 * round that goes on, which turn remembers. */
struct lane {
    char tenant[VOR_JOB_PRINCIPAL_SIZE];
    int64_t turn;
    struct entry *root;
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

/* --- treaps ----------------------------------------------------------------------------------- */

static size_t count_of(const struct entry *root)
{
    return root != NULL ? root->count : 0;
}

static uint64_t hash_of(const struct entry *entry)
{
    uint64_t hash = (uint64_t)entry->seq * 0x9e3779b97f4a7c15; /* 2^64 / golden ratio: Knuth 6.4 */

    return (hash ^ hash >> 32) * 0x9e3779b97f4a7c15;
}

static void count_again(struct entry *root)
{
    root->count = 1 + count_of(root->left) + count_of(root->right);
}

/* Those below seq, and the others. */
static void split(struct entry *root, int64_t seq, struct entry **below, struct entry **others)
{
    if (root == NULL) {
        *below = *others = NULL;
        return;
    }
    if (root->seq < seq) {
        *below = root;
        split(root->right, seq, &root->right, others);
    } else {
        *others = root;
        split(root->left, seq, below, &root->left);
    }
    count_again(root);
}

/* All of a are below all of b. */
static struct entry *join(struct entry *a, struct entry *b)
{
    struct entry *root = a == NULL || (b != NULL && hash_of(b) > hash_of(a)) ? b : a;

    if (a == NULL || b == NULL)
        return root;
    if (root == a)
        a->right = join(a->right, b);
    else
        b->left = join(a, b->left);
    count_again(root);
    return root;
}

/* How many are below seq. */
static size_t rank_of(const struct entry *root, int64_t seq)
{
    size_t rank = 0;

    while (root != NULL) {
        if (root->seq < seq)
            rank += 1 + count_of(root->left);
        root = root->seq < seq ? root->right : root->left;
    }
    return rank;
}

/* The entry with so many below it, which is there. */
static const struct entry *entry_at(const struct entry *root, size_t rank)
{
    while (rank != count_of(root->left)) {
        size_t left = count_of(root->left);

        root = rank < left ? root->left : root->right;
        rank -= rank < left ? 0 : left + 1;
    }
    return root;
}

/* Takes the entry of a job out; NULL when it is not there. */
static struct entry *take_out(struct entry **root, const struct vor_job *job)
{
    int64_t seq = vor_job_seq(job);
    struct entry *below, *others, *entry, *above;

    split(*root, seq, &below, &others);
    split(others, seq + 1, &entry, &above);
    if (entry != NULL && entry->job != job) { /* not of this queue */
        above = join(entry, above);
        entry = NULL;
    }
    *root = join(below, above);
    return entry;
}

static void free_entries(struct entry *entry)
{
    while (entry != NULL) { /* a list may be long */
        struct entry *next = entry->right;

        free_entries(entry->left);
        vor_job_release(entry->job);
        free(entry);
        entry = next;
    }
}

static void free_lanes(struct lane *lane)
{
    while (lane != NULL) {
        struct lane *next = lane->next;

        free_entries(lane->root);
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
    room->entry->right = queue->spare;
    queue->spare = room->entry;
    room->lane->next = queue->spare_lanes;
    queue->spare_lanes = room->lane;
    *room = (struct room){NULL, NULL};
}

static struct entry *take_entry(struct vor_queue *queue)
{
    struct entry *entry = queue->spare;

    queue->spare = entry->right;
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

/* The lane of a tenant; NULL when there is none. */
static struct lane *find_lane(const struct vor_queue *queue, const char *tenant)
{
    struct lane *lane = queue->lanes;

    while (lane != NULL && strcmp(lane->tenant, tenant) != 0)
        lane = lane->next;
    return lane;
}

/* The lane of a tenant. A new one is made of the spare one, which is freed else, and begins with
 * the round that goes on. */
static struct lane *lane_of(struct vor_queue *queue, const char *tenant, struct lane *spare)
{
    struct lane *lane = find_lane(queue, tenant);

    if (lane != NULL) {
        free(spare);
        return lane;
    }
    *spare = (struct lane){.turn = queue->round, .next = queue->lanes};
    (void)snprintf(spare->tenant, sizeof spare->tenant, "%s", tenant);
    queue->lanes = spare;
    return spare;
}

static void insert(struct vor_queue *queue, struct vor_job *job, int64_t seq)
{
    struct lane *lane = lane_of(queue, vor_job_tenant(job), take_lane(queue));
    struct entry *entry = take_entry(queue), *below, *above;

    *entry = (struct entry){.job = vor_job_retain(job), .seq = seq, .count = 1};
    split(lane->root, seq, &below, &above);
    lane->root = join(join(below, entry), above);
    queue->waiting++;
    pthread_cond_signal(&queue->ready);
}

/* Frees the lanes without jobs whose tenant has had no job of the round that goes on. */
static void forget_lanes(struct vor_queue *queue)
{
    struct lane **at = &queue->lanes;

    while (*at != NULL) {
        struct lane *lane = *at;

        if (lane->root != NULL || lane->turn > queue->round) {
            at = &lane->next;
            continue;
        }
        *at = lane->next;
        free(lane);
    }
}

/* The job of a lane that leaves first. */
static const struct entry *first_of(const struct lane *lane)
{
    return entry_at(lane->root, 0);
}

/* True when the first job of a lane leaves before that of another. */
static int goes_before(const struct lane *a, const struct lane *b)
{
    return a->turn != b->turn ? a->turn < b->turn : first_of(a)->seq < first_of(b)->seq;
}

/* The lane whose first job leaves next; NULL when none waits. */
static struct lane *next_lane(struct vor_queue *queue)
{
    struct lane *first = NULL;

    for (struct lane *lane = queue->lanes; lane != NULL; lane = lane->next)
        if (lane->root != NULL && (first == NULL || goes_before(lane, first)))
            first = lane;
    return first;
}

/* Takes out the first job of that lane. */
static struct entry *take_next(struct vor_queue *queue, struct lane *lane)
{
    struct entry *entry = take_out(&lane->root, first_of(lane)->job);

    queue->waiting--;
    queue->round = lane->turn > queue->round ? lane->turn : queue->round;
    lane->turn++;
    forget_lanes(queue);
    return entry;
}

void vor_queue_push(struct vor_queue *queue, struct vor_job *job, int64_t seq)
{
    vor_job_set_seq(job, seq);
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
    vor_job_set_seq(job, seq);
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

    if (lane != NULL && queue->may != NULL && !queue->may(queue->may_ctx, first_of(lane)->job))
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

int vor_queue_remove(struct vor_queue *queue, const struct vor_job *job)
{
    struct entry *entry = NULL;
    struct lane *lane;
    int is_removed;

    pthread_mutex_lock(&queue->mutex);
    lane = find_lane(queue, vor_job_tenant(job));
    if (lane != NULL)
        entry = take_out(&lane->root, job);
    if (entry != NULL) {
        entry->left = entry->right = NULL;
        queue->waiting--;
        pthread_cond_broadcast(&queue->ready); /* the next one may be allowed what it was not */
    }
    forget_lanes(queue);
    pthread_mutex_unlock(&queue->mutex);
    is_removed = entry != NULL;
    free_entries(entry);
    return is_removed;
}

/* --- looking ---------------------------------------------------------------------------------- */

/* How many jobs of a lane leave before the one of that round and seq. */
static size_t count_before(const struct lane *lane, int64_t turn, int64_t seq)
{
    size_t count = count_of(lane->root), rank;

    if (turn < lane->turn)
        return 0;
    rank = (size_t)(turn - lane->turn);
    if (rank >= count)
        return count;
    return rank + (entry_at(lane->root, rank)->seq < seq);
}

long vor_queue_position(struct vor_queue *queue, const struct vor_job *job)
{
    int64_t seq = vor_job_seq(job);
    const struct lane *own;
    long position = -1;
    size_t rank = 0;

    pthread_mutex_lock(&queue->mutex);
    own = find_lane(queue, vor_job_tenant(job));
    if (own != NULL)
        rank = rank_of(own->root, seq);
    if (own != NULL && rank < count_of(own->root) && entry_at(own->root, rank)->job == job) {
        position = 0;
        for (const struct lane *lane = queue->lanes; lane != NULL; lane = lane->next)
            position += (long)count_before(lane, own->turn + (int64_t)rank, seq);
    }
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
        job = vor_job_retain(first_of(lane)->job);
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
