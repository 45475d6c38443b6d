/** The points around a point, and empty balls through three of them.
 *
 *  Whether a triangle of a local Delaunay triangulation has an empty ball is read off the points
 *  around its first corner, so no triangulation is made. Where the request has a metric, that of
 * the first corner counts.
 *
 *  Source: none; balls and rays are as in any text book. */
#ifndef VOR_MESH_BALLS_H
#define VOR_MESH_BALLS_H

#include "core/mesh/sheet.h"

/** Points looked at around a point, itself first: those of its list, of which an even spread has
 * all within 2.1 spacings, and where these do not do all within 3.7 spacings. */
enum { VOR_BALLS_FEW = 16, VOR_BALLS_MANY = 48 };

/** The lists, and the points that are looked at. */
struct vor_balls {
    const struct vor_sheet *sheet;
    struct vor_knn *knn; /* over the points */
    int parts;           /* points of other sheets are left out: the input has several */
    uint32_t *list;      /* n x VOR_BALLS_FEW */
    unsigned char *count;
    float *far2; /* n: all points within this squared distance are in the list */
    /* looked at: their offsets from the first, where there is a metric as it sees them */
    uint32_t of;            /* the first */
    unsigned around, asked; /* how many there are, and how many were asked for; 0: none yet */
    uint32_t index[VOR_BALLS_MANY];
    double x[VOR_BALLS_MANY][3];
    double far2_around;
};

/** Lists the points around each point; where the input was found to have sheets on most of it,
 * those that its lists lead to.
 *
 *  @retval VOR_E_NOMEM 110 bytes a point do not fit
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for
 *
 *  O(n log n), on the run's pool but for the index. Free with vor_balls_free, also on failure. */
VOR_NODISCARD vor_status vor_balls_make(struct vor_balls *out, const struct vor_sheet *sheet,
                                        const struct vor_run *run, struct vor_error *err);

/** balls may be all zero. */
void vor_balls_free(struct vor_balls *balls);

/** Looks at the points around point i, few or many. O(1) for few, and for those looked at last. */
void vor_balls_look(struct vor_balls *balls, uint32_t i, unsigned around);

/** The offset of a point that is looked at, or NULL. */
const double *vor_balls_find(const struct vor_balls *balls, uint32_t point);

/** The squared radius of the smallest empty ball through the point looked at and those at offsets b
 *  and c; INFINITY where there is none, or none that is smaller than `most2` and that the points
 *  looked at show to be empty. O(1). */
double vor_balls_radius2(const struct vor_balls *balls, const double *b, const double *c,
                         double most2);

#endif
