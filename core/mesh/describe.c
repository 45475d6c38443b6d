#include "core/mesh/describe.h"

#include "core/base/linalg.h"
#include "core/base/stat.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Share of the triangles below mesh.quality_p001. */
#define QUANTILE_TOLD 0.001

/* Whether no edge has more than two triangles, and those at every point are one fan. */
static int is_manifold(const struct vor_complex *complex)
{
    unsigned char fan[VOR_AROUND_MOST];
    uint32_t third[2], other[2];

    for (size_t i = 0; i < complex->n; i++) {
        if (vor_complex_fans(complex, (uint32_t)i, fan) > 1)
            return 0;
        for (unsigned t = 0; t < complex->degree[i]; t++) {
            vor_complex_others(complex, complex->around[i * VOR_AROUND_MOST + t], (uint32_t)i,
                               other);
            for (int o = 0; o < 2; o++)
                if (vor_complex_edge(complex, (uint32_t)i, other[o], third) > 2)
                    return 0;
        }
    }
    return 1;
}

static void count(struct vor_report *report, const struct vor_complex *complex,
                  const struct vor_rims *rims, const struct vor_sheet *sheet)
{
    uint64_t rim = rims->count > 0 ? rims->start[rims->count] : 0;

    for (size_t t = 0; t < complex->count; t++) {
        if (complex->triangle[3 * t] == VOR_COMPLEX_GONE)
            continue;
        report->mesh_triangles++;
        report->mesh_unsure += vor_sheet_doubts(sheet, &complex->triangle[3 * t]) != 0;
    }
    for (size_t i = 0; i < complex->n; i++)
        report->mesh_points += complex->degree[i] > 0;
    report->mesh_euler = (double)report->mesh_points + (double)report->mesh_triangles -
                         (double)(3 * report->mesh_triangles + rim) / 2;
    report->mesh_loops = rims->count;
    report->mesh_closed = rim == 0 && report->mesh_triangles > 0 ? VOR_YES : VOR_NO;
    report->mesh_manifold = is_manifold(complex) ? VOR_YES : VOR_NO;
}

void vor_mesh_note(struct vor_record *record, const struct vor_complex *complex, const float *xyz)
{
    double quality = 0, angle = 0;
    size_t count = 0;

    for (size_t t = 0; t < complex->count; t++) {
        const uint32_t *corner = &complex->triangle[3 * t];

        if (corner[0] == VOR_COMPLEX_GONE)
            continue;
        quality += vor_triangle_quality(xyz, corner);
        angle += acos(vor_triangle_sharpest(xyz, corner)) * 180 / M_PI;
        count++;
    }
    record->quality = count > 0 ? quality / (double)count : 0;
    record->angle = count > 0 ? angle / (double)count : 0;
}

static vor_status rate(struct vor_report *report, const struct vor_complex *complex,
                       const float *xyz, struct vor_error *err)
{
    float *quality = vor_malloc(complex->memory, report->mesh_triangles, sizeof *quality);
    double sum = 0, sharpest = -1;
    size_t rated = 0;

    if (quality == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the quality of the triangles");
    for (size_t t = 0; t < complex->count; t++) {
        const uint32_t *corner = &complex->triangle[3 * t];

        if (corner[0] == VOR_COMPLEX_GONE)
            continue;
        quality[rated] = (float)vor_triangle_quality(xyz, corner);
        sum += (double)quality[rated++];
        sharpest = fmax(sharpest, vor_triangle_sharpest(xyz, corner));
    }
    if (rated > 0) {
        vor_sort_floats(quality, rated);
        report->mesh_quality_mean = sum / (double)rated;
        report->mesh_quality_p001 = vor_quantile(quality, rated, QUANTILE_TOLD);
        report->mesh_quality_min = (double)quality[0];
        report->mesh_angle_min = acos(sharpest) * 180 / M_PI;
    }
    vor_free(complex->memory, quality);
    return VOR_OK;
}

/* A loop in the cloud's own unit and coordinates. */
static struct vor_mesh_loop loop_of(const struct vor_rims *rims, size_t l,
                                    const struct vor_seeds *seeds)
{
    const struct vor_domain *domain = seeds->domain;
    size_t first = rims->start[l], edges = rims->start[l + 1] - first;
    struct vor_mesh_loop loop = {.edges = edges};

    for (size_t e = 0; e < edges; e++) {
        const float *a = &seeds->xyz[3 * (size_t)rims->point[first + e]];
        const float *b = &seeds->xyz[3 * (size_t)rims->point[first + (e + 1) % edges]];

        loop.length += sqrt(vor_distance2f(a, b)) * domain->unit;
        for (int c = 0; c < 3; c++)
            loop.middle[c] += (double)a[c] / (double)edges;
    }
    for (int c = 0; c < 3; c++)
        loop.middle[c] = loop.middle[c] * domain->unit + domain->shift[c];
    return loop;
}

vor_status vor_mesh_describe(struct vor_report *report, const struct vor_complex *complex,
                             const struct vor_rims *rims, const struct vor_sheet *sheet,
                             struct vor_error *err)
{
    count(report, complex, rims, sheet);
    /* Tells the loops with most edges, of those with as many the first. */
    for (size_t l = 0; l < rims->count; l++) {
        size_t edges = rims->start[l + 1] - rims->start[l];
        unsigned at = report->mesh_longest_count;

        if (at == VOR_MESH_LOOPS_TOLD && report->mesh_longest[at - 1].edges >= edges)
            continue;
        at -= at == VOR_MESH_LOOPS_TOLD;
        for (; at > 0 && report->mesh_longest[at - 1].edges < edges; at--)
            report->mesh_longest[at] = report->mesh_longest[at - 1];
        report->mesh_longest[at] = loop_of(rims, l, sheet->seeds);
        report->mesh_longest_count += report->mesh_longest_count < VOR_MESH_LOOPS_TOLD;
    }
    return rate(report, complex, sheet->seeds->xyz, err);
}
