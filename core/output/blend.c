#include "core/output/blend.h"

#include "core/geom/patch.h"
#include "core/knn/places.h"

#include <float.h>
#include <math.h>
#include <string.h>

struct blend {
    const struct vor_seeds *seeds;
    struct vor_attribute *to;
    const struct vor_attribute *from;
    size_t first;
};

/* Input points around seed i, on its sheet if it has one of several: so many. */
static unsigned find_around(const struct vor_seeds *seeds, size_t i,
                            uint32_t index[VOR_PATCH_HEXAGON])
{
    const float *x = &seeds->xyz[3 * i];
    float distance2[VOR_PATCH_HEXAGON];
    unsigned count = vor_input_lists_around(&seeds->input_lists, i, x, VOR_PATCH_HEXAGON, index);

    if (count > 0)
        return count;
    count = vor_domain_most(seeds->domain, VOR_PATCH_HEXAGON);
    vor_knn_search(seeds->domain->knn, x, 1, count, index, distance2);
    return count;
}

static void blend_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct blend *blend = ctx;
    const struct vor_domain *domain = blend->seeds->domain;
    uint32_t index[VOR_PATCH_HEXAGON];
    double weight[VOR_PATCH_HEXAGON], sum = 0;
    struct vor_mix mix = {index, weight, find_around(blend->seeds, i, index)};

    for (unsigned k = 0; k < mix.count; k++) {
        double d2 = vor_distance2f(&blend->seeds->xyz[3 * i], vor_domain_point(domain, index[k]));

        weight[k] = 1 / fmax(d2, (double)FLT_MIN);
        sum += weight[k];
        index[k] = domain->source[index[k]];
    }
    for (unsigned k = 0; k < mix.count; k++)
        weight[k] /= sum;
    vor_attribute_mix(blend->to, blend->first + i, blend->from, &mix);
}

/* Gives the first of the points in each place the mean of their values. */
static vor_status mix_places(struct vor_attribute *to, const struct vor_attribute *from,
                             const struct vor_places *places, struct vor_error *err)
{
    size_t n = places->first[places->n];
    double *weight = vor_malloc(places->memory, n, sizeof *weight);

    if (weight == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    for (size_t i = 0; i < places->n; i++) {
        const uint32_t *point = &places->point[places->first[i]];
        const struct vor_mix mix = {point, weight, places->first[i + 1] - places->first[i]};

        for (unsigned k = 0; k < mix.count; k++)
            weight[k] = 1 / (double)mix.count;
        vor_attribute_mix(to, point[0], from, &mix);
    }
    vor_free(places->memory, weight);
    return VOR_OK;
}

/* Gives the rows of an attribute after the first ones the means of values of n points. */
static vor_status blend_values(struct blend blend, size_t rows, size_t n,
                               const struct vor_places *places, struct vor_error *err)
{
    const struct vor_run *run = &blend.seeds->run;
    const struct vor_attribute *from = blend.from;
    struct vor_attribute means = *from;
    size_t size = from->components * vor_type_size(from->type);
    vor_status status = VOR_OK;

    if (places->n > 0) {
        means.data = vor_malloc(run->memory, n, size);
        if (means.data == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
        memcpy(means.data, from->data, n * size);
        blend.from = &means;
        status = mix_places(&means, from, places, err);
    }
    VOR_THEN(status, vor_run_rows(run, rows, VOR_SEEDS_BLOCK, blend_row, &blend, err));
    if (places->n > 0)
        vor_free(run->memory, means.data);
    return status;
}

vor_status vor_blend(struct vor_cloud *out, size_t first, const struct vor_cloud *in,
                     const struct vor_seeds *seeds, struct vor_error *err)
{
    struct vor_places places = {.n = 0};
    vor_status status = VOR_OK;

    if (vor_cloud_find(in, VOR_COLOR) != NULL)
        status = vor_places_find(&places, in->xyz, in->n, 1, seeds->run.memory, err);
    for (size_t i = 0; i < in->attribute_count && status == VOR_OK; i++) {
        const struct vor_attribute *from = &in->attributes[i];
        struct blend blend = {seeds, NULL, from, first};

        for (size_t k = 0; k < out->attribute_count; k++)
            if (strcmp(out->attributes[k].name, from->name) == 0)
                blend.to = &out->attributes[k];
        if (from->semantic == VOR_COLOR && blend.to != NULL)
            status = blend_values(blend, out->n - first, in->n, &places, err);
    }
    vor_places_free(&places);
    return status;
}
