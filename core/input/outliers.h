/** Drops outliers, input points that belong to no surface, or pulls them onto it.
 *
 *  Source: none of the papers; Lv 2022 Sec. 3.1 tests for neighbours that are not mutual. On a
 *  surface every point is among the 20 nearest of about 20 others, at a border of half as many. The
 *  20 nearest of a point off the surface have other points nearer to them. A point that is among
 *  the 20 nearest of fewer than six others is an outlier. What is left is searched again, at most
 *  twice, because outliers near each other hide one another.
 *
 *  Outliers that fill the space around the surface are each among the nearest of other outliers. A
 *  point is an outlier too if its 20 nearest lie farther away than usual and are as thick as wide:
 *  around a thin part of a surface they are flat, around a corner half as thick. A torus of 15,000
 *  points, one in 100, 50 or 10 of them anywhere in its box, denoised to 3,000: 0.24, 0.63 and 0.56
 *  rms off the true surface without this rule, 0.0003, 0.0003 and 0.0011 with it.
 *
 *  A closer look also takes points that lie far off the surface of the 20 points around them, or
 *  around the nearest other one: an outlier in a hollow is among the nearest of the points on both
 *  sides. Measured as in outliers.c: bunny recall 0.939, precision 1 without it, 0.994 and 0.997
 *  with it, igea 0.960, 0.999 and 0.995, 0.999; armadillo 0.876, 1 and 0.954, 0.998, where half of
 *  what is missed has come to lie on another part of the surface.
 *
 *  Pulling is Lv 2022, Sec. 3.1, Eq. 5: an outlier goes onto the surface of the neighbours of the
 *  point nearest to it that is none. Departure: that surface is the quadric that fits take
 *  elsewhere, and no outlier goes farther along it than a spacing from that point, so that none
 *  lands beyond the border. */
#ifndef VOR_INPUT_OUTLIERS_H
#define VOR_INPUT_OUTLIERS_H

#include "core/input/domain.h"

/** Drops the outliers from the domain, and indexes it again if there were any. A domain of fewer
 *  than 200 points has none. If more than a quarter of the points would go, they show no surface to
 *  judge them by, and all stay.
 *
 *  @param[out] dropped  how many points
 *
 *  @retval VOR_E_NOMEM 5 n bytes and 32 for each outlier do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the domain is as it was, or must be
 *          freed
 *
 *  O(n log n), 1.5 us a point and search, on the run's pool. The same points for any number of
 *  threads. */
VOR_NODISCARD vor_status vor_outliers_drop(struct vor_domain *domain, size_t *dropped,
                                           const struct vor_run *run, struct vor_error *err);

/** Outliers that were taken out of a domain. */
struct vor_outliers {
    struct vor_memory *memory;
    size_t n;
    float *xyz;       /**< n x 3, normalised */
    uint32_t *source; /**< n: as that of the domain */
};

/** Makes the domain of a cloud without its remote points (input/remote.h), beside which
 *  vor_domain_init could tell no others apart; hands these out as outliers.
 *
 *  @param[out] out     free with vor_outliers_free; untouched on failure
 *  @param[out] domain  as of vor_domain_init
 *
 *  @retval VOR_E_DEGENERATE  none is remote, and err is untouched; or as vor_domain_init
 *  @retval VOR_E_NOMEM 16 bytes a point more than vor_domain_init do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  As vor_domain_init. */
VOR_NODISCARD vor_status vor_outliers_remote(struct vor_outliers *out, struct vor_domain *domain,
                                             const struct vor_cloud *in, const struct vor_run *run,
                                             struct vor_error *err);

/** vor_outliers_drop, and adds what it dropped to those in *out.
 *
 *  @param[in] closer  looks again, up to three times, and then also takes a point that is far off
 *                     the surface of the 20 points around it, or around the nearest other one:
 *                     farther than six times their residual and half a spacing. 11 us a point and
 *                     look
 *  @param[in,out] out  has its memory, and may have outliers; free with vor_outliers_free
 *
 *  Fails as vor_outliers_drop. */
VOR_NODISCARD vor_status vor_outliers_take(struct vor_outliers *out, struct vor_domain *domain,
                                           int closer, const struct vor_run *run,
                                           struct vor_error *err);

/** Moves outliers that were taken out onto the surface, puts them into the domain, and indexes it
 *  again. Fits are as domain->known says; lists of neighbours (domain->graph) are not brought up to
 *  date.
 *
 *  @retval VOR_E_NOMEM 16 bytes for each point and 20 for each outlier do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for; the domain may have to be freed
 *
 *  O(n), on the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_outliers_pull(struct vor_domain *domain,
                                           const struct vor_outliers *outliers,
                                           const struct vor_run *run, struct vor_error *err);

/** outliers may be all zero. */
void vor_outliers_free(struct vor_outliers *outliers);

#endif
