/* What the command line shows of a run: the bar of an iteration and of the polish, the sentence at
 * the end. */
#include "server/cli/progress.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static char shown[4096];

/* What was written to file since it was made, as a string. */
static const char *content(FILE *file)
{
    size_t size;

    ck_assert_int_eq(fflush(file), 0);
    rewind(file);
    size = fread(shown, 1, sizeof shown - 1, file);
    shown[size] = '\0';
    return shown;
}

static void make_cli(struct vor_cli *cli, double iterations, double polish)
{
    memset(cli, 0, sizeof *cli);
    cli->option[VOR_OPTION_OUTPUT] = "out.ply";
    vor_spec_init(&cli->spec);
    vt_assert_ok(vor_spec_set_number(&cli->spec, "iterations", iterations, &vt_err));
    vt_assert_ok(vor_spec_set_number(&cli->spec, "polish", polish, &vt_err));
}

/* The bar after `first`, shown or not, and then `second`. */
static const char *bar_of(const struct vor_cli *cli, int columns, struct vor_record first,
                          struct vor_record second)
{
    struct vor_progress progress = {.cli = cli, .columns = columns};
    const char *text;

    vor_progress_record(&progress, &first);
    progress.bar = tmpfile();
    ck_assert_ptr_nonnull(progress.bar);
    vor_progress_record(&progress, &second);
    text = content(progress.bar);
    (void)fclose(progress.bar);
    return text;
}

VT_TEST(a_bar_shows_the_iteration_and_what_is_left_of_all)
{
    struct vor_record first = {.of = 50, .seconds = 1},
                      second = {.step = 20, .of = 50, .delta = 0.25, .seconds = 5};
    struct vor_cli cli;

    make_cli(&cli, 50, 150);
    ck_assert_str_eq(bar_of(&cli, 70, first, second),
                     "\r\x1b[Kiterate   20/50   [####------]  40 %  delta 0.2500  6 s left");
    first.ahead = second.ahead = 150;
    ck_assert_str_eq(bar_of(&cli, 70, first, second),
                     "\r\x1b[Kiterate   20/50   [#---------]  10 %  delta 0.2500  20 s left");
}

VT_TEST(a_bar_does_not_show_limits_that_are_not_known)
{
    struct vor_record first = {.seconds = 1}, second = {.step = 20, .delta = 0.25, .seconds = 5};
    struct vor_cli cli;

    make_cli(&cli, 50, 150);
    ck_assert_str_eq(bar_of(&cli, 65, first, second),
                     "\r\x1b[Kiterate   20 [----------]   0 %  delta 0.2500");
    second.stage = VOR_RUN_STAGE_COUNT; /* of a daemon that has more of them */
    second.of = 40;
    ck_assert_str_eq(bar_of(&cli, 67, first, second),
                     "\r\x1b[Kstep   20/40   [#####-----]  50 %  delta 0.2500  4 s left");
}

VT_TEST(a_bar_shows_the_polish_at_its_own_pace)
{
    struct vor_record first = {.step = 50, .of = 50, .ahead = 150, .seconds = 11};
    struct vor_record second = {
        .stage = VOR_RUN_STAGE_POLISH, .step = 30, .of = 150, .delta = 0.031, .seconds = 14};
    struct vor_cli cli;

    make_cli(&cli, 50, 150);
    ck_assert_str_eq(bar_of(&cli, 69, first, second),
                     "\r\x1b[Kpolish   30/150  [####------]  40 %  delta 0.0310  12 s left");
    second.step = 150;
    ck_assert_str_eq(bar_of(&cli, 69, first, second),
                     "\r\x1b[Kpolish  150/150  [##########] 100 %  delta 0.0310  0 s left");
}

VT_TEST(a_bar_leaves_out_what_a_stage_does_not_know)
{
    struct vor_record first = {.of = 50, .delta = (double)NAN, .seconds = 1},
                      second = {.step = 20, .of = 50, .delta = (double)NAN, .seconds = 5};
    struct vor_cli cli;

    make_cli(&cli, 50, 0);
    ck_assert_str_eq(bar_of(&cli, 70, first, second),
                     "\r\x1b[Kiterate   20/50   [####------]  40 %  6 s left");
}

VT_TEST(a_bar_fits_into_its_line)
{
    struct vor_record first = {.step = 9999, .of = 10000, .ahead = 10000, .seconds = 1};
    struct vor_record second = {
        .stage = VOR_RUN_STAGE_POLISH, .step = 9999, .of = 10000, .delta = 0.4, .seconds = 1e9};
    struct vor_cli cli;

    make_cli(&cli, 10000, 10000);
    for (int columns = 2; columns <= 200; columns++) {
        const char *text = bar_of(&cli, columns, first, second);

        ck_assert_uint_le(strlen(text), strlen("\r\x1b[K") + (size_t)columns - 1);
    }
}

/* A line is drawn ten times a second at most, the first one always. */
VT_TEST(a_bar_is_not_drawn_for_every_record)
{
    struct vor_record record = {.delta = 0.5};
    struct vor_progress progress = {.columns = 80, .bar = tmpfile()};
    struct vor_cli cli;
    size_t drawn = 0;

    make_cli(&cli, 50, 150);
    progress.cli = &cli;
    ck_assert_ptr_nonnull(progress.bar);
    for (int i = 0; i < 20; i++)
        vor_progress_record(&progress, &record);
    for (const char *at = content(progress.bar); (at = strchr(at, '\r')) != NULL; at++)
        drawn++;
    ck_assert_uint_ge(drawn, 1);
    ck_assert_uint_lt(drawn, 20);
    (void)fclose(progress.bar);
}

/* The bar after two events of a daemon. */
static const char *bar_of_events(const char *first, const char *second)
{
    struct vor_progress progress = {.columns = 69};
    struct vor_json *json = vt_json(first);
    struct vor_cli cli;
    const char *text;

    make_cli(&cli, 1, 1);
    progress.cli = &cli;
    vor_progress_event(&progress, json);
    vor_json_free(json);
    progress.bar = tmpfile();
    ck_assert_ptr_nonnull(progress.bar);
    json = vt_json(second);
    vor_progress_event(&progress, json);
    vor_json_free(json);
    text = content(progress.bar);
    (void)fclose(progress.bar);
    return text;
}

VT_TEST(a_bar_follows_a_daemon_that_tells_stages)
{
    ck_assert_str_eq(
        bar_of_events(
            "{\"iteration\":8,\"polish\":0,\"delta\":0.1,\"seconds\":2,\"maxIterations\":9,"
            "\"maxPolish\":9,\"run_stage\":\"iterate\",\"step\":8,\"of\":50,\"ahead\":150}",
            "{\"iteration\":8,\"polish\":30,\"delta\":0.125,\"seconds\":5,\"maxIterations\":9,"
            "\"maxPolish\":9,\"run_stage\":\"polish\",\"step\":30,\"of\":150,\"ahead\":0}"),
        "\r\x1b[Kpolish   30/150  [####------]  40 %  delta 0.1250  12 s left");
}

/* What vor_progress_finish says on standard error. */
static const char *summary(const char *report)
{
    struct vor_progress progress = {.columns = 80};
    FILE *file = tmpfile();
    int kept = dup(STDERR_FILENO);
    struct vor_cli cli;
    vor_status status;

    ck_assert(file != NULL && kept >= 0);
    make_cli(&cli, 50, 150);
    progress.cli = &cli;
    (void)fflush(stderr);
    ck_assert_int_ge(dup2(fileno(file), STDERR_FILENO), 0);
    status = vor_progress_finish(&progress, report, strlen(report), &vt_err);
    (void)fflush(stderr);
    ck_assert_int_ge(dup2(kept, STDERR_FILENO), 0);
    (void)close(kept);
    vt_assert_ok(status);
    (void)content(file);
    (void)fclose(file);
    return shown;
}

VT_TEST(the_summary_names_iterations_and_polish_steps)
{
    ck_assert_str_eq(
        summary("{\"points\":{\"in\":9,\"out\":7},\"delta\":0.03125,\"stages\":["
                "{\"stage\":\"iterate\",\"steps\":37},{\"stage\":\"polish\",\"steps\":100}],"
                "\"stopped\":\"plateau\","
                "\"seconds\":{\"iterate\":1.5,\"polish\":2.25},\"mesh\":{\"seconds\":9}}"),
        "voronoid: out.ply: 7 points, delta 0.0312 after 37 iterations and 100 polish "
        "steps (plateau), 12.8 s\n");
    ck_assert_str_eq(
        summary("{\"points\":{\"out\":7},\"delta\":0.5,\"stages\":["
                "{\"stage\":\"iterate\",\"steps\":6}],\"stopped\":\"iterations\",\"seconds\":{}}"),
        "voronoid: out.ply: 7 points, delta 0.5000 after 6 iterations, "
        "0.0 s\n");
    ck_assert_str_eq(summary("{\"points\":{\"out\":7},\"delta\":0.5,\"iterations\":6,\"stages\":["
                             "{\"stage\":\"polish\",\"steps\":4},{\"stage\":\"melt\",\"steps\":3},"
                             "{\"stage\":\"iterate\",\"steps\":5}],\"stopped\":\"delta\"}"),
                     "voronoid: out.ply: 7 points, delta 0.5000 after 4 polish steps and 5 "
                     "iterations (delta), 0.0 s\n");
}
