#include "core/output/transfer.h"

#include "core/base/linalg.h"
#include "core/input/carried.h"
#include "core/output/blend.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Steps of float32 that a spacing must have for positions in float32. Rounding of both ends then
 * adds at most 0.41 / 200 = 0.002 to delta (rms), a tenth of what the most even results have; 0.004
 * at half of it, 0.001 at double. Draco's quantization=auto uses the same number. */
#define STEPS_PER_SPACING 200

struct transfer {
    struct vor_cloud *out;
    const struct vor_cloud *in;
    struct vor_seeds *seeds;
    const struct vor_transfer_how *how;
    size_t kept;       /* points of out before those of seeds that are the input's, as they are; the
                          seeds that do not move are left out then */
    uint32_t *nearest; /* input point nearest to each point of out */
    float *normal;     /* of each, x 3, or NULL */
    const struct vor_attribute
        *carried; /* that decide the sides of the method's normals, or NULL */
};

/* The normal of the local surface at x. */
static void surface_normal(const struct vor_scratch *scratch, const double x[3], double normal[3])
{
    double local[3];

    normal[0] = normal[1] = 0;
    normal[2] = 1;
    if (scratch->here.surface.kind == VOR_SURFACE_NONE)
        return;
    vor_surface_to_local(&scratch->here.surface, x, local);
    vor_surface_normal(&scratch->here.surface, local, normal);
}

/* The normal that the method found, on the side of the carried one if that is to decide. Returns
 * whether there is one. */
static int take_normal(struct transfer *transfer, size_t i)
{
    const struct vor_attribute *carried = transfer->carried;
    const float *found = &transfer->seeds->normal[3 * i];
    double is[3] = {(double)found[0], (double)found[1], (double)found[2]}, other[3];
    int turn = carried != NULL && vor_carried_normal(carried, transfer->nearest[i], other) &&
               vor_dot(is, other) < 0;

    for (size_t c = 0; c < 3; c++)
        transfer->normal[3 * i + c] = turn ? -found[c] : found[c];
    return vor_dot(is, is) > 0;
}

/* Points of islands are none of the method's: their normals have no certain side. */
static void make_normal(struct transfer *transfer, const struct vor_scratch *scratch, size_t i,
                        const float x[3])
{
    double fitted[3], at[3];

    if (transfer->seeds->normal != NULL && take_normal(transfer, i))
        return;
    vor_to_doubles(at, x);
    surface_normal(scratch, at, fitted);
    if (transfer->seeds->normal == NULL)
        vor_sides_normal(&transfer->normal[3 * i], transfer->how->sides, x, transfer->nearest[i],
                         fitted);
    for (size_t c = 0; c < 3 && transfer->seeds->normal != NULL; c++)
        transfer->normal[3 * i + c] = (float)fitted[c];
}

/* Point i of the result is point i of the input. */
static void keep(struct transfer *transfer, struct vor_scratch *scratch, size_t i)
{
    float x[3];
    double at[3];

    transfer->nearest[i] = (uint32_t)i;
    if (transfer->normal == NULL)
        return;
    vor_domain_normalise(transfer->seeds->domain, &transfer->in->xyz[3 * i], x);
    vor_to_doubles(at, x);
    (void)vor_seeds_fit_at(transfer->seeds, scratch, &scratch->here, at);
    make_normal(transfer, scratch, i, x);
}

static void transfer_row(void *ctx, size_t i, unsigned worker)
{
    struct transfer *transfer = ctx;
    struct vor_seeds *seeds = transfer->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];
    uint32_t index;
    float distance2;
    size_t seed = i - transfer->kept;

    if (i < transfer->kept) {
        keep(transfer, scratch, i);
        return;
    }
    if (transfer->normal == NULL && vor_run_is_late(&seeds->run)) {
        vor_knn_search(seeds->domain->knn, &seeds->xyz[3 * seed], 1, 1, &index, &distance2);
        transfer->nearest[i] = seeds->domain->source[index];
        return;
    }
    (void)vor_seeds_fit(seeds, scratch, seed);
    transfer->nearest[i] = seeds->domain->source[vor_seeds_nearest(seeds, seed)];
    if (transfer->normal != NULL)
        make_normal(transfer, scratch, i, &seeds->xyz[3 * seed]);
}

static void place(struct transfer *transfer, double spacing)
{
    const struct vor_domain *domain = transfer->seeds->domain;
    struct vor_cloud *out = transfer->out;
    double shift[3], far = 0; /* the far end of the cloud, where float32 is coarsest */

    out->position_type = transfer->in->position_type;
    for (int c = 0; c < 3; c++) {
        shift[c] = domain->shift[c];
        far = fmax(far, fabs(shift[c]) + domain->unit);
        out->origin[c] = transfer->in->origin[c];
    }
    if (out->position_type == VOR_FLOAT32 && spacing > 0 && transfer->kept == 0 &&
        far * (double)FLT_EPSILON * STEPS_PER_SPACING > spacing) {
        out->position_type = VOR_FLOAT64;
        for (int c = 0; c < 3; c++) {
            out->origin[c] += shift[c];
            shift[c] = 0;
        }
    }
    memcpy(out->xyz, transfer->in->xyz, 3 * transfer->kept * sizeof *out->xyz);
    for (size_t i = 3 * transfer->kept; i < 3 * out->n; i++) {
        double x =
            (double)transfer->seeds->xyz[i - 3 * transfer->kept] * domain->unit + shift[i % 3];

        /* A seed may lie outside an input that fills the range of float32. */
        out->xyz[i] = (float)fmax(-(double)FLT_MAX, fmin(x, (double)FLT_MAX));
    }
}

/* Takes the coordinates of points that are kept as their doubles, where they are more exact. */
static vor_status keep_exact(struct transfer *transfer, struct vor_error *err)
{
    struct vor_cloud *out = transfer->out;

    if (transfer->kept == 0 || transfer->in->exact == NULL)
        return VOR_OK;
    out->exact = vor_malloc(out->memory, out->n, 3 * sizeof *out->exact);
    if (out->exact == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", out->n);
    memcpy(out->exact, transfer->in->exact, 3 * transfer->kept * sizeof *out->exact);
    for (size_t i = 3 * transfer->kept; i < 3 * out->n; i++)
        out->exact[i] = out->origin[i % 3] + (double)out->xyz[i];
    return VOR_OK;
}

vor_status vor_transfer_attributes(struct vor_cloud *out, const struct vor_cloud *in,
                                   const uint32_t *source, const float *normal,
                                   const struct vor_spec *spec, struct vor_error *err)
{
    int keep_normals = spec->value[VOR_PARAM_NORMALS] == VOR_NORMALS_NEAREST && normal == NULL;
    int keep_others = spec->value[VOR_PARAM_ATTRIBUTES] != VOR_ATTRIBUTES_DROP;
    struct vor_attribute *to;
    vor_status status = VOR_OK;

    for (size_t i = 0; i < in->attribute_count && status == VOR_OK; i++)
        if (keep_others && (in->attributes[i].semantic != VOR_NORMAL || keep_normals))
            status = vor_cloud_copy_attribute(out, &in->attributes[i], source, err);
    if (status != VOR_OK || normal == NULL)
        return status;
    status = vor_cloud_add_attribute(out, "normal", VOR_NORMAL, VOR_FLOAT32, 3, &to, err);
    if (status == VOR_OK)
        memcpy(to->data, normal, 3 * out->n * sizeof *normal);
    return status;
}

vor_status vor_transfer_number(struct vor_cloud *cloud, struct vor_error *err)
{
    struct vor_attribute *track, first;
    vor_status status =
        vor_cloud_add_attribute(cloud, VOR_TRACK, VOR_GENERIC, VOR_UINT32, 1, &track, err);

    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < cloud->n; i++)
        ((uint32_t *)track->data)[i] = (uint32_t)i;
    first = *track;
    memmove(&cloud->attributes[1], cloud->attributes,
            (cloud->attribute_count - 1) * sizeof *cloud->attributes);
    cloud->attributes[0] = first;
    return VOR_OK;
}

void vor_transfer_keep_common(struct vor_cloud *cloud, const struct vor_cloud *previous)
{
    size_t kept = 0;

    for (size_t i = 0; i < cloud->attribute_count; i++) {
        const char *name = cloud->attributes[i].name;

        if (strcmp(name, VOR_TRACK) != 0 && vor_cloud_find_name(previous, name) == NULL)
            vor_free(cloud->memory, cloud->attributes[i].data);
        else
            cloud->attributes[kept++] = cloud->attributes[i];
    }
    cloud->attribute_count = kept;
}

/* Adds the tracks, before an attribute of that name that the input may have. */
static vor_status add_track(struct vor_cloud *out, const struct vor_seeds *seeds,
                            struct vor_error *err)
{
    struct vor_attribute *to;
    vor_status status;

    if (seeds->track == NULL)
        return VOR_OK;
    status = vor_cloud_add_attribute(out, VOR_TRACK, VOR_GENERIC, VOR_UINT32, 1, &to, err);
    if (status == VOR_OK)
        memcpy(to->data, seeds->track, seeds->n * sizeof *seeds->track);
    return status;
}

vor_status vor_transfer(struct vor_cloud *out, const struct vor_cloud *in, struct vor_seeds *seeds,
                        const struct vor_transfer_how *how, struct vor_error *err)
{
    const struct vor_run *run = &seeds->run;
    struct vor_cloud cloud;
    int inserted = how->spec->value[VOR_PARAM_METHOD] == VOR_METHOD_INSERT;
    struct transfer transfer = {&cloud, in, seeds, how, inserted ? in->n : 0, NULL, NULL, NULL};
    size_t n = transfer.kept + (inserted ? vor_seeds_moving(seeds) : seeds->n);
    int fit = vor_sides_asked(how->spec) ||
              (seeds->normal != NULL && how->spec->value[VOR_PARAM_NORMALS] != VOR_NORMALS_DROP);
    vor_status status;

    vor_cloud_init(&cloud, run->memory);
    if (how->spec->value[VOR_PARAM_INPUT_NORMALS] != VOR_INPUT_NORMALS_ESTIMATE)
        transfer.carried = vor_carried(in);
    transfer.nearest = vor_malloc(run->memory, n, sizeof *transfer.nearest);
    if (fit)
        transfer.normal = vor_malloc(run->memory, n, 3 * sizeof *transfer.normal);
    if (transfer.nearest == NULL || (fit && transfer.normal == NULL)) {
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", n);
        goto done;
    }
    status = vor_cloud_resize(&cloud, n, err);
    if (status != VOR_OK)
        goto done;
    status = vor_run_rows(run, n, VOR_SEEDS_BLOCK, transfer_row, &transfer, err);
    if (status != VOR_OK)
        goto done;
    place(&transfer, how->spacing);
    status = keep_exact(&transfer, err);
    VOR_THEN(status, add_track(&cloud, seeds, err));
    VOR_THEN(status, vor_transfer_attributes(&cloud, in, transfer.nearest, transfer.normal,
                                             how->spec, err));
    if (how->spec->value[VOR_PARAM_ATTRIBUTES] == VOR_ATTRIBUTES_BLEND)
        VOR_THEN(status, vor_blend(&cloud, transfer.kept, in, seeds, err));
    if (status != VOR_OK)
        goto done;
    *out = cloud;
    vor_cloud_init(&cloud, run->memory);
done:
    VOR_FREE_ALL(run->memory, transfer.normal, transfer.nearest);
    vor_cloud_free(&cloud);
    return status;
}
