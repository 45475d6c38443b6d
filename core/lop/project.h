/** Locally optimal projection: points that are drawn to the data around them and repel each other.
 *
 *  Source: Lipman et al. 2007, "Parameterization-free projection for geometry reconstruction";
 *  Huang et al. 2009, "Consolidation of unorganized point clouds", for the weights of density;
 *  Huang et al. 2013, "Edge-Aware Point Set Resampling", Sec. 4, Eq. 3, for those of normals. A
 * step moves p to sum(alpha q) / sum(alpha) + mu sum(beta (p - p')) / sum(beta) over data q and
 * other points p', with alpha = theta(p - q) / |p - q| / v and beta = w theta(p - p') / |p - p'|^2,
 * where v and w are the densities of the data and of the points; the square is that of CGAL.
 *
 *  Departure: the density of the data is read off the distance to its twelfth neighbour, which
 * costs no sum over the reach; where there are fewer data than points it goes only a part
 * of the way to them; and few data stand for all within the reach where there are very
 * many. Departure: two points nearer than a part of the spacing are pushed apart by what they lack
 * of it, since points that the same data draw would end as one. Departure, with normals: data count
 * by theta, by the angle between the normals (psi) and by their height over the point's plane
 * (phi): those of the other side of an edge do not. Only the part of the step along the point's
 * plane is that of Eq. 3; across it the point goes to where the data of its side see it, along the
 * mean of both normals, because the mean of data on a bent surface lies off it, on its hollow side.
 * The normals of the points follow those of the data (Eq. 2). */
#ifndef VOR_LOP_PROJECT_H
#define VOR_LOP_PROJECT_H

#include "core/input/domain.h"
#include "core/lop/samples.h"
#include "core/seeds/outcome.h"

/** How points are projected. */
struct vor_lop_project_how {
    double mu;
    double sigma_n;         /**< radians; with normals alone */
    double spacing;         /**< normalised: of as many points as there are samples, if even */
    double reach;           /**< normalised: theta is 0 beyond it */
    int normals;            /**< points and data have some, which count */
    uint32_t rounds, steps; /**< the product is done at most; in the end of a round only normals and
                                 heights change */
    uint32_t ahead;         /**< steps of the stages that follow */
    const struct vor_spec *spec; /**< read: delta, seconds */
};

/** Moves the points of *samples, their normals along.
 *
 *  @param[in]     data  where the points of the domain are, in their order, and their normals if
 *                       how->normals; only xyz is read without
 *  @param[in,out] told  the stage PROJECT is added; stopped
 *  @param[in]     run   may be stopped: points stay where the last step left them
 *
 *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL
 *  @retval VOR_E_NOMEM  some 900 bytes for each sample do not fit
 *
 *  O(steps n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_lop_project(struct vor_lop_samples *samples,
                                         const struct vor_lop_samples *data,
                                         const struct vor_domain *domain,
                                         const struct vor_lop_project_how *how,
                                         struct vor_outcome *told, const struct vor_run *run,
                                         struct vor_error *err);

#endif
