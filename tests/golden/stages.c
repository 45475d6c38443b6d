/* What each stage of a run comes to, on real and made clouds, written down in stages.txt: a change
 * that is meant to move nothing shows where it does. */
#include "proto/codec.h"
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"
#include "tests/support/vt_stages.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GOLDEN_FILE "tests/golden/stages.txt"

enum { LINES = 400, LINE = 320, NAME = LINE };

/* Under a sanitizer, of so many cases of the spread one is run. */
enum { EVERY = 4 / VT_FEWER(4) };

/* One line of the file. */
struct golden {
    char text[LINE], name[NAME]; /* name: cloud, process and options, for the messages */
    char cloud[64], process[16], options[96];
    int is_case, spread, hashes; /* hashes: how many stand there */
    uint64_t hash[VT_STAGE_COUNT];
};

static struct golden golden[LINES];
static int lines;

/* Made clouds come from additions, products and roots alone: the same bits on every machine. */

static void *add(struct vor_cloud *cloud, const char *name, enum vor_semantic semantic,
                 enum vor_type type, unsigned components)
{
    struct vor_attribute *attribute;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, name, semantic, type, components, &attribute, &vt_err));
    return attribute->data;
}

static void make_box(struct vor_cloud *cloud)
{
    float *normal;
    uint8_t *color;
    double *level;

    vt_cloud_box(cloud, 6, 3000);
    for (size_t i = 49; i < cloud->n; i += 50) /* coincident points */
        memcpy(&cloud->xyz[3 * i], &cloud->xyz[3 * i - 3], 3 * sizeof *cloud->xyz);
    normal = add(cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3);
    color = add(cloud, "color", VOR_COLOR, VOR_UINT8, 3);
    level = add(cloud, "level", VOR_GENERIC, VOR_FLOAT64, 1);
    for (size_t i = 0; i < 3 * cloud->n; i++) {
        normal[i] = cloud->xyz[i] - 0.5f;
        color[i] = (uint8_t)(255 * cloud->xyz[i]);
    }
    for (size_t i = 0; i < cloud->n; i++)
        level[i] = vt_unit(7, i);
}

/* On the unit sphere, off it by up to `noise` where x > 0. */
static void make_ball(struct vor_cloud *cloud, size_t n, double noise)
{
    vt_cloud_box(cloud, 8, n);
    for (size_t i = 0; i < n; i++) {
        float *x = &cloud->xyz[3 * i];
        double d[3], r2 = 0, r;

        for (int c = 0; c < 3; c++) {
            d[c] = (double)x[c] - 0.5;
            r2 += d[c] * d[c];
        }
        r = (d[0] > 0 ? 1 + noise * (2 * vt_unit(9, i) - 1) : 1) / sqrt(r2);
        for (int c = 0; c < 3; c++)
            x[c] = (float)(r * d[c]);
    }
}

/* Normals in other types than most; those of half point inwards. */
static void make_dense(struct vor_cloud *cloud)
{
    double *normal;

    make_ball(cloud, 60000, 0);
    normal = add(cloud, "normal", VOR_NORMAL, VOR_FLOAT64, 3);
    for (size_t i = 0; i < 3 * cloud->n; i++)
        normal[i] = (double)cloud->xyz[i];
}

static void make_half(struct vor_cloud *cloud)
{
    int8_t *normal;

    make_ball(cloud, 6000, 0.04);
    normal = add(cloud, "normal", VOR_NORMAL, VOR_INT8, 3);
    for (size_t i = 0; i < 3 * cloud->n; i++)
        normal[i] = (int8_t)(-100 * cloud->xyz[i]);
}

static void make_voxels(struct vor_cloud *cloud)
{
    make_ball(cloud, 8000, 0);
    for (size_t i = 0; i < 3 * cloud->n; i++)
        cloud->xyz[i] = rintf(cloud->xyz[i] * 25) / 25;
}

static void make_sheets(struct vor_cloud *cloud)
{
    double gap = 1.5 * sqrt(2.0 / 6000);

    vt_cloud_sheets(cloud, 10, 6000, gap);
    for (size_t i = 0; i < cloud->n; i++)
        cloud->xyz[3 * i + 2] += (float)(0.1 * gap * (vt_unit(11, i) - 0.5));
}

/* A saddle with a hole in it and points above it, far from the origin. */
static void make_far(struct vor_cloud *cloud)
{
    static const double shift[3] = {637000.25, 5100000.5, 12};
    enum { N = 4000, STRAY = 100 };
    double *xyz = malloc(3 * N * sizeof *xyz);
    size_t i = 0;

    ck_assert_ptr_nonnull(xyz);
    for (uint64_t drawn = 0; i < N; drawn++) {
        double x = 2 * vt_unit(12, 2 * drawn) - 1, y = 2 * vt_unit(12, 2 * drawn + 1) - 1;

        if (x * x + y * y < 0.1)
            continue;
        xyz[3 * i] = 50 * x + shift[0];
        xyz[3 * i + 1] = 50 * y + shift[1];
        xyz[3 * i + 2] = 15 * (x * x - y * y) + (i % STRAY == 0 ? 10 : 0) + shift[2];
        i++;
    }
    vt_cloud_make(cloud, N);
    vt_assert_ok(vor_cloud_set_double(cloud, xyz, &vt_err));
    free(xyz);
}

static const struct {
    const char *name;
    void (*make)(struct vor_cloud *cloud);
} made[] = {{"box", make_box},       {"dense", make_dense},   {"half", make_half},
            {"voxels", make_voxels}, {"sheets", make_sheets}, {"far", make_far}};

enum { MADE = sizeof made / sizeof made[0] };

static int made_index(const char *name)
{
    int k = 0;

    while (k < MADE && strcmp(made[k].name, name) != 0)
        k++;
    return k;
}

static int is_missing(const struct golden *line)
{
    return made_index(line->cloud) == MADE && vt_data(line->cloud) == NULL;
}

static void open_cloud(struct vor_cloud *cloud, const char *name)
{
    static const struct vor_limits limits = VOR_LIMITS_DEFAULT;
    int k = made_index(name);
    const char *path;
    uint8_t *bytes;
    size_t size;

    if (k < MADE) {
        made[k].make(cloud);
        return;
    }
    path = vt_data(name);
    ck_assert_msg(path != NULL, "../shared/data/%s is not there", name);
    bytes = vt_slurp(path, &size);
    ck_assert_ptr_nonnull(bytes);
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_codec_read(cloud, NULL, bytes, size, &limits, &vt_err));
    free(bytes);
}

/* "name=value,name=value", or "-" for none. stop=N is the watch's, not the request's. */
static void set_options(struct vt_stages_run *run, const char *text)
{
    char options[96], *rest = options, *option;

    (void)snprintf(options, sizeof options, "%s", strcmp(text, "-") != 0 ? text : "");
    while ((option = strtok_r(rest, ",", &rest)) != NULL) {
        char *value = strchr(option, '=');

        ck_assert_msg(value != NULL, "option %s has no value", option);
        *value++ = '\0';
        if (strcmp(option, "stop") == 0)
            run->stop = (unsigned)strtoul(value, NULL, 10);
        else
            vt_assert_ok(vor_spec_set(&run->spec, option, value, &vt_err));
    }
}

static void open_run(struct vt_stages_run *run, struct vor_cloud *cloud, const struct golden *line)
{
    const struct vor_process_info *process = vor_process_find(line->process);

    ck_assert_msg(process != NULL, "no process %s", line->process);
    open_cloud(cloud, line->cloud);
    *run = (struct vt_stages_run){.in = cloud};
    vor_spec_preset(&run->spec, process);
    set_options(run, line->options);
    vt_assert_ok(vor_spec_complete(&run->spec, &vt_err));
}

/* Fails where the stages at that many threads are not those written down. */
static void check_stages(const struct golden *line, struct vt_stages_run *run, unsigned threads)
{
    uint64_t hash[VT_STAGE_COUNT];
    int stage = 0;

    run->threads = threads;
    vt_stages_drive(hash, run);
    while (stage < VT_STAGE_COUNT && hash[stage] == line->hash[stage])
        stage++;
    if (stage < VT_STAGE_COUNT)
        ck_abort_msg("%s, threads=%u: differs from stage \"%s\" on, %016" PRIx64
                     " instead of %016" PRIx64,
                     line->name, threads, vt_stage_word((enum vt_stage)stage), hash[stage],
                     line->hash[stage]);
}

/* Fails where the engine's result is not the one written down. Which stage is to blame, a run by
 * stages tells; if none is, the engine went another way than vt_stages_drive. */
static void check_engine(const struct golden *line, struct vt_stages_run *run, unsigned threads)
{
    uint64_t hash[VT_STAGE_COUNT];

    run->threads = threads;
    vt_stages_engine(hash, run);
    for (int stage = VT_STAGE_OUTPUT; stage < VT_STAGE_COUNT; stage++) {
        if (hash[stage] == line->hash[stage])
            continue;
        check_stages(line, run, threads);
        ck_abort_msg("%s, threads=%u: every stage is as written down, but the engine's %s is "
                     "%016" PRIx64 " instead of %016" PRIx64
                     ": core/engine.c and vt_stages_drive have parted",
                     line->name, threads, vt_stage_word((enum vt_stage)stage), hash[stage],
                     line->hash[stage]);
    }
}

START_TEST(every_stage_comes_to_what_is_written_down)
{
    static const unsigned threads[3] = {2, 3, 8};
    const struct golden *line = &golden[_i];
    struct vt_stages_run run;
    struct vor_cloud cloud;

    ck_assert_msg(line->hashes == VT_STAGE_COUNT, "%s: %d hashes, want %d", line->name,
                  line->hashes, VT_STAGE_COUNT);
    open_run(&run, &cloud, line);
    if (VT_FIGURES)
        check_stages(line, &run, 1);
    check_engine(line, &run, 3);
    for (int k = 0; k < 3 && vt_soaks(); k++)
        check_stages(line, &run, threads[k]);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

/* Without the data this is a skip, said by the case's name; but not where CI is set, which has it.
 */
START_TEST(the_cloud_is_there)
{
    ck_assert_msg(getenv("CI") == NULL, "%s: ../shared/data/%s is not there", golden[_i].name,
                  golden[_i].cloud);
}
END_TEST

START_TEST(print_the_file_anew)
{
    for (int k = 0; k < lines; k++) {
        const struct golden *line = &golden[k];
        struct golden fresh = *line;
        struct vt_stages_run run;
        struct vor_cloud cloud;

        if (!line->is_case) {
            (void)printf("%s\n", line->text);
            continue;
        }
        open_run(&run, &cloud, line);
        run.threads = 1;
        vt_stages_drive(fresh.hash, &run);
        check_engine(&fresh, &run, 3);
        vor_cloud_free(&cloud);
        (void)printf("%s%s", line->spread ? "* " : "", line->name);
        for (int stage = 0; stage < VT_STAGE_COUNT; stage++)
            (void)printf(" %016" PRIx64, fresh.hash[stage]);
        (void)printf("\n");
    }
}
END_TEST

static void parse_line(struct golden *line)
{
    const char *at = line->text;
    int used = 0;

    line->spread = at[0] == '*';
    at += line->spread ? 1 : 0;
    at += strspn(at, " ");
    if (line->text[0] == '#' ||
        sscanf(at, "%63s %15s %95s%n", line->cloud, line->process, line->options, &used) != 3)
        return;
    line->is_case = 1;
    memcpy(line->name, at, (size_t)used);
    for (at += used; line->hashes < VT_STAGE_COUNT; at += used)
        if (sscanf(at, " %16" SCNx64 "%n", &line->hash[line->hashes++], &used) != 1) {
            line->hashes--;
            return;
        }
}

/* Whether the file could be read. */
static int read_golden(void)
{
    FILE *file = fopen(GOLDEN_FILE, "r");

    if (file == NULL)
        return 0;
    while (lines < LINES && fgets(golden[lines].text, LINE, file) != NULL) {
        golden[lines].text[strcspn(golden[lines].text, "\n")] = '\0';
        parse_line(&golden[lines++]);
    }
    fclose(file);
    return lines > 0 && lines < LINES;
}

static void add_case(Suite *suite, int k, const TTest *test, const char *name, int timeout)
{
    TCase *tcase = tcase_create(name);

    tcase_set_timeout(tcase, timeout);
    tcase_add_loop_test(tcase, test, k, k + 1);
    suite_add_tcase(suite, tcase);
}

/* To stdout alone: no TAP, no process of its own. */
static int print_golden(void)
{
    Suite *suite = suite_create("print");
    SRunner *runner = srunner_create(suite);
    int failed;

    add_case(suite, 0, print_the_file_anew, "print", 0);
    vor_memory_init(&vt_memory, SIZE_MAX);
    srunner_set_fork_status(runner, CK_NOFORK);
    srunner_run_all(runner, CK_SILENT);
    failed = srunner_ntests_failed(runner);
    if (failed > 0)
        (void)fprintf(stderr, "%s\n", tr_msg(*srunner_failures(runner)));
    srunner_free(runner);
    return failed;
}

int main(void)
{
    static char skips[LINES][NAME + 100];
    const char *mode = getenv("VT_GOLDEN");
    Suite *suite = suite_create("stages");
    int of_spread = 0;

    if (!read_golden()) {
        (void)printf("Bail out! " GOLDEN_FILE " cannot be read, or has more than %d lines\n",
                     LINES - 1);
        return 1;
    }
    if (mode != NULL && strcmp(mode, "print") == 0)
        return print_golden();
    for (int k = 0; k < lines; k++) {
        const struct golden *line = &golden[k];

        if (!line->is_case || (!vt_soaks() && !(line->spread && of_spread++ % EVERY == 0)))
            continue;
        if (!is_missing(line)) {
            add_case(suite, k, every_stage_comes_to_what_is_written_down, line->name, 600);
            continue;
        }
        (void)snprintf(skips[k], sizeof skips[k], "%s%s../shared/data/%s is not there", line->name,
                       getenv("CI") == NULL ? " # SKIP " : ", ", line->cloud);
        add_case(suite, k, the_cloud_is_there, skips[k], 600);
    }
    return vt_run(suite);
}
