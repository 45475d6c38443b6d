/** Moves points along the surface such that the triangles at them become better.
 *
 *  Each step moves every point that triangles surround by Newton's method towards the least sum of
 *  their strain (vor_triangle_strain), which is convex in the place of one corner, and puts it on
 *  its local surface. Points at a loop stay, and those on creases and tips unless a
 *  triangle there is poor, or move along the crease where that is asked for.
 *
 *  Source: none of the papers. The strain of one triangle as a function of its apex is the
 *  hyperbolic cosine of the distance from the ideal apex, in the half plane over its base. That
 *  does not see sizes, which drift apart around points without six triangles; a sum of area over
 *  mean area and its inverse, twice such a cosine, sees them. */
#ifndef VOR_MESH_RELAX_H
#define VOR_MESH_RELAX_H

#include "core/mesh/complex.h"
#include "core/mesh/quality.h"
#include "core/mesh/sheet.h"

/** Steps after edges were flipped. Mean quality on fandisk, 10,000 points, creases moving too,
 * after two times 0 / 1 / 2 / 3 / 6 steps: 0.930 / 0.950 / 0.954 / 0.956 / 0.959. */
enum { VOR_RELAX_STEPS = 3 };

/** Times that edges are flipped and points move. */
enum { VOR_RELAX_ROUNDS = 2 };

/** Longest step, in mean distances to the points around. */
#define VOR_RELAX_STEP_MAX 0.15

/** The strain of the triangles around a point in its tangent plane, as it changes with its place:
 * all zero before the first triangle. */
struct vor_relax_pull {
    double slope[2], bend[3]; /**< first and second derivatives: uu, uv, vv */
    double area;              /**< that triangles should have; 0: sizes do not count */
    double edge;              /**< sum of the distances to the neighbours, each twice */
    unsigned triangles;
};

/** Adds the triangle that has its apex at x, over the base from a to b. O(1). */
void vor_relax_add(struct vor_relax_pull *pull, const struct vor_frame *frame, const float *x,
                   const float *a, const float *b);

/** The step of the point in the axes of its tangent plane: Newton's, damped, as all points move at
 *  once. O(1). */
void vor_relax_step(double step[2], const struct vor_relax_pull *pull);

/** Makes the step one along the first axis. */
void vor_relax_hold(struct vor_relax_pull *pull);

/** Whether the triangles of point i lie along its tangent plane, as they do not on a crease or a
 *  tip. O(1). */
int vor_relax_is_smooth(const struct vor_complex *complex, const struct vor_sheet *sheet,
                        uint32_t i);

/** Whether point i may move: it is smooth there, or one of its triangles is poor. O(1). */
int vor_relax_is_free(const struct vor_complex *complex, const struct vor_sheet *sheet, uint32_t i);

/** Axes for the triangles around point i, that along a crease first, their normal last. O(1). */
void vor_relax_axes(double axis[3][3], const struct vor_complex *complex, const float *xyz,
                    uint32_t i);

/** How a point moves. */
enum vor_relax_motion {
    VOR_RELAX_STAYS,
    VOR_RELAX_ALONG, /**< a crease: by vor_relax_hold in vor_relax_axes */
    VOR_RELAX_FREE
};

/** Where points move to. */
enum vor_relax_aim {
    VOR_RELAX_STRAIN, /**< the least strain of the triangles; the input's border is not looked at */
    VOR_RELAX_SIZE,   /**< that, and areas a / m + m / a, m their mean around each point, */
    VOR_RELAX_MIDDLE, /**< the mean of the triangles' middles by their areas, */
    VOR_RELAX_LENGTH  /**< where no edge is shorter than others: all three inside the border */
};

/** What is done. */
struct vor_relax_how {
    unsigned steps; /**< of all points at once */
    unsigned after; /**< more steps, of those on creases and near them alone */
    size_t fixed;   /**< that many of the last points stay */
    int refine;     /**< finer fits are tried (vor_seeds_refine) */
    size_t since;   /**< only corners of the triangles from this one on move */
    enum vor_relax_aim aim;
    double length;  /**< LENGTH: of the edges, over the spacing wanted; without a density normalised
                     */
    int keep_holes; /**< not STRAIN: holes are kept open (vor_attach) */
    unsigned creases; /**< 0: points on creases stay. Else they move along them, by STRAIN, as do
                         points less than so many rings from one */
};

/** Moves the points.
 *
 *  @param[in,out] sheet    its normals become those where the points are
 *  @param[in,out] seeds    those of the sheet; their lists are not renewed
 *  @param[in]     complex  over the seeds
 *
 *  @retval VOR_E_NOMEM  14 bytes a seed do not fit
 *  @retval VOR_E_CANCELLED
 *
 *  O(steps n), on the run's pool. The same positions for any number of threads. */
VOR_NODISCARD vor_status vor_relax(struct vor_sheet *sheet, struct vor_seeds *seeds,
                                   const struct vor_complex *complex,
                                   const struct vor_relax_how *how, struct vor_error *err);

#endif
