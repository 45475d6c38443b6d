/* What requests come to whose stages tests/golden/stages.c does not follow one by one: other
 * methods, densities, metrics, borders, meshes. The same bytes at one thread and at three, and
 * those written down. When a change is meant to change results, run this program, write down what
 * it prints, and say in the commit which rows moved and why that is right. */
#include "tests/support/vt_engine.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { N = 5000, OUT = 500 };

/* Everything is asked of one surface: a sheet that bends up along x and down along y, folded by
 * 45 degrees at x = 0.5, with one round hole. No function of the mathematics library makes it. */
static void make_sheet(struct vor_cloud *cloud)
{
    size_t i = 0;

    vt_cloud_make(cloud, N);
    for (uint64_t drawn = 0; i < N; drawn++) {
        double x = 2 * vt_unit(21, 2 * drawn) - 1, y = 2 * vt_unit(21, 2 * drawn + 1) - 1;

        if ((x + 0.4) * (x + 0.4) + y * y < 0.03)
            continue;
        cloud->xyz[3 * i] = (float)x;
        cloud->xyz[3 * i + 1] = (float)y;
        cloud->xyz[3 * i + 2] = (float)(0.5 * x * x - 0.15 * y * y + (x > 0.5 ? x - 0.5 : 0));
        i++;
    }
}

static const struct row {
    const char *process, *options; /* options: NAME=VALUE, with blanks between */
    uint64_t golden;
} rows[] = {
    {"resample", "patch=plane", UINT64_C(0xda7e5519662a56e2)},
    {"resample", "method=kmeans", UINT64_C(0x7a96e3ab52c5b67a)},
    {"resample", "method=wlop", UINT64_C(0xd91a425f3ed441b7)},
    {"resample", "method=ear samples=200 polish=5", UINT64_C(0xc91eb465fa856f75)},
    {"resample", "density=curvature polish=5", UINT64_C(0x35461fb8c8b23209)},
    {"resample", "density=curvature contrast=8 grading=0.4", UINT64_C(0xb8bf093a8e57ab48)},
    {"resample", "density=edges", UINT64_C(0x0045dd5aeb3412fd)},
    {"resample", "edges=sites", UINT64_C(0x1039c3951be5a87f)},
    {"resample", "metric=anisotropic polish=5", UINT64_C(0x390b71338da30a2b)},
    {"resample", "metric=anisotropic maxAspect=3", UINT64_C(0xc1253f6f2399d46a)},
    {"resample", "metric=anisotropic cells=euclid", UINT64_C(0xb3a404b5e666d4e9)},
    {"resample", "metric=lp p=8", UINT64_C(0x7e2875582189b22d)},
    {"resample", "boundary=sites", UINT64_C(0x2f251f9aade85d00)},
    {"resample", "boundary=fill holes=auto", UINT64_C(0x6021698b756b7168)},
    {"resample", "moveStop=0.05", UINT64_C(0x0cd21a5c4e7f9387)},
    {"mesh", "polish=5", UINT64_C(0xa4734e1b00972465)},
    {"mesh", "metric=anisotropic", UINT64_C(0x21bf0ad187975e63)},
    {"mesh", "boundary=fill holes=auto", UINT64_C(0x54f3523d602c4b0f)},
};

static void set_options(struct vt_engine *engine, const char *options)
{
    char text[128], *next = NULL;

    (void)snprintf(text, sizeof text, "%s", options);
    for (char *word = strtok_r(text, " ", &next); word != NULL; word = strtok_r(NULL, " ", &next)) {
        char *value = strchr(word, '=');

        *value = '\0';
        vt_engine_set(engine, word, value + 1);
    }
}

/* Of positions and triangles. */
static uint64_t run(const struct row *row, const struct vor_cloud *in, unsigned threads)
{
    struct vt_engine engine;
    struct vt_meshed out;
    uint64_t hash;

    vt_engine_open(&engine, threads);
    vor_spec_preset(&engine.spec, vor_process_find(row->process));
    vt_engine_count(&engine, "points", OUT);
    vt_engine_set(&engine, "iterations", "8");
    set_options(&engine, row->options);
    vt_assert_ok(vt_engine_mesh(&out, in, &engine));
    hash = vt_cloud_hash(&out.cloud);
    if (out.mesh.count > 0)
        hash ^= vt_hash(out.mesh.triangle, out.mesh.count * 3 * sizeof *out.mesh.triangle);
    vt_meshed_free(&out);
    vt_engine_close(&engine);
    return hash;
}

START_TEST(a_request_gives_the_bytes_written_down_at_one_thread_and_at_three)
{
    const struct row *row = &rows[_i];
    struct vor_cloud in;
    uint64_t alone, shared;

    make_sheet(&in);
    alone = run(row, &in, 1);
    shared = run(row, &in, 3);
    printf("# %s %s UINT64_C(0x%016" PRIx64 ")\n", row->process, row->options, alone);
    fflush(stdout);
    ck_assert(alone == shared);
    ck_assert(alone == row->golden);
    vor_cloud_free(&in);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("requests");

    vt_add_figures(suite, a_request_gives_the_bytes_written_down_at_one_thread_and_at_three,
                   sizeof rows / sizeof rows[0]);
    return vt_run(suite);
}
