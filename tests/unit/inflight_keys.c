/* Keys of requests under way: one holder at a time, for as long as it holds it. */
#include "server/jobs/inflight.h"
#include "tests/support/vt.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

static struct vor_job_key key_of(const char *principal, const char *text)
{
    struct vor_job_key key = {.principal = ""};

    strcpy(key.principal, principal);
    strcpy(key.text, text);
    return key;
}

VT_TEST(a_key_has_one_holder_until_it_is_given_back)
{
    struct vor_inflight *inflight = vor_inflight_create();
    struct vor_job_key a = key_of("", "a"), b = key_of("", "b"), foreign = key_of("other", "a");
    struct vor_job_key same = a;

    strcpy(same.fingerprint, "another one");
    ck_assert_int_eq(vor_inflight_begin(inflight, &a), VOR_DONE);
    ck_assert_int_eq(vor_inflight_begin(inflight, &same), VOR_CONFLICT);
    ck_assert_int_eq(vor_inflight_begin(inflight, &b), VOR_DONE);
    ck_assert_int_eq(vor_inflight_begin(inflight, &foreign), VOR_DONE);
    vor_inflight_end(inflight, &a);
    ck_assert_int_eq(vor_inflight_begin(inflight, &same), VOR_DONE);
    ck_assert_int_eq(vor_inflight_begin(inflight, &b), VOR_CONFLICT);
    vor_inflight_destroy(inflight); /* whatever is held */
    vor_inflight_destroy(NULL);
}

struct race {
    struct vor_inflight *inflight;
    atomic_int holders, won;
};

static void *fight(void *arg)
{
    struct vor_job_key key = key_of("", "the one");
    struct race *race = arg;

    for (int i = 0; i < 2000; i++) {
        if (vor_inflight_begin(race->inflight, &key) != VOR_DONE)
            continue;
        ck_assert_int_eq(atomic_fetch_add(&race->holders, 1), 0);
        atomic_fetch_add(&race->won, 1);
        atomic_fetch_sub(&race->holders, 1);
        vor_inflight_end(race->inflight, &key);
    }
    return NULL;
}

VT_TEST(of_many_threads_one_holds_a_key)
{
    enum { THREADS = 4 };
    struct race race = {.inflight = vor_inflight_create()};
    pthread_t threads[THREADS];

    for (int i = 0; i < THREADS; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, fight, &race), 0);
    for (int i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
    ck_assert_int_gt(atomic_load(&race.won), 0);
    vor_inflight_destroy(race.inflight);
}
