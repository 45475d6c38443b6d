/* The queue in the store: who is claimed next, and what a place in it is. */
#include "server/store/store.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <stdio.h>
#include <string.h>

static void dismiss(struct vor_store *store, struct vor_job_view row)
{
    int changed;

    row.status = VOR_JOB_DISMISSED;
    row.finished = row.expires = 1;
    vt_assert_ok(vor_store_finish(store, &row, NULL, NULL, &changed, &vt_err));
    ck_assert(changed);
}

static void hand_back(struct vor_store *store, const struct vor_uuid *id)
{
    struct vor_hand_back back = {.lease = {"x", 1}, .now_ms = 1};

    vt_assert_ok(vor_store_hand_back(store, id, &back, &vt_err));
    ck_assert(back.changed);
}

static struct vor_job_view insert_of(struct vor_store *store, const char *tenant, size_t length)
{
    struct vor_job_view row = vt_row(10);

    (void)snprintf(row.key.principal, sizeof row.key.principal, "%.*s", (int)length, tenant);
    row.decoded = 7;
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    return row;
}

/* The first letter of whose job is claimed; 0 when none waits. */
static char claim_letter(struct vor_store *store)
{
    const struct vor_claim claim = {"x", 1, UINT64_MAX, 1, {"", 0}};
    struct vor_job_view row;
    int found;

    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    return found ? row.key.principal[0] : '\0';
}

/* Vector: letters are jobs that come, a dot claims the next one; whose that is, is told below. */
VT_TEST_LOOP(tenants_take_turns, 9)
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
        {"aaa...bba...", "aaabba"}, /* but has had the round that goes on */
        {"bc.a.a.a....", "bcaaa"},  /* who has had his job of the round waits for the others */
    };
    struct vor_store *store = vt_dir_store(vt_dir_make());
    char out[16] = "";
    size_t at = 0;

    for (const char *step = vectors[_i].steps; *step != '\0'; step++) {
        if (*step != '.')
            (void)insert_of(store, step, 1);
        else
            out[at++] = claim_letter(store);
    }
    ck_assert_str_eq(out, vectors[_i].out);
    vor_store_close(store);
}

/* Property: whatever tenants come and are dismissed, each one's jobs leave in order, a position is
 * told as it comes out when nobody else comes, and between two jobs of a tenant who waits, and who
 * gave up no turn, no other has three. A job that is handed back keeps its place. */
VT_TEST_LOOP(positions_come_true_and_nobody_has_three_turns_between_two_of_another, 4)
{
    enum { TENANTS = 5, JOBS = 70 };
    struct vor_store *store = vt_dir_store(vt_dir_make());
    struct vor_job_view rows[JOBS];
    struct vor_waiting waiting;
    long told[JOBS];
    int since[TENANTS][TENANTS] = {{0}}; /* jobs of the second since the last of the first */
    int waits[TENANTS] = {0}, gone = 0;
    char letter;

    for (int i = 0; i < JOBS; i++) {
        int tenant = (int)(vt_unit((uint64_t)_i, (uint64_t)i) * TENANTS);

        rows[i] = insert_of(store, &"abcde"[tenant], 1);
        waits[tenant]++;
        if (i % 7 == 6)
            waits[claim_letter(store) - 'a']--;
        if (_i % 2 == 0 || i % 10 != 9 ||
            vt_stored(store, &rows[i - 5].id).status != VOR_JOB_ACCEPTED)
            continue;
        dismiss(store, rows[i - 5]);
        waits[rows[i - 5].key.principal[0] - 'a']--;
        gone++;
    }
    for (int i = 0; i < JOBS; i++)
        told[i] = vt_stored(store, &rows[i].id).queue_position;
    vt_assert_ok(vor_store_waiting(store, &waiting, &vt_err));
    ck_assert_uint_eq(waiting.jobs, (size_t)(JOBS - JOBS / 7 - gone));
    ck_assert_uint_eq(waiting.decoded, 7 * waiting.jobs);
    for (long left = 0; (letter = claim_letter(store)) != '\0'; left++) {
        int tenant = letter - 'a', next = 0;

        while (next < JOBS && told[next] != left)
            next++;
        ck_assert_int_eq(rows[next].key.principal[0], letter);
        hand_back(store, &rows[next].id);
        ck_assert_int_eq(vt_stored(store, &rows[next].id).queue_position, 0);
        ck_assert_int_eq(claim_letter(store), letter);
        waits[tenant]--;
        for (int other = 0; other < TENANTS; other++) {
            since[tenant][other] = 0;
            since[other][tenant] += other != tenant && waits[other] > 0;
            ck_assert(gone > 0 || since[other][tenant] <= 2);
        }
    }
    vor_store_close(store);
}

VT_TEST(a_place_in_a_long_queue_is_counted_right)
{
    enum { JOBS = 600 };
    struct vor_store *store = vt_dir_store(vt_dir_make());
    struct vor_uuid ids[JOBS];

    for (int i = 0; i < JOBS; i++)
        ids[i] = insert_of(store, "", 0).id;
    for (int claimed = 0; claimed < 3; claimed++) {
        for (int i = claimed; i < JOBS; i += 37)
            ck_assert_int_eq(vt_stored(store, &ids[i]).queue_position, i - claimed);
        ck_assert_uint_eq(vt_claim(store, &ids[claimed]), 1);
        ck_assert_int_eq(vt_stored(store, &ids[claimed]).queue_position, -1);
    }
    vor_store_close(store);
}

VT_TEST(the_next_job_is_claimed_once_it_may_and_none_before_it)
{
    struct vor_store *store = vt_dir_store(vt_dir_make());
    struct vor_job_view rows[2] = {vt_row(10), vt_row(10)}, row;
    struct vor_claim claim = {"me", 1, 99, 0, {"", 0}};
    uint64_t reaped;
    int found;

    rows[0].memory = 100;
    rows[1].memory = 1;
    for (int i = 0; i < 2; i++)
        vt_assert_ok(vor_store_insert(store, &rows[i], NULL, &vt_err));
    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(!found); /* the small one does not overtake it */
    claim.memory = 100;
    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(found && strcmp(row.id.text, rows[0].id.text) == 0 && row.memory == 100);
    vt_assert_ok(vor_store_reap(store, "me", 1, 1, &reaped, &vt_err));
    ck_assert_uint_eq(reaped, 0); /* what runs in this life */
    vt_assert_ok(vor_store_reap(store, "the next one", 1, 1, &reaped, &vt_err));
    ck_assert_uint_eq(reaped, 1);
    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(!found); /* it is to be alone */
    claim.may_be_alone = 1;
    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(found && row.alone && row.attempt == 2);
    vor_store_close(store);
}

static const int64_t hour_ms = 3600000;

/* Daemons of two builds at once, as while they are upgraded. */
VT_TEST(a_job_waits_for_its_own_engine_while_there_is_one_and_for_no_older_release)
{
    struct vor_store *store = vt_dir_store(vt_dir_make());
    struct vor_job_view row = vt_row(1);
    struct vor_renewal renewal = {"first", {"a", 2}, hour_ms, NULL, 0, 0};
    struct vor_claim claim = {"second", 1, UINT64_MAX, 1, {"b", 3}};
    int found;

    row.build = renewal.build;
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    vt_assert_ok(vor_store_renew(store, &renewal, &vt_err));
    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(!found);
    renewal.lease_ms = -1;
    vt_assert_ok(vor_store_renew(store, &renewal, &vt_err));
    claim.build.release = 1;
    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(!found);
    claim.build.release = 2;
    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(found && row.build.release == 2 && strcmp(row.build.engine, "a") == 0);
    vor_store_close(store);
}

/* A worker that was stopped past its lease and goes on. */
VT_TEST(an_owner_whose_lease_was_reaped_changes_nothing_and_is_told)
{
    struct vor_store *store = vt_dir_store(vt_dir_make());
    struct vor_job_view rows[2] = {insert_of(store, "", 0), insert_of(store, "", 0)}, row;
    const struct vor_lease late = {"late", 1}, other = {"other", 2};
    struct vor_claim claim = {"late", 10, UINT64_MAX, 1, {"", 0}};
    struct vor_leased left[2];
    struct vor_renewal renewal = {"late", {"", 0}, hour_ms, left, 2, 0};
    struct vor_hand_back back = {.lease = late, .now_ms = 400};
    const struct vor_store_ending ending = {"{}", {0}};
    char events[32];
    uint64_t reaped;
    int found, changed;

    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(vt_append(store, rows[0], 10, &late, 2));
    vt_assert_ok(vor_store_renew(store, &renewal, &vt_err));
    vt_assert_ok(vor_store_reap(store, "other", 0, 150, &reaped, &vt_err));
    ck_assert(reaped == 0 && !left[0].stops); /* the lease has not ended */
    renewal.lease_ms = -1;
    vt_assert_ok(vor_store_renew(store, &renewal, &vt_err));
    vt_assert_ok(vor_store_reap(store, "late", 1, 150, &reaped, &vt_err));
    ck_assert_uint_eq(reaped, 0); /* his own are not his to reap */
    vt_assert_ok(vor_store_reap(store, "other", 0, 150, &reaped, &vt_err));
    ck_assert_uint_eq(reaped, 1);
    claim.owner = "other";
    vt_assert_ok(vor_store_claim_next(store, &claim, &row, &found, &vt_err));
    ck_assert(found && row.attempt == 2);
    ck_assert_str_eq(row.id.text, rows[0].id.text);
    claim.owner = "late";
    vt_assert_ok(vor_store_claim_next(store, &claim, &rows[1], &found, &vt_err));
    for (uint32_t attempt = 1; attempt <= 2; attempt++) { /* the owner alone is wrong, too */
        const struct vor_lease wrong = {"late", attempt};

        row.status = VOR_JOB_SUCCESSFUL;
        vt_assert_ok(vor_store_finish(store, &row, &wrong, &ending, &changed, &vt_err));
        ck_assert(!changed && !vt_append(store, rows[0], 90, &wrong, 3));
        back.lease = wrong;
        vt_assert_ok(vor_store_hand_back(store, &rows[0].id, &back, &vt_err));
        ck_assert(!back.changed);
    }
    row = vt_stored(store, &rows[0].id);
    ck_assert(row.status == VOR_JOB_RUNNING && row.attempt == 2 && row.progress == 10);
    renewal.lease_ms = hour_ms;
    vt_assert_ok(vor_store_stop(store, &rows[1].id, &changed, &vt_err));
    vt_assert_ok(vor_store_renew(store, &renewal, &vt_err));
    ck_assert(changed && renewal.count == 1 && left[0].attempt == 1 && left[0].stops);
    ck_assert_str_eq(left[0].id.text, rows[1].id.text);
    vt_assert_ok(vor_store_reap(store, "other", 0, 250, &reaped, &vt_err));
    ck_assert_uint_eq(reaped, 0); /* renewed */
    ck_assert(vt_append(store, rows[0], 0, &other, 1) && vt_append(store, rows[0], 0, &other, 4));
    vt_events(store, &rows[0].id, 1, 0, events);
    ck_assert_str_eq(events, "");                   /* they went when the second attempt began */
    for (uint32_t after = 0; after <= 4; after++) { /* each once, in order, wherever one begins */
        static const char *const wanted[] = {"1:b 4:e ", "4:e ", "4:e ", "4:e ", ""};

        vt_events(store, &rows[0].id, 2, after, events);
        ck_assert_str_eq(events, wanted[after]);
    }
    dismiss(store, rows[0]);
    vt_assert_ok(vor_store_remove(store, &rows[0].id, &changed, &vt_err));
    vt_events(store, &rows[0].id, 2, 0, events);
    ck_assert_str_eq(events, "");
    vor_store_close(store);
}
