#include "core/method/domain.h"

#include "core/base/linalg.h"
#include "core/base/morton.h"

#include <string.h>

#define LINE_RANK 1e-12 /* variance across over variance along: below it, the cloud is a line */

static void bounds(const float *xyz, size_t n, double low[3], double high[3])
{
    for (int c = 0; c < 3; c++)
        low[c] = high[c] = (double)xyz[c];
    for (size_t i = 3; i < 3 * n; i++) {
        low[i % 3] = fmin(low[i % 3], (double)xyz[i]);
        high[i % 3] = fmax(high[i % 3], (double)xyz[i]);
    }
}

/* Moves the origin only where the cloud is far from it, since a shift costs the small coordinates
 * their last bits. */
static void choose_frame(struct vor_domain *out, const struct vor_cloud *in)
{
    double low[3], high[3], extent = 0, middle = 0, largest = 0;
    int exponent;

    bounds(in->xyz, in->n, low, high);
    for (int c = 0; c < 3; c++) {
        out->shift[c] = (double)(float)(low[c] / 2 + high[c] / 2);
        extent = fmax(extent, high[c] - low[c]);
        middle = fmax(middle, fabs(out->shift[c]));
    }
    for (int c = 0; c < 3; c++) {
        if (middle <= 2 * extent)
            out->shift[c] = 0;
        largest = fmax(largest, fmax(fabs(low[c] - out->shift[c]), fabs(high[c] - out->shift[c])));
    }
    (void)frexp(largest, &exponent);
    out->unit = largest > 0 ? ldexp(1, exponent) : 1;
}

static int same_place(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Normalises, sorts and drops coincident points. */
static vor_status sort_points(struct vor_domain *out, const struct vor_cloud *in,
                              struct vor_error *err)
{
    float *unsorted = vor_malloc(out->memory, in->n, 3 * sizeof *unsorted);
    vor_status status;

    out->xyz = vor_malloc(out->memory, in->n, 3 * sizeof *out->xyz);
    out->source = vor_malloc(out->memory, in->n, sizeof *out->source);
    if (unsorted == NULL || out->xyz == NULL || out->source == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "sorting %zu points", in->n);
        goto done;
    }
    for (size_t i = 0; i < 3 * in->n; i++)
        unsorted[i] = (float)(((double)in->xyz[i] - out->shift[i % 3]) / out->unit);
    status = vor_morton_order(out->source, unsorted, in->n, out->memory, err);
    if (status != VOR_OK)
        goto done;
    out->n = 0;
    for (size_t i = 0; i < in->n; i++) {
        const float *point = &unsorted[3 * (size_t)out->source[i]];

        if (out->n > 0 && same_place(point, &out->xyz[3 * (out->n - 1)]))
            continue;
        memcpy(&out->xyz[3 * out->n], point, 3 * sizeof *point);
        out->source[out->n++] = out->source[i];
    }
done:
    vor_free(out->memory, unsorted);
    return status;
}

static vor_status check_rank(const struct vor_domain *domain, struct vor_error *err)
{
    double mean[3] = {0}, m[6] = {0}, values[3], vectors[3][3];

    if (domain->n < 4)
        return vor_fail(err, VOR_E_DEGENERATE, "the cloud has %zu distinct points, want at least 4",
                        domain->n);
    for (size_t i = 0; i < 3 * domain->n; i++)
        mean[i % 3] += (double)domain->xyz[i];
    for (int c = 0; c < 3; c++)
        mean[c] /= (double)domain->n;
    for (size_t i = 0; i < domain->n; i++) {
        double x = (double)domain->xyz[3 * i] - mean[0],
               y = (double)domain->xyz[3 * i + 1] - mean[1],
               z = (double)domain->xyz[3 * i + 2] - mean[2];

        m[0] += x * x;
        m[1] += x * y;
        m[2] += x * z;
        m[3] += y * y;
        m[4] += y * z;
        m[5] += z * z;
    }
    vor_eigen3(values, vectors, m);
    if (!(values[1] > LINE_RANK * values[2]))
        return vor_fail(err, VOR_E_DEGENERATE,
                        "all %zu distinct points lie on one line, or too near it", domain->n);
    return VOR_OK;
}

vor_status vor_domain_init(struct vor_domain *out, const struct vor_cloud *in,
                           struct vor_memory *memory, struct vor_error *err)
{
    struct vor_domain domain = {.memory = memory};
    vor_status status;

    choose_frame(&domain, in);
    status = sort_points(&domain, in, err);
    if (status == VOR_OK)
        status = check_rank(&domain, err);
    if (status == VOR_OK)
        status = vor_knn_build(&domain.knn, domain.xyz, domain.n, memory, err);
    if (status != VOR_OK) {
        vor_domain_free(&domain);
        return status;
    }
    *out = domain;
    return VOR_OK;
}

void vor_domain_free(struct vor_domain *domain)
{
    vor_knn_free(domain->knn);
    vor_free(domain->memory, domain->source);
    vor_free(domain->memory, domain->xyz);
    domain->knn = NULL;
    domain->source = NULL;
    domain->xyz = NULL;
    domain->n = 0;
}
