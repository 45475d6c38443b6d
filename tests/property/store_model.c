/* Property: whatever is done in whatever order, reopening included, the store and an array that
 * follows the same rules agree. */
#include "server/store/store.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <stdio.h>
#include <string.h>

enum { JOBS = 24, STEPS = 150, SEEDS = 12, KEYS = 5 };

struct model_job {
    int known; /* inserted and not removed */
    struct vor_uuid id;
    int64_t seq;
    enum vor_job_status status;
    uint32_t attempt;
    int alone;
    int expired;
    int64_t finished, expires;
    uint64_t kept, held;
    unsigned key; /* 1 .. KEYS; 0 for none */
};

struct model {
    uint64_t seed, draw;
    int64_t now;
    struct vor_store *store;
    struct model_job jobs[JOBS];
    size_t count;
};

static unsigned pick(struct model *model, unsigned bound)
{
    return (unsigned)(vt_unit(model->seed, model->draw++) * bound);
}

static int is_over(const struct model_job *job)
{
    return vor_job_status_over(job->status);
}

static struct vor_job_key key_of(unsigned key)
{
    struct vor_job_key out = {.principal = ""};

    if (key > 0)
        (void)snprintf(out.text, sizeof out.text, "key-%u", key);
    return out;
}

/* The job that has a key, NULL when it is free. */
static struct model_job *holder_of(struct model *model, unsigned key)
{
    for (size_t i = 0; i < model->count; i++)
        if (model->jobs[i].known && model->jobs[i].key == key)
            return &model->jobs[i];
    return NULL;
}

/* What the jobs have together; all are one principal's. */
static struct vor_ledger sum_of(const struct model *model)
{
    struct vor_ledger sum = {.jobs = 0};

    for (size_t i = 0; i < model->count; i++) {
        const struct model_job *job = &model->jobs[i];

        sum.jobs += job->known && !is_over(job);
        sum.bytes += job->known ? job->kept + job->held : 0;
    }
    return sum;
}

static void do_insert(struct model *model)
{
    struct model_job *job = &model->jobs[model->count];
    struct vor_job_view row = vt_row(10);
    unsigned key = pick(model, KEYS + 1);
    struct vor_ledger ledger = sum_of(model);
    int is_over;

    if (model->count == JOBS)
        return;
    row.key = key_of(key);
    row.kept = pick(model, 4) * 100;
    ledger.jobs_max = pick(model, 2) * pick(model, JOBS);
    ledger.bytes_max = pick(model, 2) * pick(model, 20) * 100;
    is_over = !vor_ledger_fits(&ledger, row.kept);
    if (!is_over && key > 0 && holder_of(model, key) != NULL) {
        vt_assert_fails(VOR_E_IO, vor_store_insert(model->store, &row, &ledger, &vt_err));
        return;
    }
    vt_assert_ok(vor_store_insert(model->store, &row, &ledger, &vt_err));
    ck_assert_int_eq(ledger.is_over, is_over);
    if (is_over)
        return;
    *job = (struct model_job){.known = 1,
                              .id = row.id,
                              .seq = row.seq,
                              .status = VOR_JOB_ACCEPTED,
                              .kept = row.kept,
                              .key = key};
    model->count++;
}

/* All jobs are one principal's: they leave in the order of acceptance. */
static void do_claim(struct model *model)
{
    const struct vor_claim claim = {VT_OWNER, model->now, UINT64_MAX, 1, {"", 0}};
    struct model_job *job = model->jobs, *end = model->jobs + model->count;
    struct vor_job_view row;
    int found;

    while (job < end && !(job->known && job->status == VOR_JOB_ACCEPTED))
        job++;
    vt_assert_ok(vor_store_claim_next(model->store, &claim, &row, &found, &vt_err));
    ck_assert_int_eq(found, job < end);
    if (!found)
        return;
    job->status = VOR_JOB_RUNNING;
    ck_assert_str_eq(row.id.text, job->id.text);
    ck_assert_uint_eq(row.attempt, ++job->attempt);
}

static void do_finish(struct model *model, struct model_job *job)
{
    static const enum vor_job_status ends[] = {VOR_JOB_SUCCESSFUL, VOR_JOB_FAILED,
                                               VOR_JOB_DISMISSED};
    struct vor_job_view row = vt_row(10);
    uint32_t attempt = pick(model, 4);
    int expected =
        job->known &&
        (attempt == 0 ? !is_over(job) : job->status == VOR_JOB_RUNNING && job->attempt == attempt);
    int changed;

    row.id = job->id;
    row.status = ends[pick(model, 3)];
    row.attempt = job->attempt;
    row.kept = row.status == VOR_JOB_DISMISSED ? 0 : job->kept;
    row.output[0].bytes = pick(model, 5) * 10;
    row.finished = model->now;
    row.expires = model->now + 1 + pick(model, 40);
    vt_assert_ok(vor_store_finish(model->store, &row, attempt > 0 ? VT_LEASE(attempt) : NULL, NULL,
                                  &changed, &vt_err));
    ck_assert_int_eq(changed, expected);
    if (!expected)
        return;
    job->status = row.status;
    job->kept = row.kept;
    job->held = row.status == VOR_JOB_SUCCESSFUL ? row.output[0].bytes : 0;
    job->finished = row.finished;
    job->expires = row.expires;
}

static void do_release(struct model *model, struct model_job *job)
{
    uint32_t attempt = 1 + pick(model, 3);
    int expected = job->known && job->status == VOR_JOB_RUNNING && job->attempt == attempt;
    struct vor_hand_back back = {.lease = *VT_LEASE(attempt), .now_ms = model->now};

    vt_assert_ok(vor_store_hand_back(model->store, &job->id, &back, &vt_err));
    ck_assert_int_eq(back.changed, expected);
    if (expected)
        job->status = VOR_JOB_ACCEPTED;
}

static void do_remove(struct model *model, struct model_job *job)
{
    int expected = job->known && is_over(job), changed;

    vt_assert_ok(vor_store_remove(model->store, &job->id, &changed, &vt_err));
    ck_assert_int_eq(changed, expected);
    if (expected)
        job->known = 0;
}

static void do_expire(struct model *model)
{
    struct vor_evicted expired[JOBS];
    struct vor_evictions evictions = {.job = expired, .max = JOBS};
    size_t expected = 0;

    vt_assert_ok(vor_store_evict(model->store, VOR_EVICT_EXPIRED, model->now, &evictions, &vt_err));
    for (size_t i = 0; i < model->count; i++) {
        struct model_job *job = &model->jobs[i];

        if (!job->known || !is_over(job) || job->expires > model->now)
            continue;
        expected += !job->expired;
        job->expired = 1;
        job->kept = job->held = 0;
        job->key = 0;
        if (2 * job->expires - job->finished <= model->now)
            job->known = 0;
    }
    ck_assert_uint_eq(evictions.count, expected);
}

/* The job that is given up first: of those that are over and keep something, the one that ended
 * first. */
static struct model_job *first_to_go(struct model *model)
{
    struct model_job *first = NULL;

    for (size_t i = 0; i < model->count; i++) {
        struct model_job *job = &model->jobs[i];

        if (job->known && is_over(job) && job->kept > 0 &&
            (first == NULL || job->finished < first->finished))
            first = job;
    }
    return first;
}

static void do_shed(struct model *model)
{
    uint64_t quota = pick(model, 20) * 100, kept = 0;
    struct vor_evicted shed[JOBS];
    struct vor_evictions evictions = {.job = shed, .max = JOBS};
    struct model_job *job;
    size_t expected = 0;

    for (size_t i = 0; i < model->count; i++)
        kept += model->jobs[i].known ? model->jobs[i].kept : 0;
    vt_assert_ok(
        vor_store_evict(model->store, VOR_EVICT_UPLOADS, (int64_t)quota, &evictions, &vt_err));
    for (; kept > quota && (job = first_to_go(model)) != NULL; expected++) {
        size_t i = 0;

        while (i < evictions.count && strcmp(shed[i].id.text, job->id.text) != 0)
            i++;
        ck_assert_uint_lt(i, evictions.count);
        kept -= job->kept;
        job->kept = 0;
    }
    ck_assert_uint_eq(evictions.count, expected);
}

static void do_crash(struct model *model, const char *dir)
{
    uint64_t recovered, requeued = 0;

    vor_store_close(model->store);
    model->store = vt_dir_store(dir);
    vt_assert_ok(vor_store_reap(model->store, "y", 1, model->now, &recovered, &vt_err));
    for (size_t i = 0; i < model->count; i++) {
        struct model_job *job = &model->jobs[i];

        if (!job->known || job->status != VOR_JOB_RUNNING)
            continue;
        job->status = VOR_JOB_ACCEPTED;
        job->alone = 1;
        requeued++;
    }
    ck_assert_uint_eq(recovered, requeued);
}

/* The rows of a list must be the model's, from the newest on. */
struct expectation {
    struct model *model;
    size_t at; /* below it, the next row is looked for */
};

static struct model_job *next_listed(struct expectation *expectation)
{
    while (expectation->at > 0) {
        struct model_job *job = &expectation->model->jobs[--expectation->at];

        if (job->known && !job->expired)
            return job;
    }
    return NULL;
}

static int compare_row(void *ctx, const struct vor_job_view *row)
{
    struct model_job *job = next_listed(ctx);
    uint32_t attempt;

    ck_assert_ptr_nonnull(job);
    attempt = job->attempt + (job->status == VOR_JOB_ACCEPTED);
    ck_assert_str_eq(row->id.text, job->id.text);
    ck_assert_int_eq(row->seq, job->seq);
    ck_assert_int_eq(row->status, job->status);
    ck_assert_uint_eq(row->attempt, attempt > 0 ? attempt : 1);
    ck_assert_int_eq(row->alone, job->alone);
    ck_assert_int_eq(row->finished, job->finished);
    ck_assert_int_eq(row->expires, job->expires);
    ck_assert_uint_eq(row->kept, job->kept);
    ck_assert_str_eq(row->key.text, key_of(job->key).text);
    return 1;
}

static void compare_keys(struct model *model)
{
    for (unsigned key = 1; key <= KEYS; key++) {
        struct vor_job_key wanted = key_of(key), foreign = wanted;
        struct model_job *job = holder_of(model, key);
        struct vor_job_view row;
        int found;

        vt_assert_ok(vor_store_find_key(model->store, &wanted, &row, &found, &vt_err));
        ck_assert_int_eq(found, job != NULL);
        if (job != NULL)
            ck_assert_str_eq(row.id.text, job->id.text);
        strcpy(foreign.principal, "somebody else");
        vt_assert_ok(vor_store_find_key(model->store, &foreign, &row, &found, &vt_err));
        ck_assert(!found);
    }
}

static void compare_all(struct model *model)
{
    struct expectation expectation = {model, model->count};
    struct vor_job_filter filter = {.limit = 10000};
    struct vor_ledger ledger, sum = sum_of(model);

    vt_assert_ok(vor_store_ledger(model->store, "", &ledger, &vt_err));
    ck_assert_uint_eq(ledger.jobs, sum.jobs);
    ck_assert_uint_eq(ledger.bytes, sum.bytes);
    vt_assert_ok(vor_store_list(model->store, &filter, compare_row, &expectation, &vt_err));
    ck_assert_ptr_null(next_listed(&expectation));
    compare_keys(model);
    for (size_t i = 0; i < model->count; i++) {
        struct vor_job_view row;
        int found;

        vt_assert_ok(vor_store_get(model->store, &model->jobs[i].id, NULL, &row, &found, &vt_err));
        ck_assert_int_eq(found, model->jobs[i].known);
        if (found)
            ck_assert_int_eq(row.expired, model->jobs[i].expired);
    }
}

static void step(struct model *model, const char *dir)
{
    unsigned action = pick(model, 22);
    struct model_job *job = &model->jobs[pick(model, (unsigned)model->count)];

    model->now += pick(model, 4);
    if (action < 4)
        do_insert(model);
    else if (action < 9)
        do_claim(model);
    else if (action < 13)
        do_finish(model, job);
    else if (action < 15)
        do_release(model, job);
    else if (action < 16)
        do_remove(model, job);
    else if (action < 18)
        do_expire(model);
    else if (action < 20)
        do_shed(model);
    else
        do_crash(model, dir);
}

VT_TEST_LOOP(the_store_agrees_with_its_model, SEEDS)
{
    const char *dir = vt_dir_make();
    struct model model = {.seed = (uint64_t)_i, .now = 1000};

    model.store = vt_dir_store(dir);
    do_insert(&model);
    for (int i = 0; i < STEPS; i++) {
        step(&model, dir);
        if (i % 10 == 0)
            compare_all(&model);
    }
    compare_all(&model);
    vor_store_close(model.store);
}
