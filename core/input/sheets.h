/** Input points of one sheet: where surfaces lie nearer to each other than a neighbourhood is wide,
 * a fit to the nearest points runs in between.
 *
 *  Source: none of the papers; Huang 2013 Sec. 6 names close sheets as a limit, Lv 2022 Sec. 3.2
 * rejects neighbours across them. Departure from Lv: core/geom/layers.h. */
#ifndef VOR_INPUT_SHEETS_H
#define VOR_INPUT_SHEETS_H

#include "core/geom/surface.h"
#include "core/input/domain.h"

/** Whether layers can be told apart among the 50 nearest points at 48 or more of 128 places of the
 * input. Where not, none are looked for later, so that noise and edges are not taken for sheets.
 * Measured: inputs with two sheets have 118 to 128 such places, others at most 8, a scan of an
 * office with its walls twice 36.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(log n), a few ms. */
VOR_NODISCARD vor_status vor_sheets_find(int *out, const struct vor_domain *domain,
                                         const struct vor_run *run, struct vor_error *err);

/** The k points nearest to x of the sheet that x is nearest to, the nearest first, out of the 2.25
 * k (75 at least, VOR_NEIGHBORS_MAX at most) nearest to x; where fewer of them are on it they are
 *  repeated. Returns whether there are layers; else near is not touched. A search of its own,
 *  O(k log n). */
int vor_sheets_gather(float *near, const struct vor_domain *domain, const double x[3], unsigned k);

/** vor_surface_fit to k points (k x 3 floats) around x, or where those may be on several sheets of
 * the domain, and are, to k of the one that x is nearest to; those are then in near. Returns
 * whether they are. */
int vor_sheets_fit(struct vor_surface *out, float *near, const struct vor_domain *domain,
                   const double x[3], unsigned k);

#endif
