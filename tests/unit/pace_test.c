/* How far a run is: iterations and polish by their counts, the time left by their pace. */
#include "server/jobs/pace.h"
#include "tests/support/vt.h"

static struct vor_record at(uint32_t iteration, uint32_t polish, double seconds)
{
    return (struct vor_record){.iteration = iteration, .polish = polish, .seconds = seconds};
}

static struct vor_spec request(double iterations, double polish)
{
    struct vor_spec spec;

    vor_spec_init(&spec);
    vt_assert_ok(vor_spec_set_number(&spec, "iterations", iterations, &vt_err));
    vt_assert_ok(vor_spec_set_number(&spec, "polish", polish, &vt_err));
    return spec;
}

static double done(const struct vor_spec *spec, struct vor_record record)
{
    return vor_pace_done(spec, &record);
}

static double left(const struct vor_spec *spec, struct vor_record first, struct vor_record record)
{
    return vor_pace_left(spec, &first, &record);
}

START_TEST(the_defaults_are_those_of_the_table_and_the_engine)
{
    struct vor_spec spec;

    vor_spec_init(&spec);
    ck_assert_uint_eq(vor_spec_iterations(&spec), 12);
    ck_assert(vor_pace_polish(&spec) == vor_parameter_info(VOR_PARAM_POLISH)->fallback);
    ck_assert_uint_gt(vor_pace_polish(&spec), 0);
    vt_assert_ok(vor_spec_set_number(&spec, "polish", 1, &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 12);
    vt_assert_ok(vor_spec_set_number(&spec, "polish", 0, &vt_err));
    ck_assert_uint_eq(vor_spec_iterations(&spec), 100);
    spec = request(37, 0);
    ck_assert_uint_eq(vor_spec_iterations(&spec), 37);
    spec = request(37, 5);
    ck_assert_uint_eq(vor_spec_iterations(&spec), 37);
    spec = request(0, 0);
    ck_assert_uint_eq(vor_spec_iterations(&spec), 0);
    ck_assert_uint_eq(vor_pace_polish(&spec), 0);
}
END_TEST

START_TEST(iterations_and_steps_count_alike)
{
    struct vor_spec spec = request(30, 70);

    ck_assert_double_eq(done(&spec, at(0, 0, 0)), 0);
    ck_assert_double_eq_tol(done(&spec, at(12, 0, 9)), 0.12, 1e-12);
    ck_assert_double_eq_tol(done(&spec, at(30, 0, 9)), 0.30, 1e-12);
    ck_assert_double_eq_tol(done(&spec, at(30, 7, 9)), 0.37, 1e-12);
    ck_assert_double_eq(done(&spec, at(30, 70, 9)), 1);
    ck_assert_double_eq_tol(done(&spec, at(11, 7, 9)), 0.37, 1e-12); /* the rest did not come */
}
END_TEST

START_TEST(without_a_polish_the_iterations_are_all)
{
    struct vor_spec spec = request(40, 0);

    ck_assert_double_eq_tol(done(&spec, at(10, 0, 1)), 0.25, 1e-12);
    ck_assert_double_eq(done(&spec, at(40, 0, 1)), 1);
    spec = request(0, 50);
    ck_assert_double_eq(done(&spec, at(0, 0, 1)), 0);
    ck_assert_double_eq_tol(done(&spec, at(0, 10, 1)), 0.2, 1e-12);
    spec = request(0, 0);
    ck_assert_double_eq(done(&spec, at(0, 0, 0)), 1);
}
END_TEST

/* What another build sends need not keep to what this one allows. */
START_TEST(more_than_was_allowed_is_all)
{
    struct vor_spec spec = request(10, 10);

    ck_assert_double_eq_tol(done(&spec, at(4000000000, 0, 1)), 0.5, 1e-12);
    ck_assert_double_eq(done(&spec, at(0, 4000000000, 1)), 1);
    ck_assert_double_eq(left(&spec, at(0, 0, 0), at(0, 4000000000, 1)), 0);
}
END_TEST

START_TEST(a_budget_counts_where_more_of_it_is_used_up)
{
    struct vor_spec spec = request(100, 100);

    vt_assert_ok(vor_spec_set_number(&spec, "seconds", 20, &vt_err));
    ck_assert_double_eq_tol(done(&spec, at(10, 0, 15)), 0.75, 1e-12);
    ck_assert_double_eq_tol(done(&spec, at(100, 80, 15)), 0.9, 1e-12);
    ck_assert_double_eq(done(&spec, at(10, 0, 25)), 1);
    ck_assert_double_eq_tol(left(&spec, at(0, 0, 0), at(10, 0, 15)), 5, 1e-12);
    ck_assert_double_eq_tol(left(&spec, at(100, 0, 10), at(100, 90, 19)), 1, 1e-12);
    ck_assert_double_eq(left(&spec, at(0, 0, 0), at(10, 0, 25)), 0);
    vt_assert_ok(vor_spec_set_number(&spec, "seconds", 0, &vt_err));
    ck_assert_double_eq_tol(done(&spec, at(10, 0, 1)), 0.05, 1e-12); /* not by zero */
    ck_assert_double_eq(left(&spec, at(0, 0, 0), at(10, 0, 1)), 0);
}
END_TEST

START_TEST(there_is_no_pace_before_the_second_record)
{
    struct vor_spec spec = request(100, 100);

    ck_assert_double_eq(left(&spec, at(0, 0, 0), at(0, 0, 3)), -1);
    ck_assert_double_eq(left(&spec, at(5, 0, 1), at(5, 0, 1)), -1);
    ck_assert_double_eq_tol(left(&spec, at(0, 0, 2), at(20, 0, 12)), 90, 1e-12);
}
END_TEST

START_TEST(the_polish_has_a_pace_of_its_own)
{
    struct vor_spec spec = request(20, 100);
    struct vor_pace pace = {0};
    struct vor_record records[5] = {at(0, 0, 1), at(10, 0, 21), at(20, 0, 41), at(20, 10, 42),
                                    at(20, 20, 43)};
    static const double wanted[5] = {-1, 220, 200, 9, 8};

    for (int i = 0; i < 5; i++) {
        vor_pace_add(&pace, &records[i]);
        ck_assert_double_eq_tol(vor_pace_left(&spec, &pace.first, &pace.last), wanted[i], 1e-9);
        ck_assert_double_eq(pace.last.seconds, records[i].seconds);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("pace");

    vt_add(suite, the_defaults_are_those_of_the_table_and_the_engine);
    vt_add(suite, iterations_and_steps_count_alike);
    vt_add(suite, without_a_polish_the_iterations_are_all);
    vt_add(suite, more_than_was_allowed_is_all);
    vt_add(suite, a_budget_counts_where_more_of_it_is_used_up);
    vt_add(suite, there_is_no_pace_before_the_second_record);
    vt_add(suite, the_polish_has_a_pace_of_its_own);
    return vt_run(suite);
}
