/** Fillets among the data of ear: edges that are rounded off, by less than the smoothing of normals
 *  sees.
 *
 *  Source: none of the papers. Where a fillet is about as wide as the fits, its normals fall into
 *  the two groups of an edge, and the planes of both sides pass over it: samples there get the
 *  virtual edge, and by rho most of the points inserted. But the input's own points lie below both
 *  planes, as they never do at an edge. Where they seem to, a rounded wedge is fitted to those of a
 *  wider neighbourhood (geom/fillet.h), and where such wedges are better than the edge, in the mean
 *  of the points around, the points of the round part are put onto it, with its normals.
 *
 *  Measured, rms elsewhere than near edges over the input's, 30,000 points to 40,000 by 10,000
 *  samples, without this, with positions alone, with normals too, and of cvt: fandisk with noise of
 *  0.5 % of the diagonal .383, .329, .257 and .270; a prism with a sharp edge and fillets of 2, 4
 *  and 8 % of its diagonal, noise of 0.2 % 1.43, .99, .28 and .22; of 0.5 % .65, .51, .34 and .18;
 *  of 1 % .30, .30, .30 and .18. Wedges of two planes get the same bytes with and without. */
#ifndef VOR_LOP_FILLETS_H
#define VOR_LOP_FILLETS_H

#include "core/input/domain.h"
#include "core/lop/samples.h"

/** Neighbours of each point of a domain, nearest first: the point itself is one. */
struct vor_lop_lists {
    unsigned most;
    const uint32_t *list;  /**< n x most */
    const uint16_t *count; /**< n */
};

/** Puts the data on fillets onto them, with their normals; all others stay.
 *
 *  @param[in,out] data    the points of the domain, smoothed
 *  @param[out]    room    as many; overwritten
 *  @param[in]     domain  read: xyz, knn
 *
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  On the run's pool. The same points for any number of threads. */
VOR_NODISCARD vor_status vor_lop_fillets(struct vor_lop_samples *data, struct vor_lop_samples *room,
                                         const struct vor_domain *domain,
                                         const struct vor_lop_lists *lists,
                                         const struct vor_run *run, struct vor_error *err);

#endif
