#include "core/output/convert.h"
#include "core/process.h"
#include "core/report.h"

/* Triangle i has the points i, i + 1 and i + 2; every second one is turned, so that all face the
 * same way. */
static vor_status weave(struct vor_mesh *mesh, size_t n, struct vor_error *err)
{
    size_t count = n < 3 ? 0 : n - 2;

    if (count == 0)
        return VOR_OK;
    mesh->triangle = vor_malloc(mesh->memory, count, 3 * sizeof *mesh->triangle);
    if (mesh->triangle == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu triangles", count);
    mesh->count = count;
    for (size_t i = 0; i < count; i++) {
        mesh->triangle[3 * i] = (uint32_t)i;
        mesh->triangle[3 * i + 1] = (uint32_t)(i + 1 + i % 2);
        mesh->triangle[3 * i + 2] = (uint32_t)(i + 2 - i % 2);
    }
    return VOR_OK;
}

vor_status vor_toy_ribbon(struct vor_artefacts *out, const struct vor_artefacts *in,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    struct vor_report *report = vor_artefacts_put_document(out, "report", &vor_report_members, err);
    const struct vor_run whole = vor_run_unstoppable(run);
    struct vor_cloud cloud;
    struct vor_mesh mesh;
    vor_status status;

    if (report == NULL)
        return VOR_E_NOMEM;
    vor_cloud_init(&cloud, run->memory);
    vor_mesh_init(&mesh, run->memory);
    status = vor_convert_cloud(&cloud, report, vor_artefacts_cloud(in, "cloud"), spec, &whole, err);
    if (status == VOR_OK)
        status = weave(&mesh, cloud.n, err);
    if (status == VOR_OK)
        vor_artefacts_put_mesh(out, "cloud", &cloud, &mesh);
    else
        vor_cloud_free(&cloud);
    return status;
}
