#include "tests/support/vt_engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void vt_engine_open(struct vt_engine *engine, unsigned threads)
{
    memset(engine, 0, sizeof *engine);
    vt_assert_ok(vor_pool_create(&engine->pool, threads, &vt_err));
    engine->run.pool = engine->pool;
    engine->run.memory = &vt_memory;
    vor_spec_init(&engine->spec);
}

void vt_engine_close(struct vt_engine *engine)
{
    vor_pool_destroy(engine->pool);
    engine->pool = NULL;
}

void vt_engine_set(struct vt_engine *engine, const char *name, const char *text)
{
    vt_assert_ok(vor_spec_set(&engine->spec, name, text, &vt_err));
}

void vt_engine_count(struct vt_engine *engine, const char *name, size_t value)
{
    vt_assert_ok(vor_spec_set_number(&engine->spec, name, (double)value, &vt_err));
}

void vt_engine_resample(struct vt_engine *engine, struct vor_cloud *out, struct vor_report *report,
                        const struct vor_cloud *in)
{
    vt_assert_ok(vt_engine_try(engine, out, report, in));
}

/* Runs a process with one cloud in, or two, a cloud and a report out. *out is set on success alone.
 */
static vor_status run_engine(struct vt_meshed *out, const struct vor_cloud *in,
                             const struct vor_cloud *previous, const struct vor_spec *spec,
                             const struct vor_run *run, struct vor_error *err)
{
    struct vor_artefacts inputs, outputs;
    vor_status status;

    vor_artefacts_init(&inputs, run->memory);
    vor_artefacts_init(&outputs, run->memory);
    inputs.item[inputs.count++] =
        (struct vor_artefact){.name = "cloud", .kind = VOR_ARTEFACT_CLOUD, .cloud = *in};
    if (previous != NULL)
        inputs.item[inputs.count++] = (struct vor_artefact){
            .name = "previous", .kind = VOR_ARTEFACT_CLOUD, .cloud = *previous};
    status = vor_engine_run(&outputs, &inputs, spec, run, err);
    if (status == VOR_OK) {
        struct vor_report *told = vor_artefacts_values(&outputs, "report", &vor_report_members);

        ck_assert_uint_eq(outputs.count, 2);
        out->report = *told;
        out->cloud = *vor_artefacts_cloud(&outputs, "cloud");
        out->mesh = *vor_artefacts_mesh(&outputs, "cloud");
        vor_free(run->memory, told);
        outputs.count = 0; /* they are the caller's now */
    }
    vor_artefacts_free(&outputs);
    return status;
}

vor_status vt_engine_try(struct vt_engine *engine, struct vor_cloud *out, struct vor_report *report,
                         const struct vor_cloud *in)
{
    struct vt_meshed made;
    vor_status status;

    vt_assert_ok(vor_spec_check(&engine->spec, &vt_err));
    vor_cloud_init(out, engine->run.memory);
    memset(report, 0, sizeof *report);
    status = run_engine(&made, in, engine->previous, &engine->spec, &engine->run, &vt_err);
    if (status == VOR_OK) {
        *report = made.report;
        *out = made.cloud;
        vor_mesh_free(&made.mesh);
    }
    return status;
}

vor_status vt_run_engine(struct vor_cloud *out, struct vor_report *report,
                         const struct vor_cloud *in, const struct vor_spec *spec,
                         const struct vor_run *run, struct vor_error *err)
{
    struct vt_meshed made;
    vor_status status = run_engine(&made, in, NULL, spec, run, err);

    if (status == VOR_OK) {
        *report = made.report;
        *out = made.cloud;
        vor_mesh_free(&made.mesh);
    }
    return status;
}

vor_status vt_engine_mesh(struct vt_meshed *out, const struct vor_cloud *in,
                          const struct vt_engine *engine)
{
    memset(out, 0, sizeof *out);
    return run_engine(out, in, NULL, &engine->spec, &engine->run, &vt_err);
}

void vt_cloud_make(struct vor_cloud *cloud, size_t n)
{
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_cloud_resize(cloud, n, &vt_err));
}

void vt_cloud_box(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        size_t face = (size_t)(6 * vt_unit(seed, 3 * i)), axis = face % 3;

        cloud->xyz[3 * i + axis] = face < 3 ? 0 : 1;
        cloud->xyz[3 * i + (axis + 1) % 3] = (float)vt_unit(seed, 3 * i + 1);
        cloud->xyz[3 * i + (axis + 2) % 3] = (float)vt_unit(seed, 3 * i + 2);
    }
}

void vt_cloud_dome(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_sphere(cloud, seed, n);
    for (size_t i = 0; i < n; i++)
        cloud->xyz[3 * i + 2] = fabsf(cloud->xyz[3 * i + 2]);
}

void vt_cloud_lattice(struct vor_cloud *cloud, size_t side)
{
    vt_cloud_make(cloud, side * side);
    for (size_t i = 0; i < side * side; i++) {
        cloud->xyz[3 * i] = (float)(i % side);
        cloud->xyz[3 * i + 1] = (float)(i / side);
        cloud->xyz[3 * i + 2] = 0;
    }
}

double vt_normal(uint64_t seed, uint64_t index)
{
    return sqrt(-2 * log(1 - vt_unit(seed, 2 * index))) *
           cos(2 * M_PI * vt_unit(seed, 2 * index + 1));
}

double vt_nearest2(const struct vor_cloud *cloud, const double x[3], size_t *which)
{
    double best = INFINITY;

    for (size_t i = 0; i < cloud->n; i++) {
        double p[3], d2 = 0;

        vor_cloud_position(cloud, i, p);
        for (int c = 0; c < 3; c++)
            d2 += (p[c] - x[c]) * (p[c] - x[c]);
        if (!(d2 < best))
            continue;
        best = d2;
        if (which != NULL)
            *which = i;
    }
    return best;
}

static int by_place(const void *a, const void *b)
{
    const float *x = a, *y = b;

    for (int c = 0; c < 3; c++)
        if (x[c] != y[c])
            return x[c] < y[c] ? -1 : 1;
    return 0;
}

size_t vt_coincident(const struct vor_cloud *cloud)
{
    size_t row = 3 * sizeof(float), found = 0;
    float *sorted = malloc(cloud->n * row);

    ck_assert_ptr_nonnull(sorted);
    memcpy(sorted, cloud->xyz, cloud->n * row);
    qsort(sorted, cloud->n, row, by_place);
    for (size_t i = 1; i < cloud->n; i++)
        found += by_place(&sorted[3 * i - 3], &sorted[3 * i]) == 0;
    free(sorted);
    return found;
}

uint64_t vt_hash(const void *data, size_t size)
{
    const unsigned char *byte = data;
    uint64_t hash = UINT64_C(0xcbf29ce484222325);

    for (size_t i = 0; i < size; i++)
        hash = (hash ^ byte[i]) * UINT64_C(0x100000001b3);
    return hash;
}

uint64_t vt_cloud_hash(const struct vor_cloud *cloud)
{
    return vt_hash(cloud->xyz, cloud->n * 3 * sizeof *cloud->xyz) ^
           vt_hash(cloud->origin, sizeof cloud->origin);
}

void vt_meshed_free(struct vt_meshed *meshed)
{
    vor_mesh_free(&meshed->mesh);
    vor_cloud_free(&meshed->cloud);
}
