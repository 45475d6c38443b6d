/* usage: VT_STORE=postgres VT_POSTGRES="host=... port=... user=..." VT_CHURN=JOBS CK_FORK=no churn:
 * jobs are accepted, claimed and finished in the store, one after the other, while figures.pl holds
 * a transaction open. Prints milliseconds of claims: median, 99 %, most. */
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include "server/base/clock.h"

#include <stdio.h>
#include <stdlib.h>

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

VT_TEST(jobs_are_claimed_beside_an_old_transaction)
{
    static const char document[] = "{\"a\":1}";
    const struct vor_store_ending ending = {document, {2, (const uint8_t *)"events", 6}};
    const struct vor_lease lease = {"me", 1};
    size_t count = strtoul(getenv("VT_CHURN"), NULL, 10);
    double *ms = calloc(count, sizeof *ms);
    struct vor_store *store = vt_dir_store("/churn");
    struct vor_leased leased;
    struct vor_renewal renewal = {.owner = "me", .lease_ms = 3600000, .job = &leased, .max = 1};

    vt_assert_ok(vor_store_renew(store, &renewal, &vt_err)); /* a daemon that looks on takes none */
    for (size_t i = 0; i < count; i++) {
        struct vor_job_view row = vt_row(1);
        const struct vor_claim claim = {"me", 1, UINT64_MAX, 1, {"", 0}};
        double began;
        int found = 0, changed = 0;

        vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
        began = vor_clock_seconds();
        vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
        ms[i] = 1e3 * (vor_clock_seconds() - began);
        row.status = VOR_JOB_SUCCESSFUL;
        row.finished = 2;
        vt_assert_ok(vor_store_finish(store, &row, &lease, &ending, &changed, &vt_err));
        ck_assert(found && changed);
    }
    qsort(ms, count, sizeof *ms, compare);
    printf("# claims, ms: median %.2f, 99 %% %.2f, most %.2f\n", ms[count / 2],
           ms[count * 99 / 100], ms[count - 1]);
    vor_store_close(store);
    free(ms);
}
