#include "server/jobs/queue.h"

#include <pthread.h>
#include <stdlib.h>

struct entry {
    struct vor_job *job;
    int64_t seq;
    struct entry *next;
};

struct vor_queue {
    pthread_mutex_t mutex;
    pthread_cond_t ready;
    struct entry *head, *last;
    struct entry *spare; /* one for every booked place: pushing cannot fail */
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

void vor_queue_destroy(struct vor_queue *queue)
{
    if (queue == NULL)
        return;
    free_entries(queue->head);
    free_entries(queue->spare);
    pthread_cond_destroy(&queue->ready);
    pthread_mutex_destroy(&queue->mutex);
    free(queue);
}

enum vor_job_outcome vor_queue_reserve(struct vor_queue *queue)
{
    struct entry *entry = calloc(1, sizeof *entry);
    enum vor_job_outcome outcome = VOR_FULL;

    pthread_mutex_lock(&queue->mutex);
    if (queue->closed) {
        outcome = VOR_DRAINING;
    } else if (entry != NULL && queue->waiting + queue->booked < queue->capacity) {
        entry->next = queue->spare;
        queue->spare = entry;
        queue->booked++;
        entry = NULL;
        outcome = VOR_DONE;
    }
    pthread_mutex_unlock(&queue->mutex);
    free(entry);
    return outcome;
}

/* The entry of a booked place; the mutex is held. */
static struct entry *take_spare(struct vor_queue *queue)
{
    struct entry *entry = queue->spare;

    queue->spare = entry->next;
    queue->booked--;
    return entry;
}

void vor_queue_cancel(struct vor_queue *queue)
{
    struct entry *entry;

    pthread_mutex_lock(&queue->mutex);
    entry = take_spare(queue);
    pthread_mutex_unlock(&queue->mutex);
    free(entry);
}

/* Puts an entry where its seq belongs, which nearly always is the end; the mutex is held. */
static void insert(struct vor_queue *queue, struct entry *entry, struct vor_job *job, int64_t seq)
{
    struct entry **at = &queue->head;

    if (queue->last != NULL && queue->last->seq < seq)
        at = &queue->last->next;
    while (*at != NULL && (*at)->seq < seq)
        at = &(*at)->next;
    *entry = (struct entry){.job = vor_job_retain(job), .seq = seq, .next = *at};
    *at = entry;
    if (entry->next == NULL)
        queue->last = entry;
    queue->waiting++;
    pthread_cond_signal(&queue->ready);
}

void vor_queue_push(struct vor_queue *queue, struct vor_job *job, int64_t seq)
{
    pthread_mutex_lock(&queue->mutex);
    insert(queue, take_spare(queue), job, seq);
    pthread_mutex_unlock(&queue->mutex);
}

vor_status vor_queue_restore(struct vor_queue *queue, struct vor_job *job, int64_t seq,
                             struct vor_error *err)
{
    struct entry *entry = calloc(1, sizeof *entry);

    if (entry == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a place in the queue");
    pthread_mutex_lock(&queue->mutex);
    insert(queue, entry, job, seq);
    pthread_mutex_unlock(&queue->mutex);
    return VOR_OK;
}

/* Is there a job that may leave now? The mutex is held. */
static int has_next(struct vor_queue *queue)
{
    return queue->head != NULL &&
           (queue->may == NULL || queue->may(queue->may_ctx, queue->head->job));
}

struct vor_job *vor_queue_pop(struct vor_queue *queue)
{
    struct entry *entry = NULL;
    struct vor_job *job = NULL;

    pthread_mutex_lock(&queue->mutex);
    while (!queue->closed && !has_next(queue))
        pthread_cond_wait(&queue->ready, &queue->mutex);
    if (!queue->closed) {
        entry = queue->head;
        queue->head = entry->next;
        if (queue->head == NULL)
            queue->last = NULL;
        queue->waiting--;
        job = entry->job;
    }
    pthread_mutex_unlock(&queue->mutex);
    free(entry);
    return job;
}

int vor_queue_remove(struct vor_queue *queue, const struct vor_job *job)
{
    struct entry **at, *entry, *before = NULL;

    pthread_mutex_lock(&queue->mutex);
    for (at = &queue->head; *at != NULL && (*at)->job != job; at = &(*at)->next)
        before = *at;
    entry = *at;
    if (entry != NULL) {
        *at = entry->next;
        if (queue->last == entry)
            queue->last = before;
        entry->next = NULL;
        queue->waiting--;
        pthread_cond_broadcast(&queue->ready); /* the next one may be allowed what it was not */
    }
    pthread_mutex_unlock(&queue->mutex);
    free_entries(entry);
    return entry != NULL;
}

long vor_queue_position(struct vor_queue *queue, const struct vor_job *job)
{
    struct entry *entry;
    long position = 0;

    pthread_mutex_lock(&queue->mutex);
    for (entry = queue->head; entry != NULL && entry->job != job; entry = entry->next)
        position++;
    pthread_mutex_unlock(&queue->mutex);
    return entry != NULL ? position : -1;
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
