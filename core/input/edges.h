/** The sharp edges of an input: which points lie on one, how sharp it is, which way it runs, and
 *  how long all of them are.
 *
 *  Source: Merigot, Ovsjanikov, Guibas 2011, "Voronoi-based curvature and feature estimation from
 *  point clouds", which Lv et al. 2022, Sec. 4.2, take edges from: the covariance of a point's
 *  Voronoi cell is long along the normal; summed over a ball it has one long axis on a smooth
 *  surface, two at an edge, three at a corner, and the shortest runs along the edge.
 *  Departure: the sum is that of n n^T over a point's neighbours, where n is the normal of a plane
 *  through the nearest points. It has the same axes, and needs no Voronoi diagram.
 *  Departure: that sum is broad; it finds every point whose neighbours reach over an edge, and
 *  every rounded one. It only chooses candidates and the frame. There a crease is fitted beside a
 *  smooth surface (geom/crease.h), and a point is flagged where the crease explains its neighbours,
 *  turns by more than 25 degrees and passes within a spacing; or where the normals go three ways.
 *  What the crease leaves may be what noise leaves, which is measured first, at places all over the
 *  input: a low quantile, because detail is there in some places and noise in all.
 *
 *  The neighbours are the nearest in space, and not the lists of a graph (geom/graph.h): those stop
 *  at creases, where normals disagree. Sheets nearer than three spacings are therefore mixed;
 *  hardly one of their points fits a crease (at most 0.2 %).
 *
 *  Measured (tests/by_hand/bench/edges.pl) against the mesh's edges of more than 30 degrees.
 *  Spacing: sqrt(area / n). A flagged point is right within 1.5 spacings of an edge; places on the
 *  edges, half a spacing apart, are found if a flagged point lies within 1.5 spacings.
 *
 *                                     precision  recall  flagged  length / true  CPU us
 *      fandisk, 30,000 points              .993    .974    9.9 %            .92     4.2
 *      the same, noise of .34 spacings     .921    .966     11 %           1.04      14
 *      noise of .09, .17, .51 spacings     .958    .980     10 %            .92     6.0
 *                                          .942    .977     10 %            .91     7.5
 *                                          .881    .879     11 %           1.01      48
 *      noise of .85 spacings               .623    .700      8 %            .79      23
 *      fandisk, 10,000 and 120,000         .989    .935     15 %            .82     4.2
 *                                          .992    .985    5.1 %            .95     2.7
 *      cube, 30,000                        .996    .999    6.0 %           1.00     2.5
 *      cylinder with caps, 30,000          .997    .999    3.4 %            .98     4.7
 *      wedges of 150 and 120 degrees     1, 1   .99, 1    1.8 %       .87, .94
 *      igea, sphere, 30,000                               .10, 0 %                  4.2, 2.2
 *      bunny, armadillo, 30,000                           .13, .48 %                5.0, 6.2
 *      cow, 30,000                         .947    .207    2.0 %                    5.0
 *
 *  The last rows have edges in their meshes that are facets, or folds as wide as the spacing. On
 *  fandisk without noise two misses in three are within two spacings of a corner. */
#ifndef VOR_INPUT_EDGES_H
#define VOR_INPUT_EDGES_H

#include "core/input/domain.h"

/** Quantile of what quadrics leave that is noise: edges, detail and other sheets are elsewhere. At
 * 0.05 / 0.1 / 0.2 recall on fandisk30k_noise2 .964 / .964 / .969 (edges.c). */
#define VOR_EDGES_NOISE_QUANTILE 0.1

/** Points of a normal beside edges and borders (edges.c has the figures). */
enum { VOR_EDGES_NORMAL = 16 };

/** What was found of n points. */
struct vor_edges {
    struct vor_memory *memory;
    size_t n;
    size_t flagged;      /**< points that lie on an edge */
    unsigned char *flag; /**< n: 1 for those, else 0 */
    float *strength;     /**< n: sine of half the angle between the normals of the two sides, in
                              (0, 1]; 0 where not flagged */
    float *direction;    /**< n x 3: unit vector along the edge, of either sign; at a corner along
                              one of its edges; 0 where not flagged */
    float *foot;         /**< n x 3: place on the edge nearest to the point; 0 where not flagged */
    double length;       /**< estimate of the length of all edges, in normalised units (times
                              domain->unit: in those of the input) */
};

/** Finds the edges of a domain's points.
 *
 *  @param[out] out     free with vor_edges_free; untouched on failure
 *  @param[in]  domain  indexed; read: xyz, knn, known.neighbors, known.sheets
 *
 *  @retval VOR_E_NOMEM 29 bytes a point do not fit, and 12 more while it works
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED
 *
 *  O(n log n), on the run's pool: 2 to 5 us a point where fits take
 *  VOR_NEIGHBORS_FEWEST points and there is no noise, 9 with noise, and in proportion where they
 *  take more; most of it is search. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_edges_find(struct vor_edges *out, const struct vor_domain *domain,
                                        const struct vor_run *run, struct vor_error *err);

/** edges may be all zero. */
void vor_edges_free(struct vor_edges *edges);

#endif
