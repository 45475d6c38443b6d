/** The lists of neighbours of a domain, made the way that was chosen for its input, and fits to
 *  them. */
#ifndef VOR_INPUT_LISTS_H
#define VOR_INPUT_LISTS_H

#include "core/geom/surface.h"
#include "core/input/domain.h"

/** Makes domain->graph as known.lists says. Does nothing where there is one, where no lists were
 *  chosen, and on an empty domain.
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED  as vor_adjacency_make, vor_satellites_make
 *
 *  O(n log n), on the run's pool. The same lists for any number of threads. */
VOR_NODISCARD vor_status vor_lists_make(struct vor_domain *domain, const struct vor_run *run,
                                        struct vor_error *err);

/** Makes domain->graph where there is none, whether lists were chosen or not: for what looks at
 *  neighbours, not for fits.
 *
 *  @param[in] plain  the lists have the nearest points, and normals of zero; so they do, too, where
 *                    there are no more than VOR_ADJACENT points
 *
 *  Fails and costs as vor_lists_make. */
VOR_NODISCARD vor_status vor_lists_make_any(struct vor_domain *domain, int plain,
                                            const struct vor_run *run, struct vor_error *err);

/** Keeps the surface of each list of a domain that has lists, 192 bytes a point; of one of more
 *  than 2,048 points none. Fits ask for the same few again and again. From then on points and lists
 *  stay as they are, or nothing is fitted any more.
 *
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_rows
 *
 *  O(n), on the run's pool. */
VOR_NODISCARD vor_status vor_lists_keep(struct vor_domain *domain, const struct vor_run *run,
                                        struct vor_error *err);

/** What a fit was made to. */
struct vor_lists_fitted {
    int sheet;     /**< 1: to one sheet of several; 0: to the nearest points */
    uint32_t root; /**< the input point whose list it is; VOR_LISTS_NO_ROOT: no list */
};

#define VOR_LISTS_NO_ROOT UINT32_MAX

/** Whether fits to k points follow lists: the domain has them, and k is at most VOR_ADJACENT. */
int vor_lists_are(const struct vor_domain *domain, unsigned k);

/** vor_surface_fit to k points around x, which lie on one sheet if vor_lists_are: where the list of
 * the input point nearest to x is its own or fits far better, to that list; and where points of
 * another sheet are near, to the sheet that x is nearer to, because between sheets nearer than the
 * spacing the nearest input point is often one of the other. Without lists, as vor_sheets_fit.
 *
 *  @param[in,out] near   k x 3 floats, nearest first; those of the sheet if there is one, repeated
 *                        if they are fewer
 *  @param[in]     index  their numbers, that of the nearest first
 *
 *  O(k^2) where it is to a list, else as vor_sheets_fit. Cannot fail. Thread-safe. */
struct vor_lists_fitted vor_lists_fit(struct vor_surface *out, float *near,
                                      const struct vor_domain *domain, const double x[3],
                                      unsigned k, const uint32_t *index);

/** vor_lists_fit to the k input points nearest to any place x; as many as there are, where there
 * are fewer.
 *
 *  @param[out] near  k x 3 floats, as vor_lists_fit leaves them
 *
 *  @return how many points there are in near
 *
 *  O(k log n). Cannot fail. Thread-safe. */
unsigned vor_lists_fit_at(struct vor_surface *out, float *near, const struct vor_domain *domain,
                          const double x[3], unsigned k);

/** The points that a fit to the list of a root was made to.
 *
 *  @param[out] near  k x 3 floats: the root and its neighbours, repeated if they are fewer
 *
 *  O(k). Cannot fail. Thread-safe. */
void vor_lists_points(float *near, const struct vor_domain *domain, uint32_t root, unsigned k);

#endif
