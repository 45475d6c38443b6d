/* Work of stages whose loops an input or a parameter makes long: twice the input takes about twice
 * the work, and cancel is asked for in between. Core is compiled to count each branch that it takes
 * (gcc's -fsanitize-coverage=trace-pc), so that no clock judges. */
#include "tests/support/vt_made.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What twice the input may cost: O(n log n), and a little. */
#define DOUBLED 2.3

/* Branches between two questions whether to go on, for each point and beside those: a few passes
 * over all points, and some milliseconds. */
enum { SILENT_EACH = 400, SILENT = 20000000 };

static size_t work, asked, silent;

/* The pool has one thread, for which the caller waits. */
void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void)
{
    work++;
}

static enum vor_answer poll(void *ctx)
{
    (void)ctx;
    silent = work - asked > silent ? work - asked : silent;
    asked = work;
    return VOR_CONTINUE;
}

static void begin(void)
{
    work = asked = silent = 0;
}

/* A strip six points wide, whose scalar asks for much at one end. */
static void ribbon(struct vor_cloud *cloud, size_t n)
{
    struct vor_attribute *rho;

    vt_cloud_make(cloud, n);
    vt_assert_ok(vor_cloud_add_attribute(cloud, "rho", VOR_GENERIC, VOR_FLOAT32, 1, &rho, &vt_err));
    for (size_t i = 0; i < n; i++) {
        float *x = &cloud->xyz[3 * i];

        x[0] = (float)((double)(i / 6) + 0.4 * vt_unit(1, i));
        x[1] = (float)((double)(i % 6) + 0.4 * vt_unit(2, i));
        x[2] = (float)(0.04 * vt_unit(3, i));
        ((float *)rho->data)[i] = i < 6 ? 1e8F : 1;
    }
}

struct row {
    const char *name;
    void (*cloud)(struct vor_cloud *cloud, size_t n);
    size_t n;
    const char *set[8]; /* parameters and values */
};

static const struct row rows[] = {
    {"density", ribbon, 4000, {"density", "attribute:rho", "contrast", "100", "grading", "0.001"}},
};

static size_t work_of(const struct row *row, size_t n)
{
    const struct vor_watch watch = {.poll = poll};
    struct vt_made made = {.domain = {.n = 0}};

    vt_engine_open(&made.engine, 1);
    made.engine.run.watch = &watch;
    row->cloud(&made.cloud, n);
    vt_engine_count(&made.engine, "points", n / 3);
    for (size_t i = 0; row->set[i] != NULL; i += 2)
        vt_engine_set(&made.engine, row->set[i], row->set[i + 1]);
    begin();
    vt_assert_ok(vt_made_make(&made, n / 3));
    (void)poll(NULL);
    made.engine.run.watch = NULL;
    vt_made_close(&made);
    return asked;
}

static void grows(const char *name, size_t before, size_t after, size_t n)
{
    printf("# %s: %zu points %zu branches, twice as many %zu, in silence %zu\n", name, n, before,
           after, silent);
    ck_assert_msg((double)after <= DOUBLED * (double)before,
                  "%s: %zu branches for %zu points, %zu for twice as many", name, before, n, after);
    ck_assert_msg(silent <= SILENT + SILENT_EACH * n, "%s: %zu branches in silence", name, silent);
}

START_TEST(twice_the_points_take_twice_the_work)
{
    const struct row *row = &rows[_i];
    size_t one = work_of(row, row->n), two = work_of(row, 2 * row->n);

    grows(row->name, one, two, row->n);
    grows(row->name, two, work_of(row, 4 * row->n), 2 * row->n);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("growth");

    vt_add_loop(suite, twice_the_points_take_twice_the_work, sizeof rows / sizeof *rows);
    return vt_run(suite);
}
