#include "core/lop/latent.h"

#include "core/base/linalg.h"
#include "core/lop/weights.h"

#include <string.h>

vor_status vor_lop_latent_init(struct vor_lop_latent *out, const struct vor_lop_samples *samples,
                               size_t n, double sigma_n, double sigma_p, struct vor_error *err)
{
    vor_status status;

    memset(out, 0, sizeof *out);
    out->sigma_p = sigma_p;
    out->scale = vor_lop_scale(sigma_n);
    status = vor_lop_tree_init(&out->tree, samples->memory, err);
    for (size_t i = 0; i < n && status == VOR_OK; i++)
        status = vor_lop_tree_add(&out->tree, (uint32_t)i, &samples->xyz[3 * i],
                                  &samples->normal[3 * i], err);
    return status;
}

void vor_lop_latent_free(struct vor_lop_latent *latent)
{
    vor_lop_tree_free(&latent->tree);
}

/* What the samples around a base say of one normal. */
struct fit {
    double weight;
    double distance;  /* times weight: to move along the normal */
    double normal[3]; /* times weight */
};

static void fit_to(struct fit *fit, const struct vor_lop_latent *latent,
                   const struct vor_lop_gathered *near, const float base[3], const double n[3])
{
    double inverse = 1 / (latent->sigma_p * latent->sigma_p);

    memset(fit, 0, sizeof *fit);
    for (unsigned i = 0; i < near->count; i++) {
        double cosine = 0, along = 0, weight;

        for (int c = 0; c < 3; c++) {
            double normal = (double)near->normal[c][i];

            cosine += n[c] * normal;
            along += (n[c] + normal) / 2 * ((double)near->xyz[c][i] - (double)base[c]);
        }
        weight = vor_lop_near((double)near->distance2[i], inverse) *
                 vor_lop_alike(cosine, latent->scale);
        fit->weight += weight;
        fit->distance += weight * along;
        for (int c = 0; c < 3; c++)
            fit->normal[c] += weight * (double)near->normal[c][i];
    }
}

/* The distance from a base to the surface along n. */
static double distance_of(const struct fit *fit, const float base[3],
                          const struct vor_lop_point *end, const double n[3])
{
    double d = 0;

    if (fit->weight > 0)
        return fit->distance / fit->weight;
    for (int c = 0; c < 3; c++)
        d += n[c] * ((double)end->xyz[c] - (double)base[c]);
    return d;
}

/* The mean normal of a fit; leaves n where there is none. */
static void normal_of(const struct fit *fit, double n[3])
{
    double length = sqrt(vor_dot(fit->normal, fit->normal));

    for (int c = 0; c < 3 && length > 0; c++)
        n[c] = fit->normal[c] / length;
}

void vor_lop_latent_put(struct vor_lop_point *out, const struct vor_lop_latent *latent,
                        const float base[3], const struct vor_lop_point end[2])
{
    struct vor_lop_gathered near;
    struct fit fit[2];
    double n[2][3], d[2];
    int l;

    vor_lop_tree_gather(&near, &latent->tree, base, latent->sigma_p);
    for (l = 0; l < 2; l++) {
        for (int c = 0; c < 3; c++)
            n[l][c] = (double)end[l].normal[c];
        fit_to(&fit[l], latent, &near, base, n[l]);
        d[l] = distance_of(&fit[l], base, &end[l], n[l]);
    }
    l = fabs(d[1]) < fabs(d[0]);
    normal_of(&fit[l], n[l]);
    fit_to(&fit[l], latent, &near, base, n[l]);
    d[l] = distance_of(&fit[l], base, &end[l], n[l]);
    for (int c = 0; c < 3; c++) {
        out->xyz[c] = (float)((double)base[c] + d[l] * n[l][c]);
        out->normal[c] = (float)n[l][c];
    }
}
