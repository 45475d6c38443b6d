/* How far a run is: the steps of its stages by their counts, the time left by their eta. */
#include "server/jobs/eta.h"
#include "tests/support/vt.h"

/* Costs are those of eta.c, for each point: 5 for the first iteration, 2.5 for the others and for
 * steps of a stage that it does not know, 1.2 for a step of the polish, 5.5 for the end of a run.
 */

/* Rows of the table for a run of three stages; the last stands for what another method has. */
enum { FIRST = VOR_RUN_STAGE_ITERATE, SECOND = VOR_RUN_STAGE_POLISH, THIRD = VOR_RUN_STAGE_COUNT };

static struct vor_record at(int stage, uint32_t step, uint32_t of, uint32_t ahead, double seconds)
{
    return (struct vor_record){.stage = (enum vor_run_stage)stage,
                               .step = step,
                               .of = of,
                               .ahead = ahead,
                               .seconds = seconds};
}

/* A request with a budget of so many seconds; without one below 0. */
static struct vor_spec request(double seconds)
{
    struct vor_spec spec;

    vor_spec_init(&spec);
    if (seconds >= 0)
        vt_assert_ok(vor_spec_set_number(&spec, "seconds", seconds, &vt_err));
    return spec;
}

/* The eta of a run of these records, of which the first is 0 steps of FIRST. */
static struct vor_eta pace_of(const struct vor_record *records, size_t count)
{
    struct vor_eta eta = {0};

    for (size_t i = 0; i < count; i++)
        vor_eta_add(&eta, &records[i]);
    return eta;
}

static double done_after(struct vor_record first, struct vor_record last, double budget)
{
    struct vor_eta eta = pace_of((struct vor_record[]){first, last}, 2);
    struct vor_spec spec = request(budget);

    return vor_eta_done(&eta, &spec);
}

static double left_after(struct vor_record first, struct vor_record last, double budget)
{
    struct vor_eta eta = pace_of((struct vor_record[]){first, last}, 2);
    struct vor_spec spec = request(budget);

    return vor_eta_left(&eta, &spec);
}

VT_TEST(steps_of_all_stages_count_alike)
{
    struct vor_record first = at(FIRST, 0, 30, 70, 0);

    ck_assert_double_eq(done_after(first, first, -1), 0);
    ck_assert_double_eq_tol(done_after(first, at(FIRST, 12, 30, 70, 9), -1), 0.12, 1e-12);
    ck_assert_double_eq_tol(done_after(first, at(FIRST, 30, 30, 70, 9), -1), 0.30, 1e-12);
    ck_assert_double_eq_tol(done_after(first, at(SECOND, 7, 70, 0, 9), -1), 0.37, 1e-12);
    ck_assert_double_eq(done_after(first, at(SECOND, 70, 70, 0, 9), -1), 1);
}

/* Whoever follows a run from its middle counts what is ahead and what its stage has behind it. */
VT_TEST(a_run_may_be_seen_from_its_middle)
{
    ck_assert_double_eq_tol(done_after(at(FIRST, 8, 12, 88, 1), at(FIRST, 10, 12, 88, 2), -1), 0.1,
                            1e-12);
    ck_assert_double_eq_tol(done_after(at(SECOND, 20, 80, 0, 1), at(SECOND, 60, 80, 0, 2), -1),
                            0.75, 1e-12);
    ck_assert_double_eq_tol(left_after(at(SECOND, 20, 80, 0, 1), at(SECOND, 60, 80, 0, 2), -1),
                            (20 * 1.2 + 5.5) / (40 * 1.2), 1e-12);
}

/* What another build sends need not keep to what it said. */
VT_TEST(more_than_was_allowed_is_all)
{
    struct vor_record first = at(FIRST, 0, 10, 10, 0);

    ck_assert_double_eq_tol(done_after(first, at(FIRST, 4000000000, 10, 10, 1), -1), 0.5, 1e-12);
    ck_assert_double_eq(done_after(first, at(SECOND, 4000000000, 10, 0, 1), -1), 1);
    ck_assert_double_le(left_after(first, at(SECOND, 4000000000, 10, 0, 1), -1), 1e-8);
    ck_assert_double_eq_tol(done_after(first, at(FIRST, 20, 100, 100, 1), -1), 0.1, 1e-12);
}

VT_TEST(a_budget_counts_where_more_of_it_is_used_up)
{
    struct vor_record first = at(FIRST, 0, 100, 100, 0);

    ck_assert_double_eq_tol(done_after(first, at(FIRST, 10, 100, 100, 15), 20), 0.75, 1e-12);
    ck_assert_double_eq_tol(done_after(first, at(SECOND, 80, 100, 0, 15), 20), 0.9, 1e-12);
    ck_assert_double_eq(done_after(first, at(FIRST, 10, 100, 100, 25), 20), 1);
    ck_assert_double_eq_tol(left_after(first, at(FIRST, 10, 100, 100, 15), 20), 5, 1e-12);
    ck_assert_double_eq_tol(
        left_after(at(FIRST, 100, 100, 100, 10), at(SECOND, 90, 100, 0, 19), 20), 1, 1e-12);
    ck_assert_double_eq(left_after(first, at(FIRST, 10, 100, 100, 25), 20), 0);
    ck_assert_double_eq_tol(done_after(first, at(FIRST, 10, 100, 100, 1), 0), 0.05,
                            1e-12); /* not by zero */
    ck_assert_double_eq(left_after(first, at(FIRST, 10, 100, 100, 1), 0), 0);
}

VT_TEST(there_is_no_pace_before_the_second_record)
{
    struct vor_eta eta = {0};
    struct vor_spec spec = request(-1);

    ck_assert_double_eq(vor_eta_left(&eta, &spec), -1);
    ck_assert_double_eq(vor_eta_done(&eta, &spec), 0);
    ck_assert_double_eq(left_after(at(FIRST, 0, 100, 100, 3), at(FIRST, 0, 100, 100, 3), -1), -1);
    ck_assert_double_eq(left_after(at(FIRST, 5, 100, 100, 1), at(FIRST, 5, 100, 100, 1), -1), -1);
    ck_assert_double_eq_tol(left_after(at(FIRST, 0, 100, 100, 2), at(FIRST, 20, 100, 100, 12), -1),
                            10 * (21 * 2.5 + 100 * 1.2 + 5.5) / (5 + 19 * 2.5), 1e-12);
}

VT_TEST(each_of_three_stages_has_a_pace_of_its_own)
{
    const struct vor_record records[] = {
        at(FIRST, 0, 20, 150, 1),    at(FIRST, 10, 20, 150, 21),  at(FIRST, 20, 20, 150, 41),
        at(SECOND, 10, 100, 50, 42), at(SECOND, 90, 100, 50, 50), at(SECOND, 100, 100, 50, 51),
        at(THIRD, 1, 50, 0, 61),     at(THIRD, 2, 50, 0, 71),     at(THIRD, 50, 50, 0, 551)};
    static const double left[] = {-1,
                                  20 * (10 * 2.5 + 150 * 1.2 + 5.5) / (5 + 9 * 2.5),
                                  40 * (150 * 1.2 + 5.5) / (5 + 19 * 2.5),
                                  1 * (140 * 1.2 + 5.5) / (10 * 1.2),
                                  9 * (60 * 1.2 + 5.5) / (90 * 1.2),
                                  10 * (50 * 1.2 + 5.5) / (100 * 1.2),
                                  490,
                                  480,
                                  0};
    static const double done[] = {0, 10, 20, 30, 110, 120, 121, 122, 170};
    struct vor_spec spec = request(-1);

    for (size_t i = 0; i < sizeof records / sizeof records[0]; i++) {
        struct vor_eta eta = pace_of(records, i + 1);

        ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), left[i], 1e-9);
        ck_assert_double_eq_tol(vor_eta_done(&eta, &spec), done[i] / 170, 1e-12);
    }
}

/* A stage may tell that it begins, as the first one does. */
VT_TEST(a_stage_that_begins_has_the_pace_of_the_one_before)
{
    const struct vor_record records[] = {at(FIRST, 0, 20, 150, 1),   at(FIRST, 20, 20, 150, 41),
                                         at(SECOND, 0, 100, 50, 45), at(SECOND, 10, 100, 50, 55),
                                         at(THIRD, 0, 50, 0, 150),   at(THIRD, 1, 50, 0, 152)};
    static const double left[] = {-1,
                                  40 * (150 * 1.2 + 5.5) / (5 + 19 * 2.5),
                                  40 * (150 * 1.2 + 5.5) / (5 + 19 * 2.5),
                                  10 * (140 * 1.2 + 5.5) / (10 * 1.2),
                                  10 * (50 * 2.5) / (10 * 1.2),
                                  98};
    struct vor_spec spec = request(-1);

    for (size_t i = 0; i < sizeof records / sizeof records[0]; i++) {
        struct vor_eta eta = pace_of(records, i + 1);

        ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), left[i], 1e-9);
    }
    ck_assert_double_eq(left_after(at(FIRST, 0, 0, 50, 1), at(SECOND, 0, 50, 0, 2), -1), -1);
}

/* A plateau after 8 of 12: the four that did not come are done, and take no time. */
VT_TEST(a_stage_that_ends_early_is_done)
{
    const struct vor_record records[] = {at(FIRST, 0, 12, 100, 1), at(FIRST, 8, 12, 100, 9),
                                         at(SECOND, 10, 100, 0, 10)};
    struct vor_eta eta = pace_of(records, 3);
    struct vor_spec spec = request(-1);

    ck_assert_double_eq_tol(vor_eta_done(&eta, &spec), 22.0 / 112, 1e-12);
    ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), (90 * 1.2 + 5.5) / (10 * 1.2), 1e-12);
}

VT_TEST(without_a_limit_there_is_neither_share_nor_time_left)
{
    const struct vor_record records[] = {at(FIRST, 0, 0, 0, 1), at(FIRST, 8, 0, 0, 9),
                                         at(SECOND, 10, 0, 0, 10)};

    for (size_t count = 2; count <= 3; count++) {
        struct vor_eta eta = pace_of(records, count);
        struct vor_spec spec = request(-1);

        ck_assert_double_eq(vor_eta_done(&eta, &spec), 0);
        ck_assert_double_eq(vor_eta_left(&eta, &spec), -1);
        spec = request(40);
        ck_assert_double_eq_tol(vor_eta_done(&eta, &spec), records[count - 1].seconds / 40, 1e-12);
    }
}

static struct vor_spec request_of(const char *process, const char *points)
{
    struct vor_spec spec;

    vor_spec_preset(&spec, vor_process_find(process));
    if (points != NULL)
        vt_assert_ok(vor_spec_set(&spec, "points", points, &vt_err));
    return spec;
}

/* upsample iterates once and takes 8 steps of the polish. */
VT_TEST(before_the_first_record_the_request_says_how_long)
{
    struct vor_spec spec = request_of("upsample", "120000");
    struct vor_eta eta = {.work = vor_eta_work_of(&spec, 30000, 1)};
    double alone = 0.12 * (10 + 2.0 * 30000 / 120000 + 5 + 12 * 1.2 + 5.5);

    ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), alone, 1e-12);
    eta.work.threads = 3;
    ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), alone / 2.8, 1e-12);
    ck_assert_double_eq(vor_eta_done(&eta, &spec), 0);
    vt_assert_ok(vor_spec_set_number(&spec, "seconds", 0.5, &vt_err));
    ck_assert_double_eq(vor_eta_left(&eta, &spec), 0.5);
}

/* ear: 15 of 30 thousand points are projected in 12 steps, 45 thousand inserted by one thread,
 * however many there are, then 12 steps of the polish; times as the table of eta.c has them. */
VT_TEST(projected_and_inserted_points_count_by_what_they_take)
{
    static const double project = 12 * 15e3 * 2.5e-6, insert = 45e3 * 15e-6,
                        polish = 12 * 60e3 * 3.3e-6, end = 60e3 * 5.5e-6, start = 30e3 * 80e-6;
    struct vor_spec spec = request_of("upsample", "60000");
    struct vor_eta eta;

    vt_assert_ok(vor_spec_set(&spec, "method", "ear", &vt_err));
    for (unsigned threads = 1; threads <= 2; threads++) {
        double gain = threads == 1 ? 1 : 1.9, all = project / gain + insert + polish / gain;
        struct vor_record record = at(VOR_RUN_STAGE_PROJECT, 0, 12, 45000 + 12, start / gain);

        eta = (struct vor_eta){.work = vor_eta_work_of(&spec, 30000, threads)};
        ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), (start + end) / gain + all, 1e-9);
        vor_eta_add(&eta, &record);
        ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), all + end / gain, 1e-9);
        record = at(VOR_RUN_STAGE_PROJECT, 12, 12, 45000 + 12, (start + project) / gain);
        vor_eta_add(&eta, &record);
        ck_assert_double_eq_tol(vor_eta_done(&eta, &spec), project / gain / all, 1e-9);
        record = at(VOR_RUN_STAGE_INSERT, 15000, 45000, 12, record.seconds + insert / 3);
        vor_eta_add(&eta, &record);
        ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), insert * 2 / 3 + (polish + end) / gain,
                                1e-9);
        ck_assert_double_eq_tol(vor_eta_done(&eta, &spec), (project / gain + insert / 3) / all,
                                1e-9);
        record = at(VOR_RUN_STAGE_POLISH, 12, 12, 0, record.seconds + 9);
        vor_eta_add(&eta, &record);
        ck_assert_double_eq_tol(vor_eta_done(&eta, &spec), 1, 1e-12);
    }
}

VT_TEST(without_the_work_nothing_is_known_before_a_step)
{
    struct vor_spec measure = request_of("measure", NULL), spaced = request_of("resample", NULL);

    vt_assert_ok(vor_spec_set_number(&spaced, "spacing", 0.1, &vt_err));
    ck_assert_double_eq(vor_eta_work_of(&measure, 1000, 2).points_out, 0);
    ck_assert_double_eq(vor_eta_work_of(&spaced, 1000, 2).points_out, 0);
}

/* A run that began four times as slowly as usual takes twice as long; so do its polish and its end
 * while iterations are four times as slow. */
VT_TEST(how_slow_one_part_is_tells_half_of_how_slow_others_are)
{
    struct vor_spec spec = request_of("resample", "100000");
    struct vor_eta eta = {.work = vor_eta_work_of(&spec, 500000, 1)};
    struct vor_record record = at(FIRST, 0, 12, 100, 4 * 0.1 * 20);
    double iterations = 0.1 * (5 + 11 * 2.5), others = 0.1 * (100 * 1.2 + 5.5);

    vor_eta_add(&eta, &record);
    ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), 2 * (iterations + others), 1e-9);
    record.step = 1;
    record.seconds += 4 * 0.1 * 5;
    vor_eta_add(&eta, &record);
    ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), 4 * 0.1 * 11 * 2.5 + 2 * others, 1e-9);
    record = at(SECOND, 0, 100, 0, 20);
    vor_eta_add(&eta, &record);
    ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), 2 * others, 1e-9);
    record = at(SECOND, 50, 100, 0, 20 + 3 * 0.1 * 50 * 1.2);
    vor_eta_add(&eta, &record);
    ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), 3 * 0.1 * (50 * 1.2 + 5.5), 1e-9);
}

/* The last 40 steps of the polish on the whole of a dense input cost 2.8 times as much. */
VT_TEST(the_last_steps_on_a_dense_input_take_longer)
{
    static const uint32_t in[] = {1990000, 2000000};
    static const double whole[] = {1, 2.8};

    for (int i = 0; i < 2; i++) {
        struct vor_spec spec = request_of("resample", "100000");
        struct vor_eta eta = {.work = vor_eta_work_of(&spec, in[i], 1)};
        struct vor_record record = at(SECOND, 0, 100, 0, 10);

        vor_eta_add(&eta, &record);
        record = at(SECOND, 60, 100, 0, 10 + 0.1 * 60 * 1.2);
        vor_eta_add(&eta, &record);
        ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), 0.1 * (whole[i] * 40 * 1.2 + 5.5), 1e-9);
        record = at(SECOND, 80, 100, 0, 10 + 0.1 * (60 + whole[i] * 20) * 1.2);
        vor_eta_add(&eta, &record);
        ck_assert_double_eq_tol(vor_eta_left(&eta, &spec), 0.1 * (whole[i] * 20 * 1.2 + 5.5), 1e-9);
    }
}

/* 100 are allowed, 41 are usual; past them a few more are expected, but never more than allowed. */
VT_TEST(iterations_without_a_number_end_where_they_usually_do)
{
    static const uint32_t steps[] = {1, 40, 41, 60, 99, 100};
    static const double more[] = {40, 3, 3, 3, 1, 0};
    struct vor_spec spec = request(-1);

    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        double cost = 5 + (steps[i] - 1) * 2.5;

        ck_assert_double_eq_tol(
            left_after(at(FIRST, 0, 100, 0, 0), at(FIRST, steps[i], 100, 0, cost), -1),
            more[i] * 2.5 + 5.5, 1e-9);
    }
    vt_assert_ok(vor_spec_set_number(&spec, "iterations", 100, &vt_err));
    ck_assert_double_eq_tol(vor_eta_left(&(struct vor_eta){.began = 1,
                                                           .origin = at(FIRST, 0, 100, 0, 0),
                                                           .last = at(FIRST, 1, 100, 0, 5)},
                                         &spec),
                            99 * 2.5 + 5.5, 1e-9);
}
