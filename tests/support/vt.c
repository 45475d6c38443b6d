#include "tests/support/vt.h"

#include "proto/json/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

struct vor_error vt_err;
struct vor_memory vt_memory;

enum { TESTS_MAX = 128 };

static struct registered {
    const TTest *test;
    int (*loops)(void); /* asked once the program has prepared itself */
} registered[TESTS_MAX];
static int registered_count;

void vt_register(const TTest *test, int (*loops)(void))
{
    if (registered_count < TESTS_MAX)
        registered[registered_count] = (struct registered){test, loops};
    registered_count++;
}

static int by_place(const void *a, const void *b)
{
    const TTest *x = ((const struct registered *)a)->test,
                *y = ((const struct registered *)b)->test;
    int files = strcmp(x->file, y->file);

    return files != 0 ? files : x->line - y->line;
}

int vt_run(Suite *suite)
{
    SRunner *runner = srunner_create(suite);
    int failed;

    if (registered_count > TESTS_MAX) /* none is left out in silence */
        abort();
    qsort(registered, (size_t)registered_count, sizeof registered[0], by_place);
    for (int i = 0; i < registered_count; i++)
        vt_add_case(suite, registered[i].test->name, registered[i].test, registered[i].loops());
    setvbuf(stdout, NULL, _IOLBF, 0);
    vor_memory_init(&vt_memory, SIZE_MAX);
    srunner_set_tap(runner, "-");
    srunner_run_all(runner, CK_SILENT);
    failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed == 0 ? 0 : 1;
}

void vt_add_case(Suite *suite, const char *name, const TTest *test, int loops)
{
    TCase *tcase = tcase_create(name);

    tcase_set_timeout(tcase, 600);
    tcase_add_checked_fixture(tcase, NULL, vt_assert_no_leak);
    if (loops > 0)
        tcase_add_loop_test(tcase, test, 0, loops);
    else
        tcase_add_test(tcase, test);
    suite_add_tcase(suite, tcase);
}

int vt_soaks(void)
{
    return getenv("VT_SOAK") != NULL;
}

void vt_held(const char *file, int line)
{
    static _Thread_local long told;
    struct timespec now;

    (void)clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
    if (now.tv_nsec == told)
        return;
    told = now.tv_nsec;
    _mark_point(file, line);
}

void vt_nap(void)
{
    const struct timespec pause = {.tv_nsec = 1000000};

    (void)nanosleep(&pause, NULL);
}

void vt_assert_no_leak(void)
{
    ck_assert_uint_eq(atomic_load(&vt_memory.used), 0);
}

void vt_free_last(struct vor_cloud *one, struct vor_cloud *other)
{
    vor_cloud_free(one);
    vor_cloud_free(other);
}

void vt_fail_each(vor_status (*attempt)(void *ctx), void *ctx)
{
    size_t used = atomic_load(&vt_memory.used), call = 0;
    vor_status status;

    do {
        vt_memory.fail_at = atomic_load(&vt_memory.calls) + ++call;
        status = attempt(ctx);
        vt_memory.fail_at = 0;
        ck_assert_msg(status == VOR_OK || status == VOR_E_NOMEM, "call %zu: %s (%s)", call,
                      vor_status_slug(status), vt_err.message);
        ck_assert_uint_eq(atomic_load(&vt_memory.used), used);
    } while (status != VOR_OK);
    ck_assert_uint_gt(call, 1);
}

double vt_unit(uint64_t seed, uint64_t index)
{
    return vor_rng_unit(seed, 999, index);
}

void vt_reflect(double *x, const double *across, int n)
{
    double along = 0, length2 = 0;

    for (int i = 0; i < n; i++) {
        along += across[i] * x[i];
        length2 += across[i] * across[i];
    }
    for (int i = 0; i < n; i++)
        x[i] -= length2 > 0 ? 2 * along / length2 * across[i] : 0;
}

static void fresh(struct vor_cloud *cloud, size_t n)
{
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_cloud_resize(cloud, n, &vt_err));
}

void vt_cloud_cube(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    fresh(cloud, n);
    for (size_t i = 0; i < 3 * n; i++)
        cloud->xyz[i] = (float)vt_unit(seed, i);
}

void vt_cloud_sphere(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    fresh(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double z = 2 * vt_unit(seed, 2 * i) - 1, a = 2 * M_PI * vt_unit(seed, 2 * i + 1);
        double r = sqrt(1 - z * z);

        cloud->xyz[3 * i] = (float)(r * cos(a));
        cloud->xyz[3 * i + 1] = (float)(r * sin(a));
        cloud->xyz[3 * i + 2] = (float)z;
    }
}

void vt_cloud_square(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    fresh(cloud, n);
    for (size_t i = 0; i < n; i++) {
        cloud->xyz[3 * i] = (float)vt_unit(seed, 2 * i);
        cloud->xyz[3 * i + 1] = (float)vt_unit(seed, 2 * i + 1);
        cloud->xyz[3 * i + 2] = 0;
    }
}

uint8_t *vt_slurp(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    uint8_t *data = NULL;
    long length;

    if (file == NULL)
        return NULL;
    if (fseek(file, 0, SEEK_END) == 0 && (length = ftell(file)) >= 0 &&
        fseek(file, 0, SEEK_SET) == 0 && (data = malloc((size_t)length + 1)) != NULL) {
        *size = fread(data, 1, (size_t)length, file);
        if (*size != (size_t)length) {
            free(data);
            data = NULL;
        }
    }
    fclose(file);
    return data;
}

const char *vt_data(const char *name)
{
    static char path[512];

    (void)snprintf(path, sizeof path, "../shared/data/%s", name);
    return access(path, R_OK) == 0 ? path : NULL;
}

const char *vt_data_or_skip(const char *name)
{
    const char *path = vt_data(name);

    ck_assert_msg(path != NULL || getenv("CI") == NULL,
                  "../shared/data/%s is not there, and CI is set: its tests must run", name);
    if (path == NULL)
        (void)printf("# skipped: ../shared/data/%s is not there\n", name);
    return path;
}

int vt_bytes_write(void *ctx, const void *data, size_t size)
{
    struct vt_bytes *bytes = ctx;

    if (bytes->size + size > bytes->capacity) {
        size_t capacity = 2 * (bytes->size + size);
        uint8_t *grown = realloc(bytes->data, capacity);

        if (grown == NULL)
            return -1;
        bytes->data = grown;
        bytes->capacity = capacity;
    }
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
    return 0;
}

void vt_assert_same(const struct vor_cloud *a, const struct vor_cloud *b)
{
    ck_assert_uint_eq(a->n, b->n);
    ck_assert_int_eq(a->position_type, b->position_type);
    ck_assert_mem_eq(a->origin, b->origin, sizeof a->origin);
    ck_assert_mem_eq(a->xyz, b->xyz, a->n * 3 * sizeof *a->xyz);
    ck_assert_uint_eq(a->attribute_count, b->attribute_count);
    for (size_t i = 0; i < a->attribute_count; i++) {
        const struct vor_attribute *p = &a->attributes[i], *q = &b->attributes[i];

        ck_assert_str_eq(p->name, q->name);
        ck_assert_int_eq(p->semantic, q->semantic);
        ck_assert_int_eq(p->type, q->type);
        ck_assert_uint_eq(p->components, q->components);
        ck_assert_mem_eq(p->data, q->data, a->n * p->components * vor_type_size(p->type));
    }
}

struct vor_json *vt_json(const char *json)
{
    struct vor_json *out = NULL;

    vt_assert_ok(vor_json_parse(&out, json, strlen(json), &vt_err));
    return out;
}

size_t vt_json_count(const struct vor_json *value)
{
    size_t count = 0;

    for (value = vor_json_first(value); value != NULL; value = vor_json_next(value))
        count++;
    return count;
}
