#include "core/output/triangles.h"

#include "core/mesh/mesh.h"

/* Makes the triangles of points that are no seeds, in their own order. */
static vor_status of_points(struct vor_mesh *out, struct vor_report *report,
                            const struct vor_triangles_of *of, const struct vor_run *run,
                            struct vor_error *err)
{
    const struct vor_cloud *cloud = of->cloud;
    struct vor_seeds seeds = {.n = 0};
    vor_status status =
        vor_seeds_init(&seeds, of->domain, cloud->n, vor_seeds_policy_of(of->spec), run, err);

    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < cloud->n; i++)
        vor_domain_normalise(of->domain, cloud->xyz + 3 * i, seeds.xyz + 3 * i);
    status = vor_mesh_make(out, report, &seeds, err);
    vor_seeds_free(&seeds);
    return status;
}

/* The middles of loops were relative to the input's origin. */
static void count_from_zero(struct vor_report *report, const double origin[3])
{
    for (unsigned l = 0; l < report->mesh_longest_count; l++)
        for (int c = 0; c < 3; c++)
            report->mesh_longest[l].middle[c] += origin[c];
}

vor_status vor_triangles_make(struct vor_mesh *out, struct vor_report *report,
                              const struct vor_triangles_of *of, const struct vor_run *run,
                              struct vor_error *err)
{
    double began = vor_run_seconds(run);
    vor_status status;

    if (of->seeds->n == 0) {
        status = of_points(out, report, of, run, err);
    } else {
        status = vor_mesh_make(out, report, of->seeds, err);
        if (status == VOR_OK)
            status = vor_mesh_reorder(out, of->order, of->seeds->n, err);
    }
    if (status != VOR_OK) {
        vor_mesh_free(out);
        return status;
    }
    count_from_zero(report, of->in->origin);
    report->mesh_seconds = vor_run_seconds(run) - began;
    return VOR_OK;
}
