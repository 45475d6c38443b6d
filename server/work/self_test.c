#include "server/work/self_test.h"

#include "core/engine.h"

#include <math.h>

enum {
    SIDE = 10,      /* points along an edge of a cube's face */
    ITERATIONS = 10 /* and steps of the polish */
};

/* Farther from the sphere, in radii, or less even than that no result is; one that is right has
 * .001 and .024. */
static const double off_most = .03, delta_most = .1;

vor_status vor_self_test_judge(const struct vor_cloud *made, double delta, struct vor_error *err)
{
    if (made->n != VOR_SELF_TEST_POINTS)
        return vor_fail(err, VOR_E_INTERNAL, "the result has %zu points, want %d", made->n,
                        VOR_SELF_TEST_POINTS);
    for (size_t i = 0; i < made->n; i++) {
        double sum = 0;

        for (unsigned c = 0; c < 3; c++) {
            double at = made->origin[c] + made->xyz[3 * i + c];

            sum += at * at;
        }
        if (!(fabs(sqrt(sum) - 1) <= off_most))
            return vor_fail(err, VOR_E_INTERNAL,
                            "point %zu is %g from the centre of the unit sphere, want 1", i,
                            sqrt(sum));
    }
    if (!(delta <= delta_most))
        return vor_fail(err, VOR_E_INTERNAL, "delta of the result is %g, want at most %g", delta,
                        delta_most);
    return VOR_OK;
}

static vor_status run_engine(struct vor_artefacts *out, struct vor_artefacts *in,
                             const struct vor_run *run, struct vor_error *err)
{
    struct vor_cloud sphere;
    struct vor_spec spec;
    vor_status status;
    float *at;

    vor_spec_init(&spec);
    vor_cloud_init(&sphere, run->memory);
    status = vor_spec_set_number(&spec, "points", VOR_SELF_TEST_POINTS, err);
    VOR_THEN(status, vor_spec_set_number(&spec, "iterations", ITERATIONS, err));
    VOR_THEN(status, vor_spec_set_number(&spec, "polish", ITERATIONS, err));
    VOR_THEN(status, vor_spec_check(&spec, err));
    VOR_THEN(status, vor_cloud_resize(&sphere, VOR_SELF_TEST_INPUT, err));
    if (status != VOR_OK)
        return status;
    at = sphere.xyz;
    /* Points of a cube's six faces, in the middles of their squares, moved onto the unit sphere. */
    for (int i = 0; i < VOR_SELF_TEST_INPUT; i++, at += 3) {
        int face = i / (SIDE * SIDE), row = i / SIDE % SIDE, column = i % SIDE;
        double u = (2 * row + 1.0) / SIDE - 1, v = (2 * column + 1.0) / SIDE - 1;
        double length = sqrt(1 + u * u + v * v);

        at[face % 3] = (float)((face < 3 ? 1 : -1) / length);
        at[(face + 1) % 3] = (float)(u / length);
        at[(face + 2) % 3] = (float)(v / length);
    }
    vor_artefacts_put_cloud(in, "cloud", &sphere);
    return vor_engine_run(out, in, &spec, run, err);
}

vor_status vor_self_test(struct vor_pool *pool, struct vor_memory *memory, struct vor_error *err)
{
    const struct vor_run run = {.pool = pool, .memory = memory};
    struct vor_artefacts in, out;
    vor_status status;

    vor_artefacts_init(&in, memory);
    vor_artefacts_init(&out, memory);
    status = run_engine(&out, &in, &run, err);
    if (status == VOR_OK) {
        const struct vor_report *report = vor_artefacts_values(&out, "report", &vor_report_members);

        status = vor_self_test_judge(vor_artefacts_cloud(&out, "cloud"), report->delta, err);
    }
    vor_artefacts_free(&out);
    vor_artefacts_free(&in);
    return status;
}
