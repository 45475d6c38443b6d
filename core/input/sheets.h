/** Fits to one sheet: where surfaces lie nearer to each other than a neighbourhood is wide, a fit
 *  to the nearest points runs between them.
 *
 *  Source: none of the papers; Huang 2013 Sec. 6 names close sheets as a limit, Lv 2022 Sec. 3.2
 *  rejects neighbours across them. Departure from Lv: core/geom/layers.h, which also has the
 *  figures.
 *
 *  Cost: with noise and 150 neighbours a run takes 8 times the CPU; an input without sheets takes
 *  0.8 % more instructions (bunny to 5,000). The report's `queries` do not count these searches. */
#ifndef VOR_INPUT_SHEETS_H
#define VOR_INPUT_SHEETS_H

#include "core/geom/layers.h"
#include "core/input/domain.h"

/** Finds out where the input has sheets: whether the 50 nearest points form layers is asked at 128
 *  places, and at ten or more of the sixteen nearest to a place, itself with them, they have to;
 *  at five or more in an input with sheets on much of it. Elsewhere fits of seeds do not look for
 *  layers, so that noise and edges are not taken for sheets.
 *
 *  @param[out] out  set on success: sheeted; and sheets, whether points form layers at 48 or more
 * of the places
 *
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(log n), a few ms, on the run's pool. The same answer for any number of threads. */
VOR_NODISCARD vor_status vor_sheets_find(struct vor_conditioning *out,
                                         const struct vor_domain *domain, const struct vor_run *run,
                                         struct vor_error *err);

/** Whether fits at x look for layers: what the place nearest to it says. Less than 0.1 us. */
int vor_sheets_at(const struct vor_sheeted *sheeted, const double x[3]);

/** The layer that a place is nearest to. */
struct vor_layer {
    unsigned count;                    /**< its points around the place; 0: there are no layers */
    float reach;                       /**< none that is nearer than this is missing */
    uint32_t index[VOR_NEIGHBORS_MAX]; /**< of these points, the nearest first */
};

/** The way that finds layers around a place that has none. */
enum { VOR_SHEETS_NO_WAY = UINT8_MAX };

/** In which of its ways vor_sheets_gather finds layers around input point i, counted from 1;
 *  VOR_SHEETS_NO_WAY: there are none. Costs as that. Thread-safe. */
unsigned char vor_sheets_way(const struct vor_domain *domain, uint32_t i, unsigned k);

/** Looks for layers among the 2.25 k points nearest to x (at least 75, at most VOR_NEIGHBORS_MAX).
 *
 *  @param[out] near   k x 3 floats: the points nearest to x of the layer that x is nearest to, the
 *                     nearest first; they are repeated if the layer has fewer. Untouched without
 *                     layers
 *  @param[out] layer  what was found; count stays as it is without layers; may be NULL
 *  @param[in]  way    the way that is tried first, as it found layers nearby: a fifth of the cost
 *                     where it finds them again; 0: none is known
 *
 *  @return whether there are layers
 *
 *  One search; O(k log n + k^2). Cannot fail. Thread-safe. */
int vor_sheets_gather(float *near, const struct vor_domain *domain, const double x[3], unsigned k,
                      struct vor_layer *layer, unsigned way);

enum { VOR_SHEETS_RECENT = 4 };

/** Layers that were found last, for places near each other in turn. All zero: none yet. */
struct vor_sheets_recent {
    unsigned count, next;
    struct vor_layers layers[VOR_SHEETS_RECENT];
    unsigned char attempt[VOR_SHEETS_RECENT]; /**< how each was found */
};

/** Looks for layers as vor_sheets_gather does, but first for layers like those found last, and then
 *  in two of its four ways.
 *
 *  @param[out]    list    room for k: the points nearest to x of the layer that x is nearest to,
 * the nearest first
 *  @param[in,out] recent  what is found depends on it: fill it in the same order on every run
 *
 *  @return how many there are, at most k; 0 without layers
 *
 *  Costs half of vor_sheets_gather where there are none. Cannot fail. */
unsigned vor_sheets_list(uint32_t *list, const struct vor_domain *domain, const double x[3],
                         unsigned k, struct vor_sheets_recent *recent);

/** vor_surface_fit to k points around x; if the domain has sheets, there or on much of it, and the
 *  points form layers, to k points of the layer that x is nearest to.
 *
 *  @param[in,out] near   k x 3 floats, nearest first; those of the layer when it returns 1
 *  @param[out]    layer  what was found; count stays as it is without; may be NULL
 *
 *  @return whether the fit is to a layer
 *
 *  O(k), as vor_sheets_gather where layers are possible. Cannot fail. Thread-safe. */
int vor_sheets_fit(struct vor_surface *out, float *near, const struct vor_domain *domain,
                   const double x[3], unsigned k, struct vor_layer *layer);

#endif
