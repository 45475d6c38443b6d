/** Which seeds lie on one sheet, so that triangles may join them.
 *
 *  Source: the question is that of input/adjacency.h, asked of seeds, whose spacing may be larger
 *  than a list of the input reaches. */
#ifndef VOR_MESH_SHEET_H
#define VOR_MESH_SHEET_H

#include "core/seeds/seeds.h"

/** What is known of the seeds. */
struct vor_sheet {
    const struct vor_seeds *seeds;
    const struct vor_graph *graph; /**< neighbours of the input on one sheet, or NULL: the nearest
                                        points lie on one */
    struct vor_graph own;          /**< made for the purpose, or all zero */
    float *normal;          /**< n x 3: unit normal of the surface at each seed, of any sign; 0
                                 where there is no surface */
    float *near;            /**< n: distance to the nearest input point, where the seed was then */
    unsigned char *crowded; /**< n: another sheet is nearer than the edges (mesh/crowded.h); NULL
                                 with a graph, and before that is known */
    uint32_t *root;         /**< n: an input point on the sheet of each seed; NULL without graph */
};

/** Finds the normals, and where the domain has sheets the input points that the seeds belong to.
 *
 *  @param[out]    out    free with vor_sheet_free, also on failure
 *  @param[in,out] seeds  on the whole domain; must outlive *out
 *  @param[in]     how    last fits are used again, finer ones where it says so; NULL: the seeds are
 *                        fitted anew
 *
 *  @retval VOR_E_NOMEM 20 bytes a seed do not fit, or those of vor_adjacency_make
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n k), on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_sheet_find(struct vor_sheet *out, struct vor_seeds *seeds,
                                        const struct vor_recall *how, const struct vor_run *run,
                                        struct vor_error *err);

/** Puts the seeds that moved onto the surface, and finds again what is known of them.
 *
 *  @param[in] moved  n flags
 *  @param[in] how    last fits are used again, finer ones where it says so
 *
 *  @retval VOR_E_CANCELLED  as vor_run_for
 *
 *  O(k) for each, on the run's pool. The same bytes for any number of threads. */
VOR_NODISCARD vor_status vor_sheet_put(struct vor_sheet *sheet, struct vor_seeds *seeds,
                                       const unsigned char *moved, const struct vor_recall *how,
                                       struct vor_error *err);

/** The same for seed i, which no other thread asks about. */
void vor_sheet_put_one(struct vor_sheet *sheet, struct vor_seeds *seeds,
                       const struct vor_recall *how, struct vor_scratch *scratch, size_t i);

/** sheet may be all zero. */
void vor_sheet_free(struct vor_sheet *sheet);

/** True when seeds i and j, near each other, lie on one sheet. The same for (j, i). O(distance over
 *  the spacing of the input) where there is a graph, else O(1). Thread-safe. */
int vor_sheet_joins(const struct vor_sheet *sheet, uint32_t i, uint32_t j);

/** The same by the lists of the input alone, without looking at normals: true where there are none.
 */
int vor_sheet_leads(const struct vor_sheet *sheet, uint32_t i, uint32_t j);

/** Whether the offset between two seeds, and the normals there, are those of one surface. O(1). */
int vor_sheet_is_beside(const struct vor_sheet *sheet, size_t i, size_t j);

/** Whether the input goes on under a triangle of seeds: its middle and those of its edges are not
 *  far from input points. O(log N) of the input. Thread-safe. */
int vor_sheet_is_under(const struct vor_sheet *sheet, const uint32_t corner[3]);

/** Whether a triangle lies along the tangent planes of two of its corners: at a sharp tip the third
 *  may face anywhere. O(1). Thread-safe. */
int vor_sheet_is_along(const struct vor_sheet *sheet, const uint32_t corner[3]);

/** Whether a triangle may join two sheets: where the input has several near one of its corners, the
 *  surface at a corner, continued, is farther from another than VOR_SHEET_PASSES times the way
 *  there. That surface is the last fit of the seed. Where no lists of neighbours were made, whether
 *  one of its corners is crowded. O(1). */
int vor_sheet_doubts(const struct vor_sheet *sheet, const uint32_t corner[3]);

/** Share of the way. Of the triangles on two sheets / of all, in %, so many are doubted at 0.1 /
 * 0.2 / 0.3: shell60k to 20,000 82, 26 / 67, 12 / 51, 7; arma2_120k to 40,000 80, 46 / 60, 25 / 46,
 * 16 (a point between two sheets lies on the nearer). Of those of two planes that cross at four
 *  degrees: at 0.2 a quarter. */
#define VOR_SHEET_PASSES 0.2

/** True when seed i has a surface. */
int vor_sheet_has(const struct vor_sheet *sheet, size_t i);

#endif
