/** The latent surface: what oriented samples say of the surface that they lie on, with its edges.
 *  A place near it and a normal that says which side of an edge is meant are put onto it.
 *
 *  Source: Huang et al. 2013, "Edge-aware point set resampling", Sec. 5, Eq. 4, and one step of
 *  Eq. 2. With errata: Eq. 4 has n (p_i - b), and the endpoint with the smaller |d_k| is chosen.
 *
 *  Departure: only the samples that the insertion began with say where the surface is, not the
 *  points inserted. Those lie on it by them; counting them too adds up their errors, and makes the
 *  weights depend on the order of insertion.
 *
 *  Departure: the distance along n is that to (n + n_i) / 2 . (p_i - b), which is exact on a
 *  sphere: with n alone the points of a convex surface sink by a part of its curvature times
 *  sigma_p^2. */
#ifndef VOR_LOP_LATENT_H
#define VOR_LOP_LATENT_H

#include "core/lop/samples.h"
#include "core/lop/tree.h"

/** The surface; owns an index of the samples. */
struct vor_lop_latent {
    struct vor_lop_tree tree;
    double sigma_p; /**< radius around a place within which samples count */
    double scale;   /**< vor_lop_scale of sigma_n (lop/weights.h) */
};

/** An oriented point. */
struct vor_lop_point {
    float xyz[3], normal[3];
};

/** Indexes the samples as they are now.
 *
 *  @param[out] out      free with vor_lop_latent_free, whatever is returned
 *  @param[in]  sigma_n  radians, up to pi / 2
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n). */
VOR_NODISCARD vor_status vor_lop_latent_init(struct vor_lop_latent *out,
                                             const struct vor_lop_samples *samples, double sigma_n,
                                             double sigma_p, const struct vor_run *run,
                                             struct vor_error *err);

/** Frees the index; latent may be all zero. */
void vor_lop_latent_free(struct vor_lop_latent *latent);

/** Puts a base onto the surface, on the side of that end from which it is less far away.
 *
 *  @param[out] out   x = base + d n
 *  @param[in]  base  about between the ends
 *  @param[in]  end   two oriented points; where no sample counts, the planes through them serve
 *
 *  Departure: a side that few of the samples around are of is none. Else a sample of a wrong
 * normal, whose pairs come first because their normals differ most, grows a flap into the open.
 *
 *  @return false if it is none
 *
 *  O(samples within sigma_p). Thread-safe. */
int vor_lop_latent_put(struct vor_lop_point *out, const struct vor_lop_latent *latent,
                       const float base[3], const struct vor_lop_point end[2]);

/** The same on the side of one end. */
void vor_lop_latent_side(struct vor_lop_point *out, const struct vor_lop_latent *latent,
                         const float base[3], const struct vor_lop_point *end);

/** Where the sides of two ends meet: the place on the edge that is nearest to a base.
 *
 *  @param[out] foot    the place
 *  @param[out] along   unit vector along the edge
 *  @param[out] cosine  between the normals of both sides there
 *  @param[in]  base    about as far from the edge as from the ends
 *
 *  @return false where the two sides are parallel; the rest is unset then */
int vor_lop_latent_edge(float foot[3], float along[3], double *cosine,
                        const struct vor_lop_latent *latent, const float base[3],
                        const struct vor_lop_point end[2]);

#endif
