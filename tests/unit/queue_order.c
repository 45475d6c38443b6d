/* The queue: bounded by bookings, tenants in turn and each in the order of acceptance, closed once
 * and for all. */
#include "server/jobs/queue.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

static struct vor_job *new_job_of(const char *tenant)
{
    struct vor_job_view row = vt_row(10);
    struct vor_job *job;

    (void)snprintf(row.key.principal, sizeof row.key.principal, "%s", tenant);
    job = vor_job_create(&row);
    ck_assert_ptr_nonnull(job);
    return job;
}

static struct vor_job *new_job(void)
{
    return new_job_of("");
}

/* Books, pushes and lets go of a job; the queue has the only reference. */
static struct vor_job *enqueue_of(struct vor_queue *queue, const char *tenant, int64_t seq)
{
    struct vor_job *job = new_job_of(tenant);

    ck_assert_int_eq(vor_queue_reserve(queue), VOR_DONE);
    vor_queue_push(queue, job, seq);
    vor_job_release(job);
    return job;
}

static struct vor_job *enqueue(struct vor_queue *queue, int64_t seq)
{
    return enqueue_of(queue, "", seq);
}

/* Property: whatever is pushed, popped and taken out in whatever order, the queue is a list sorted
 * by seq. */
START_TEST(the_queue_agrees_with_a_sorted_list)
{
    enum { JOBS = 60, STEPS = 400 };
    struct vor_queue *queue = vor_queue_create(JOBS);
    struct vor_job *waits[JOBS + 1] = {NULL}; /* by seq */
    uint64_t draw = 0;

    for (int i = 0; i < STEPS; i++) {
        int seq = 1 + (int)(vt_unit((uint64_t)_i, draw++) * JOBS), first = 1;
        long position = 0;

        while (first < JOBS && waits[first] == NULL)
            first++;
        if (waits[seq] == NULL) {
            waits[seq] = enqueue(queue, seq);
        } else if (i % 3 == 0) {
            struct vor_job *popped = vor_queue_pop(queue);

            ck_assert_ptr_eq(popped, waits[first]);
            ck_assert_int_eq(vor_queue_position(queue, popped), -1);
            ck_assert(!vor_queue_remove(queue, popped));
            vor_job_release(popped);
            waits[first] = NULL;
        } else {
            ck_assert(vor_queue_remove(queue, waits[seq]));
            waits[seq] = NULL;
        }
        for (int k = 1; k <= JOBS; k++)
            if (waits[k] != NULL)
                ck_assert_int_eq(vor_queue_position(queue, waits[k]), position++);
        ck_assert_uint_eq(vor_queue_depth(queue), (size_t)position);
    }
    vor_queue_destroy(queue);
}
END_TEST

/* Takes the next job out and says whose it is. */
static char pop_letter(struct vor_queue *queue)
{
    struct vor_job *job = vor_queue_pop(queue);
    char letter = vor_job_tenant(job)[0];

    vor_job_release(job);
    return letter;
}

/* Vector: letters are jobs that come, a dot takes the next one out; who comes out is told below. */
START_TEST(tenants_take_turns)
{
    static const struct {
        const char *steps, *out;
    } vectors[] = {
        {"aaabbb......", "ababab"}, /* a flood is met halfway */
        {"aaaa.b....", "abaaa"},    /* who comes while another's job runs is next */
        {"aaaa.bb.....", "ababaa"}, /* and then takes turns */
        {"aaaa..b....", "aabaa"},   /* with two that run as well */
        {"abcabc......", "abcabc"}, /* all alike: in the order of acceptance */
        {"aa.b.b.b...", "ababb"},   /* one at a time is no way to be first always */
        {"aaa...a.b.", "aaaab"},    /* alone, a tenant owes nothing */
        {"bc.a.a.a....", "bcaaa"},  /* who has had his job of the round waits for the others */
    };

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        struct vor_queue *queue = vor_queue_create(100);
        char out[16] = "";
        size_t at = 0;
        int64_t seq = 0;

        for (const char *step = vectors[i].steps; *step != '\0'; step++) {
            char tenant[2] = {*step, '\0'};

            if (*step != '.')
                enqueue_of(queue, tenant, ++seq);
            else if (vor_queue_depth(queue) > 0)
                out[at++] = pop_letter(queue);
        }
        ck_assert_str_eq(out, vectors[i].out);
        vor_queue_destroy(queue);
    }
}
END_TEST

/* Property: whatever tenants come, each one's jobs leave in order, a position is told as it comes
 * out when nobody else comes, and between two jobs of a tenant who waits no other has three. */
START_TEST(positions_come_true_and_nobody_has_three_turns_between_two_of_another)
{
    enum { TENANTS = 5, JOBS = 80 };
    struct vor_queue *queue = vor_queue_create(JOBS);
    struct vor_job *jobs[JOBS];
    long told[JOBS];
    int since[TENANTS][TENANTS] = {{0}}; /* jobs of the second since the last of the first */
    int waits[TENANTS] = {0};

    for (int i = 0; i < JOBS; i++) {
        int tenant = (int)(vt_unit((uint64_t)_i, (uint64_t)i) * TENANTS);
        char name[2] = {(char)('a' + tenant), '\0'};

        jobs[i] = vor_job_retain(enqueue_of(queue, name, i + 1));
        waits[tenant]++;
        if (i % 7 == 6)
            waits[pop_letter(queue) - 'a']--;
    }
    for (int i = 0; i < JOBS; i++)
        told[i] = vor_queue_position(queue, jobs[i]);
    for (long left = 0; vor_queue_depth(queue) > 0; left++) {
        struct vor_job *job = vor_queue_pop(queue);
        int tenant = vor_job_tenant(job)[0] - 'a';

        for (int i = 0; i < JOBS; i++)
            if (jobs[i] == job && told[i] >= 0)
                ck_assert_int_eq(told[i], left);
        waits[tenant]--;
        for (int other = 0; other < TENANTS; other++) {
            since[tenant][other] = 0;
            since[other][tenant] += other != tenant && waits[other] > 0;
            ck_assert_int_le(since[other][tenant], 2);
        }
        vor_job_release(job);
    }
    for (int i = 0; i < JOBS; i++)
        vor_job_release(jobs[i]);
    vor_queue_destroy(queue);
}
END_TEST

START_TEST(a_booked_place_counts_until_it_is_given_back)
{
    struct vor_queue *queue = vor_queue_create(2);

    ck_assert_int_eq(vor_queue_reserve(queue), VOR_DONE);
    ck_assert_int_eq(vor_queue_reserve(queue), VOR_DONE);
    ck_assert_int_eq(vor_queue_reserve(queue), VOR_FULL);
    ck_assert_uint_eq(vor_queue_depth(queue), 2);
    vor_queue_cancel(queue);
    ck_assert_int_eq(vor_queue_reserve(queue), VOR_DONE);
    vor_queue_destroy(queue);
}
END_TEST

START_TEST(a_full_queue_takes_the_next_job_once_one_left)
{
    struct vor_queue *queue = vor_queue_create(2);
    struct vor_job *first;

    enqueue(queue, 1);
    enqueue(queue, 2);
    ck_assert_int_eq(vor_queue_reserve(queue), VOR_FULL);
    first = vor_queue_pop(queue);
    vor_job_release(first);
    ck_assert_int_eq(vor_queue_reserve(queue), VOR_DONE);
    ck_assert_uint_eq(vor_queue_capacity(queue), 2);
    vor_queue_destroy(queue);
}
END_TEST

START_TEST(jobs_of_a_former_run_fit_beyond_the_bound)
{
    struct vor_queue *queue = vor_queue_create(1);

    for (int i = 0; i < 5; i++) {
        struct vor_job *job = new_job();

        vt_assert_ok(vor_queue_restore(queue, job, 10 - i, &vt_err));
        vor_job_release(job);
    }
    ck_assert_uint_eq(vor_queue_depth(queue), 5);
    ck_assert_int_eq(vor_queue_reserve(queue), VOR_FULL);
    vor_queue_destroy(queue);
}
END_TEST

static void *pop_until_closed(void *arg)
{
    struct vor_job *job;
    size_t count = 0;

    while ((job = vor_queue_pop(arg)) != NULL) {
        vor_job_release(job);
        count++;
    }
    return (void *)count;
}

START_TEST(every_job_is_popped_exactly_once_by_several_threads)
{
    enum { JOBS = 400, THREADS = 4 };
    struct vor_queue *queue = vor_queue_create(16);
    pthread_t threads[THREADS];
    size_t total = 0;

    for (int i = 0; i < THREADS; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, pop_until_closed, queue), 0);
    for (int64_t seq = 1; seq <= JOBS; seq++) {
        struct vor_job *job = new_job();

        while (vor_queue_reserve(queue) == VOR_FULL)
            sched_yield();
        vor_queue_push(queue, job, seq);
        vor_job_release(job);
    }
    while (vor_queue_depth(queue) > 0)
        sched_yield();
    vor_queue_close(queue);
    for (int i = 0; i < THREADS; i++) {
        void *count;

        pthread_join(threads[i], &count);
        total += (size_t)count;
    }
    ck_assert_uint_eq(total, JOBS);
    vor_queue_destroy(queue);
}
END_TEST

START_TEST(a_closed_queue_hands_out_and_books_nothing)
{
    struct vor_queue *queue = vor_queue_create(2);

    enqueue(queue, 1);
    ck_assert_int_eq(vor_queue_reserve(queue), VOR_DONE);
    vor_queue_close(queue);
    ck_assert_int_eq(vor_queue_reserve(queue), VOR_DRAINING);
    ck_assert_ptr_null(vor_queue_pop(queue));
    vor_queue_destroy(queue);
}
END_TEST

void vt_suite(Suite *suite)
{
    vt_add_loop(suite, the_queue_agrees_with_a_sorted_list, 6);
    vt_add(suite, tenants_take_turns);
    vt_add_loop(suite, positions_come_true_and_nobody_has_three_turns_between_two_of_another, 6);
    vt_add(suite, a_booked_place_counts_until_it_is_given_back);
    vt_add(suite, a_full_queue_takes_the_next_job_once_one_left);
    vt_add(suite, jobs_of_a_former_run_fit_beyond_the_bound);
    vt_add(suite, every_job_is_popped_exactly_once_by_several_threads);
    vt_add(suite, a_closed_queue_hands_out_and_books_nothing);
}
