#include "core/cloud/sift.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The coordinates of a cloud, in either form. */
struct positions {
    float *narrow;
    double *wide;
};

static double coordinate(const struct positions *at, size_t i)
{
    return at->wide != NULL ? at->wide[i] : (double)at->narrow[i];
}

static int is_finite(const struct positions *at, size_t point)
{
    return isfinite(coordinate(at, 3 * point)) && isfinite(coordinate(at, 3 * point + 1)) &&
           isfinite(coordinate(at, 3 * point + 2));
}

static vor_status refuse(const struct positions *at, size_t n, size_t bad, struct vor_error *err)
{
    size_t first = 0, c = 0;
    char value[16];

    while (is_finite(at, first))
        first++;
    while (isfinite(coordinate(at, 3 * first + c)))
        c++;
    /* The sign of what is no number depends on the machine that wrote it. */
    (void)snprintf(value, sizeof value, "%g", fabs(coordinate(at, 3 * first + c)));
    return vor_fail_param(err, VOR_E_NONFINITE, "invalid",
                          "%zu of %zu points have a coordinate that is not finite. The first "
                          "is point %zu: its %c is %s%s. invalid=drop leaves such points out",
                          bad, n, first, "xyz"[c], coordinate(at, 3 * first + c) < 0 ? "-" : "",
                          value);
}

/* Moves the finite points of a column to its beginning; they are told by positions that have not
 * been moved yet. */
static void close_up(void *column, size_t size, const struct positions *at, size_t n)
{
    char *to = column;

    for (size_t i = 0; i < n; i++)
        if (is_finite(at, i)) {
            memmove(to, (const char *)column + i * size, size);
            to += size;
        }
}

/* Gives corners of triangles the numbers that the finite points will have; leaves out triangles
 * with another corner. */
static vor_status renumber(struct vor_cloud *cloud, const struct positions *at,
                           struct vor_error *err)
{
    uint32_t *number = vor_malloc(cloud->memory, cloud->n, sizeof *number), next = 0;
    size_t kept = 0;

    if (number == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", cloud->n);
    for (size_t i = 0; i < cloud->n; i++)
        number[i] = is_finite(at, i) ? next++ : UINT32_MAX;
    for (size_t t = 0; t < cloud->triangle_count; t++) {
        const uint32_t *from = &cloud->triangles[3 * t];
        uint32_t *to = &cloud->triangles[3 * kept];
        int whole = 1;

        for (int k = 0; k < 3; k++) {
            to[k] = number[from[k]];
            whole &= to[k] != UINT32_MAX;
        }
        kept += (size_t)whole;
    }
    if (kept < cloud->triangle_count) /* what is left might look like other polygons */
        cloud->polygons = 0;
    vor_dropped_add(cloud->notes.dropped, &cloud->notes.dropped_count, "face",
                    cloud->triangle_count - kept);
    cloud->triangle_count = kept;
    vor_free(cloud->memory, number);
    return VOR_OK;
}

vor_status vor_cloud_sift(struct vor_cloud *cloud, double *wide, int is_drop, struct vor_error *err)
{
    struct positions at = {cloud->xyz, wide};
    size_t bad = 0;

    for (size_t i = 0; i < cloud->n; i++)
        bad += !is_finite(&at, i);
    if (bad == 0)
        return VOR_OK;
    if (!is_drop)
        return refuse(&at, cloud->n, bad, err);
    if (bad == cloud->n)
        return vor_fail(err, VOR_E_EMPTY,
                        "each of the %zu points has a coordinate that is not finite", cloud->n);
    if (cloud->triangle_count > 0 && renumber(cloud, &at, err) != VOR_OK)
        return VOR_E_NOMEM;
    for (size_t k = 0; k < cloud->attribute_count; k++)
        close_up(cloud->attributes[k].data,
                 cloud->attributes[k].components * vor_type_size(cloud->attributes[k].type), &at,
                 cloud->n);
    if (wide != NULL)
        close_up(wide, 3 * sizeof *wide, &at, cloud->n);
    else
        close_up(cloud->xyz, 3 * sizeof *cloud->xyz, &at, cloud->n);
    cloud->n -= bad;
    cloud->notes.invalid += bad;
    return VOR_OK;
}
