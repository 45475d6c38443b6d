#include "core/output/triangles.h"

#include "core/mesh/mesh.h"
#include "core/mesh/soup.h"

#include <string.h>

vor_status vor_triangles_of_seeds(struct vor_mesh *out, uint32_t **order, struct vor_report *report,
                                  struct vor_seeds *seeds, const struct vor_outcome *told,
                                  const struct vor_spec *spec, struct vor_error *err)
{
    /* In a metric good triangles are long ones, which these moves would undo. */
    const struct vor_mesh_how how = {
        .moves = told->steps[VOR_RUN_STAGE_POLISH] > 0 && !vor_stretched_are(&seeds->stretched),
        .refine = told->refined,
        .repairs = spec->value[VOR_PARAM_REPAIR] == VOR_REPAIR_AUTO,
        .fixed =
            seeds->fixed > (size_t)report->on_islands ? seeds->fixed : (size_t)report->on_islands};
    double began = vor_run_seconds(&seeds->run);
    vor_status status;

    *order = vor_malloc(seeds->run.memory, seeds->n, sizeof **order);
    if (*order == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", seeds->n);
    if (spec->value[VOR_PARAM_SOUP] > 0)
        return VOR_OK;
    status = vor_mesh_make(out, report, seeds, &how, err);
    report->mesh_seconds = vor_run_seconds(&seeds->run) - began;
    return status;
}

/* Replaces the result by the corners of the polygons of its points' cells. */
static vor_status make_soup(struct vor_mesh *out, struct vor_report *report,
                            const struct vor_triangles_of *of, struct vor_seeds *seeds,
                            struct vor_error *err)
{
    const struct vor_soup_of soup_of = {of->cloud, seeds, of->order};
    struct vor_cloud soup;
    vor_status status;

    vor_cloud_init(&soup, of->cloud->memory);
    status = vor_soup_make(&soup, out, &soup_of, err);
    if (status != VOR_OK)
        return status;
    soup.notes = of->cloud->notes;
    memset(&of->cloud->notes, 0, sizeof of->cloud->notes);
    vor_cloud_free(of->cloud);
    *of->cloud = soup;
    report->has_mesh = 1;
    report->mesh_polygons = vor_mesh_faces(out);
    report->mesh_points = soup.n;
    return VOR_OK;
}

/* Makes the faces of points that are no seeds, in their own order. */
static vor_status of_points(struct vor_mesh *out, struct vor_report *report,
                            const struct vor_triangles_of *of, const struct vor_run *run,
                            struct vor_error *err)
{
    const struct vor_cloud *cloud = of->cloud;
    const struct vor_mesh_how how = {.moves = 0};
    struct vor_seeds seeds = {.n = 0};
    vor_status status =
        vor_seeds_init(&seeds, of->domain, cloud->n, vor_seeds_policy_of(of->spec), run, err);

    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < cloud->n; i++)
        vor_domain_normalise(of->domain, cloud->xyz + 3 * i, seeds.xyz + 3 * i);
    status = of->spec->value[VOR_PARAM_SOUP] > 0 ? make_soup(out, report, of, &seeds, err)
                                                 : vor_mesh_make(out, report, &seeds, &how, err);
    vor_seeds_free(&seeds);
    return status;
}

vor_status vor_triangles_finish(struct vor_mesh *mesh, struct vor_report *report,
                                const struct vor_triangles_of *of, const struct vor_run *run,
                                struct vor_error *err)
{
    double began = vor_run_seconds(run);
    vor_status status = of->seeds->n == 0
                            ? of_points(mesh, report, of, run, err)
                            : (of->spec->value[VOR_PARAM_SOUP] > 0
                                   ? make_soup(mesh, report, of, of->seeds, err)
                                   : vor_mesh_reorder(mesh, of->order, of->seeds->n, err));

    if (status != VOR_OK) {
        vor_mesh_free(mesh);
        return status;
    }
    for (unsigned l = 0; l < report->mesh_longest_count; l++)
        for (int c = 0; c < 3; c++)
            report->mesh_longest[l].middle[c] += of->in->origin[c];
    report->mesh_seconds += vor_run_seconds(run) - began;
    return VOR_OK;
}
