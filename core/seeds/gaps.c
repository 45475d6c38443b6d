#include "core/seeds/gaps.h"

#include "core/base/linalg.h"

#include <string.h>

/* Pitches beyond `wide` that count at most. Half and double move no figure beyond the spread. */
#define EXCESS VOR_GAP_PULL
/* Pitches from the middle of a gap to the seeds around it, once it is narrowed. Mean of four seeds,
 * a sphere of 200,000 random points to 5,072 and fandisk, 100,000 random points to 5,000, nothing
 * narrowed and at 0.67 / 0.69 / 0.71: largest gap of the sphere 0.703 and 0.704 / 0.691 / 0.712
 * spacings, delta 0.0148 and 0.0155 / 0.0147 / 0.0148, of fandisk 0.0213 and 0.0221 / 0.0216 /
 * 0.0215. */
#define LEFT 0.69
/* A wider one stays: what keeps it open, as a crease does, keeps the seeds from closing it. At 0.72
 * / 0.75: largest gap of the sphere, 60 seeds, 0.698 (up to 0.757) / 0.694 (0.710), delta of
 * fandisk 0.0220 / 0.0228. At 0.705 the gap is 0.703. */
#define STAYS 0.75

struct narrow {
    struct vor_gaps gaps;
    struct vor_seeds *seeds;
    const struct vor_recall *recall;
    float *next;
};

void vor_gaps_find(const struct vor_gaps *gaps, const struct vor_seeds *seeds,
                   const struct vor_scratch *scratch, size_t i)
{
    const struct vor_surface *surface = &scratch->here.surface;
    const struct vor_stretch *stretch =
        vor_stretched_are(&seeds->stretched) ? &scratch->stretch : NULL;
    double far2;
    const double *corner = vor_stretch_farthest(&scratch->cell, stretch, &far2);
    double pitch = gaps->pitch * vor_wanted_at(&seeds->wanted, i);
    double far, excess;

    memset(&gaps->pull[3 * i], 0, 3 * sizeof *gaps->pull);
    if (corner == NULL)
        return;
    far = sqrt(far2);
    gaps->quiet[i] = far < gaps->wide * pitch;
    excess = fmin(far - gaps->wide * pitch, EXCESS * pitch);
    if (!(excess > 0))
        return;
    for (int c = 0; c < 3; c++)
        gaps->pull[3 * i + (size_t)c] =
            (float)(gaps->share * excess / far *
                    (corner[0] * surface->axis[0][c] + corner[1] * surface->axis[1][c] +
                     corner[2] * surface->axis[2][c]));
}

/* Moves seed i by its pull, along its surface. */
static void narrow(const struct narrow *narrow, struct vor_scratch *scratch, size_t i)
{
    const struct vor_gaps *gaps = &narrow->gaps;
    const struct vor_seeds *seeds = narrow->seeds;
    double most = (STAYS - LEFT) * gaps->pitch * vor_wanted_at(&seeds->wanted, i);
    double x[3], y[3], v[3], local[3], normal[3];

    vor_to_doubles(v, &gaps->pull[3 * i]);
    if (vor_dot(v, v) > most * most)
        return;
    vor_seeds_position(seeds, i, x);
    vor_surface_to_local(&scratch->onto, x, local);
    vor_surface_normal(&scratch->onto, local, normal);
    vor_remove_along(v, normal, 0);
    for (int c = 0; c < 3; c++)
        y[c] = x[c] + v[c];
    vor_surface_put(&scratch->onto, y);
    vor_to_floats(&narrow->next[3 * i], y);
}

static void narrow_block(void *ctx, size_t begin, size_t end, unsigned worker)
{
    struct narrow *all = ctx;
    struct vor_seeds *seeds = all->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];

    for (size_t i = begin; i < end; i++) {
        memcpy(&all->next[3 * i], &seeds->xyz[3 * i], 3 * sizeof(float));
        if (all->gaps.quiet[i] ||
            vor_seeds_recall(seeds, scratch, i, all->recall) == VOR_SURFACE_NONE ||
            !scratch->interior)
            continue;
        vor_seeds_crowd(seeds, scratch, i);
        vor_seeds_clip(seeds, scratch, i, 0);
        vor_gaps_find(&all->gaps, seeds, scratch, i);
        narrow(all, scratch, i);
    }
}

vor_status vor_gaps_narrow(const struct vor_gaps *gaps, struct vor_seeds *seeds, float *next,
                           const struct vor_recall *recall, struct vor_error *err)
{
    struct narrow all = {.gaps = *gaps, .seeds = seeds, .recall = recall, .next = next};
    size_t moving = vor_seeds_moving(seeds);
    vor_status status = vor_seeds_index(seeds, &seeds->run, err);

    all.gaps.wide = LEFT;
    all.gaps.share = 1;
    if (status == VOR_OK)
        status = vor_run_for(&seeds->run, moving, vor_seeds_block(seeds->domain), narrow_block,
                             &all, err);
    if (status == VOR_OK)
        memcpy(seeds->xyz, next, 3 * moving * sizeof *seeds->xyz);
    return status;
}
