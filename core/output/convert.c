#include "core/output/convert.h"

#include "core/cloud/frame.h"
#include "core/metrics/uniformity.h"
#include "core/output/notes.h"
#include "core/output/output.h"

#include <math.h>
#include <string.h>

static vor_status measure(struct vor_report *report, const struct vor_cloud *cloud,
                          const struct vor_run *run, struct vor_error *err)
{
    struct vor_uniformity even;
    struct vor_frame frame;
    float *xyz = NULL;
    vor_status status;

    vor_frame_choose(&frame, cloud, NULL);
    status = vor_frame_positions(&xyz, cloud, &frame, run->memory, err);
    VOR_THEN(status, vor_uniformity_measure(&even, xyz, cloud->n, run, err));
    if (status == VOR_OK)
        vor_output_report_uniformity(report, &even, frame.unit);
    vor_free(run->memory, xyz);
    return status;
}

static vor_status copy_faces(struct vor_mesh *out, const struct vor_cloud *in,
                             struct vor_error *err)
{
    size_t size = 3 * sizeof *in->triangles;

    if (in->triangle_count == 0)
        return VOR_OK;
    out->triangle = vor_malloc(out->memory, in->triangle_count, size);
    if (out->triangle == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu triangles", in->triangle_count);
    memcpy(out->triangle, in->triangles, in->triangle_count * size);
    out->count = in->triangle_count;
    out->polygons = in->polygons;
    return VOR_OK;
}

vor_status vor_convert_cloud(struct vor_cloud *out, struct vor_mesh *mesh,
                             struct vor_report *report, const struct vor_cloud *in,
                             const struct vor_spec *spec, const struct vor_run *run,
                             struct vor_error *err)
{
    /* What only a resampling or a measurement tells: it is not known. */
    double *const unknown[] = {&report->delta,
                               &report->sigma,
                               &report->epsilon,
                               &report->delta_beside,
                               &report->area,
                               &report->spacing_mean,
                               &report->min_over_mean,
                               &report->max_over_mean,
                               &report->six_share,
                               &report->bisectors_per_cell,
                               &report->triangles_per_cell};
    struct vor_cloud cloud;
    vor_status status = VOR_OK;

    report->points_in = in->n;
    report->points_out = in->n;
    report->parameters = *spec;
    for (size_t i = 0; i < sizeof unknown / sizeof unknown[0]; i++)
        *unknown[i] = (double)NAN;
    if (spec->value[VOR_PARAM_FORMAT] == VOR_FORMAT_DRC &&
        spec->value[VOR_PARAM_QUANTIZATION] == VOR_UNSET)
        status = measure(report, in, run, err);
    if (status != VOR_OK)
        return status;
    vor_cloud_init(&cloud, out->memory);
    status = vor_cloud_copy(&cloud, in, err);
    VOR_THEN(status, copy_faces(mesh, in, err));
    if (status == VOR_OK) {
        vor_output_report_notes(report, in);
        *out = cloud;
    } else {
        vor_cloud_free(&cloud);
    }
    return status;
}
