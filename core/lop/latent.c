#include "core/lop/latent.h"

#include "core/base/linalg.h"
#include "core/base/vector.h"
#include "core/geom/fillet.h"
#include "core/lop/weights.h"

#include <string.h>

/* Times that the planes of both sides are fitted around the place where they meet: the second time
 * around the edge itself. */
enum { EDGE_TIMES = 2 };
/* Share of the samples around a base that a side needs, by weight. Families of shapes with edges,
 * noise of 0.3 spacings and outliers, normals inwards in 1,000 at 0 / 0.1 / 0.2 / 0.3: cad_block
 * 19 / 12 / 12 / 9, gear 24 / 9 / 5 / 4, screw 12 / 10 / 6 / 4; from the screw's edge to the
 * nearest point .377 / .374 / .383 / .393 spacings. */
#define SHARE 0.1

vor_status vor_lop_latent_init(struct vor_lop_latent *out, const struct vor_lop_samples *samples,
                               double sigma_n, double sigma_p, const struct vor_run *run,
                               struct vor_error *err)
{
    memset(out, 0, sizeof *out);
    out->sigma_p = sigma_p;
    out->scale = vor_lop_scale(sigma_n);
    return vor_lop_tree_build(&out->tree, samples, run, err);
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

/* What each of the samples gathered says: how much it counts, and how far away its plane is. */
VOR_CLONES static void weigh(double *restrict weight, double *restrict along,
                             const struct vor_lop_latent *latent,
                             const struct vor_lop_gathered *near, const float base[3],
                             const double n[3])
{
    double inverse = 1 / (latent->sigma_p * latent->sigma_p), scale = latent->scale;
    double n0 = n[0], n1 = n[1], n2 = n[2];
    double b0 = (double)base[0], b1 = (double)base[1], b2 = (double)base[2];

    for (unsigned i = 0; i < near->count; i++) {
        double m0 = (double)near->normal[0][i], m1 = (double)near->normal[1][i],
               m2 = (double)near->normal[2][i];
        double cosine = n0 * m0 + n1 * m1 + n2 * m2;

        along[i] = (n0 + m0) / 2 * ((double)near->xyz[0][i] - b0) +
                   (n1 + m1) / 2 * ((double)near->xyz[1][i] - b1) +
                   (n2 + m2) / 2 * ((double)near->xyz[2][i] - b2);
        weight[i] =
            vor_lop_near((double)near->distance2[i], inverse) * vor_lop_alike(cosine, scale);
    }
}

static void fit_to(struct fit *fit, const struct vor_lop_latent *latent,
                   const struct vor_lop_gathered *near, const float base[3], const double n[3])
{
    double weight[VOR_LOP_GATHERED_MAX], along[VOR_LOP_GATHERED_MAX];

    /* gcc's analyzer cannot see that weigh fills them */
    memset(weight, 0, near->count * sizeof *weight);
    memset(along, 0, near->count * sizeof *along);
    memset(fit, 0, sizeof *fit);
    weigh(weight, along, latent, near, base, n);
    for (unsigned i = 0; i < near->count; i++) {
        fit->weight += weight[i];
        fit->distance += weight[i] * along[i];
        for (int c = 0; c < 3; c++)
            fit->normal[c] += weight[i] * (double)near->normal[c][i];
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

/* The place and the normal that a fit of the normal n gives, which the mean of the samples that
 * count first takes the place of. */
static void put_onto(struct vor_lop_point *out, const struct vor_lop_latent *latent,
                     const struct vor_lop_gathered *near, const float base[3],
                     const struct vor_lop_point *end, const struct fit *first)
{
    struct fit fit;
    double n[3], d, length = sqrt(vor_dot(first->normal, first->normal));

    vor_to_doubles(n, end->normal);
    for (int c = 0; c < 3 && length > 0; c++)
        n[c] = first->normal[c] / length;
    fit_to(&fit, latent, near, base, n);
    d = distance_of(&fit, base, end, n);
    for (int c = 0; c < 3; c++) {
        out->xyz[c] = (float)((double)base[c] + d * n[c]);
        out->normal[c] = (float)n[c];
    }
}

/* A fit of an end's own normal; returns how far away the surface is along it. */
static double fit_end(struct fit *fit, const struct vor_lop_latent *latent,
                      const struct vor_lop_gathered *near, const float base[3],
                      const struct vor_lop_point *end)
{
    double n[3] = {(double)end->normal[0], (double)end->normal[1], (double)end->normal[2]};

    fit_to(fit, latent, near, base, n);
    return distance_of(fit, base, end, n);
}

/* Whether enough of the samples around a base are of a fit's side, of those that do not face away:
 * a sample of a wrong normal has none of its kind around. */
static int holds(const struct fit *fit, const struct vor_lop_latent *latent,
                 const struct vor_lop_gathered *near, const struct vor_lop_point *end)
{
    double inverse = 1 / (latent->sigma_p * latent->sigma_p), all = 0;

    for (unsigned i = 0; i < near->count; i++) {
        double cosine = 0;

        for (int c = 0; c < 3; c++)
            cosine += (double)end->normal[c] * (double)near->normal[c][i];
        if (cosine >= -VOR_SAME_WAY)
            all += vor_lop_near((double)near->distance2[i], inverse);
    }
    return fit->weight >= SHARE * all;
}

int vor_lop_latent_put(struct vor_lop_point *out, const struct vor_lop_latent *latent,
                       const float base[3], const struct vor_lop_point end[2])
{
    struct vor_lop_gathered near;
    struct fit fit[2];
    double d[2];
    int l;

    vor_lop_tree_gather(&near, &latent->tree, base, latent->sigma_p);
    for (l = 0; l < 2; l++)
        d[l] = fit_end(&fit[l], latent, &near, base, &end[l]);
    l = fabs(d[1]) < fabs(d[0]);
    put_onto(out, latent, &near, base, &end[l], &fit[l]);
    return holds(&fit[l], latent, &near, &end[l]);
}

void vor_lop_latent_side(struct vor_lop_point *out, const struct vor_lop_latent *latent,
                         const float base[3], const struct vor_lop_point *end)
{
    struct vor_lop_gathered near;
    struct fit fit;

    vor_lop_tree_gather(&near, &latent->tree, base, latent->sigma_p);
    (void)fit_end(&fit, latent, &near, base, end);
    put_onto(out, latent, &near, base, end, &fit);
}

/* The place nearest to x where two planes meet, each through a point across its normal. */
static int meet(float x[3], double along[3], double *cosine, const struct vor_lop_point plane[2])
{
    double n[2][3], off[2], rest, length;

    for (int l = 0; l < 2; l++) {
        off[l] = 0;
        for (int c = 0; c < 3; c++) {
            n[l][c] = (double)plane[l].normal[c];
            off[l] += n[l][c] * ((double)plane[l].xyz[c] - (double)x[c]);
        }
    }
    *cosine = vor_dot(n[0], n[1]);
    rest = 1 - *cosine * *cosine;
    vor_cross(along, n[0], n[1]);
    length = sqrt(vor_dot(along, along));
    if (!(rest > VOR_NEGLIGIBLE))
        return 0;
    for (int c = 0; c < 3; c++) {
        x[c] = (float)((double)x[c] + ((off[0] - *cosine * off[1]) * n[0][c] +
                                       (off[1] - *cosine * off[0]) * n[1][c]) /
                                          rest);
        along[c] /= length;
    }
    return 1;
}

int vor_lop_latent_edge(float foot[3], float along[3], double *cosine,
                        const struct vor_lop_latent *latent, const float base[3],
                        const struct vor_lop_point end[2])
{
    double direction[3] = {0};

    memcpy(foot, base, 3 * sizeof *foot);
    for (int time = 0; time < EDGE_TIMES; time++) {
        struct vor_lop_point plane[2];

        for (int l = 0; l < 2; l++)
            vor_lop_latent_side(&plane[l], latent, foot, &end[l]);
        if (!meet(foot, direction, cosine, plane))
            return 0;
    }
    vor_to_floats(along, direction);
    return 1;
}
