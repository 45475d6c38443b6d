/** The one door to the engine: a function of (cloud, request, seed). No files, sockets, logs or
 *  globals behind it, nor a clock of its own. */
#ifndef VOR_ENGINE_H
#define VOR_ENGINE_H

#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/spec.h"

/** Why a run ended: identifier, word in the report. */
#define VOR_STOPPED_TABLE(X)                                                                       \
    X(ITERATIONS, "iterations")                                                                    \
    X(DELTA, "delta")                                                                              \
    X(SECONDS, "seconds")                                                                          \
    X(PLATEAU, "plateau")                                                                          \
    X(CALLER, "stopped")

enum vor_stopped {
#define VOR_STOPPED_ENUM(id, word) VOR_STOPPED_##id,
    VOR_STOPPED_TABLE(VOR_STOPPED_ENUM)
#undef VOR_STOPPED_ENUM
        VOR_STOPPED_COUNT
};

const char *vor_stopped_word(enum vor_stopped stopped);

/** Mean, root mean square and maximum of the distances from points to the nearest of others; in the
 * cloud's unit. */
struct vor_apart {
    double mean, rms, max;
    uint64_t points; /**< that were looked at */
};

/** So many points of the result had their surface fitted to that number of input points. */
struct vor_fitted {
    uint32_t neighbors;
    uint64_t points;
};

#define VOR_FITTED_MAX 8 /**< different numbers in a report */

/** What a run did. read and write seconds are the caller's to fill in; a run leaves them 0. */
struct vor_report {
    uint64_t points_in, points_out;
    double delta, sigma, epsilon; /**< of the result, as vor_record */
    uint32_t iterations;          /**< done */
    uint32_t polish_steps;        /**< done */
    enum vor_stopped stopped;
    double seconds_read, seconds_index, seconds_init, seconds_iterate, seconds_polish,
        seconds_write;
    uint64_t memory_peak_bytes; /**< of the job's allocator */
    uint64_t outliers;          /**< input points that were ignored */
    double lattice[3];          /**< cell that the input's coordinates were rounded to, along x, y
                                     and z; 0 where none was found */
    uint64_t off_lattice;       /**< input points that were moved within their cell; 0 where the
                                     cells are small against the input's spacing */
    /** From the input's points to the nearest of the result. Points that share a place count once,
     * outliers that were ignored not at all, and those that were moved off a lattice from where
     * they went. Of more than 200,000, so many at equal steps along the order of the domain are
     * looked at: mean and rms are estimates then, and max is a lower bound. */
    struct vor_apart in_to_out;
    /** From the result's points, all of them, to the nearest of the same input points. */
    struct vor_apart out_to_in;
    /** Points of the result that lie where the input ends (output/compare.h), whatever boundary
     * says: none on a closed smooth surface; along a border about its length over the spacing. */
    uint64_t boundary_points;
    /** To how many input points the surfaces were fitted that the result's points lie on, as of the
     * last step: ascending, their points sum to points_out. */
    struct vor_fitted fitted[VOR_FITTED_MAX];
    unsigned fitted_count;
    uint64_t held;           /**< points held back in the last iteration */
    uint64_t held_ever;      /**< points held back in any iteration */
    uint64_t fallback_plane; /**< seeds on a plane in the last iteration: no quadric there */
    uint64_t fallback_left;  /**< seeds left where they were: no surface there */
    double area;             /**< of the surface in unit^2: the sum of the cells at the end, or what
                                  spacing was turned into points with */
    double spacing_mean;     /**< mean distance to the nearest neighbour in the result */
    double min_over_mean, max_over_mean; /**< of those distances */
    double six_share;           /**< share of the result's points with six Voronoi neighbours */
    double bisectors_per_cell;  /**< planes that cut a cell, mean over all cells computed */
    double triangles_per_cell;  /**< triangles of the patches those were cut from, likewise */
    uint64_t queries;           /**< searches of an index, among the input or the points */
    uint64_t list_rebuilds;     /**< times the points' lists of neighbours were made anew */
    struct vor_spec parameters; /**< with points filled in from ratio or spacing, auto resolved:
                                     neighbors to the usual number, `fitted` has the others */
};

/** Resamples a cloud.
 *
 *  @param[out] out     an initialised, empty cloud; filled only when VOR_OK is returned
 *  @param[out] report  filled only when VOR_OK is returned
 *  @param[in]  in      checked (vor_cloud_check); borrowed for the call
 *  @param[in]  spec    checked (vor_spec_check)
 *  @param[out] err     may be NULL
 *
 *  @retval VOR_E_TARGET     the number of points asked for, or what ratio or spacing come to, is
 * out of range (vor_spec_check_target)
 *  @retval VOR_E_DEGENERATE the cloud has no surface: fewer than four distinct points, or all on a
 * line
 *  @retval VOR_E_NOMEM      the job does not fit under its cap
 *  @retval VOR_E_CANCELLED  the watch answered VOR_CANCEL
 *
 *  Departure: where the input has ten times as many points as asked for, and 40,000, it is thinned
 *  for all but the last iterations or steps: to about five points a seed, 20,000 at least.
 *
 *  Departure: where the input's coordinates were rounded to cells that are not small against its
 *  spacing, its points are first moved within them (input/lattice.h).
 *
 *  Memory: at most 61 bytes for each input point (position, order, index), and for each point of
 *  the result 6 k + 383 (surface, lists, index; k neighbors), twice that while the start is drawn
 *  from cells, that is unless the input has ten times as many points; then 6 k + 492 while
 *  iterating. A progressive order takes 34 instead, after the polish, and a copy of the widest
 *  column. 200 KiB a thread. After the first iteration nothing is allocated but the points' index
 *  when it is made anew, and that order.
 *
 *  Cost: O(N log N) for the index, O(n) an iteration, O(n log n) a progressive order. Thread-safe.
 *  The same bytes for any number of threads, unless a time budget or the caller ended the run. */
VOR_NODISCARD vor_status vor_engine_run(struct vor_cloud *out, struct vor_report *report,
                                        const struct vor_cloud *in, const struct vor_spec *spec,
                                        const struct vor_run *run, struct vor_error *err);

/** How evenly a cloud is spread and how far it is from another one; the names and the definitions
 * of Xiao 2024 Sec. V-B. Lengths of the first group are in the cloud's unit. */
struct vor_measure {
    uint64_t n;
    double delta, sigma, epsilon;
    double mean_nn; /**< mean distance to the nearest other point: the spacing */
    double min_over_mean, max_over_mean;
    uint64_t coincident; /**< points that share their place with another one */
    int has_reference;   /**< the rest is set; lengths over the reference's bounding-box diagonal */
    double far_over_knn6_mean; /**< farthest point's distance to the reference over the mean
                                  distance of a reference point to its 6th neighbour */
    double far_over_knn6_p999; /**< the same over the 99.9th percentile */
    double out_to_ref_mean, out_to_ref_rms, out_to_ref_max; /**< of each point's distance to the
                                                                 nearest reference point */
    double ref_to_out_mean, ref_to_out_rms, ref_to_out_max; /**< the other way */
    double hausdorff;                                       /**< the larger max */
    double chamfer;          /**< the sum of both means, of distances and not of their squares */
    double d1_mse, d2_mse;   /**< point to point and point to plane, the larger direction, in the
                                  cloud's unit^2; as mpeg-pcc-dmetric, metrics/distortion.h */
    double d1_psnr, d2_psnr; /**< 10 log10(3 peak^2 / mse) in dB; infinite where mse is 0 */
    double peak;             /**< that of the psnr, in the cloud's unit */
};

/** Range of a peak that is given. */
#define VOR_PEAK_MIN 1e-30
#define VOR_PEAK_MAX 1e30

/** Measures a cloud, and its distances to a reference where one is given (else NULL). Different
 *  origins are honoured; positions are float32 about the middle of both clouds. D2 needs the
 * reference's normals; those it does not carry are fitted.
 *
 *  @param[in] peak VOR_PEAK_MIN .. VOR_PEAK_MAX, or 0 for the largest distance of a reference point
 *                  to its nearest other one
 *  @retval VOR_E_DEGENERATE fewer than two points, or every point coincides; a reference of fewer
 *                           than seven points or of no extent
 *  @retval VOR_E_NOMEM, VOR_E_CANCELLED  as vor_engine_run
 *
 *  Cost: O(n log n). Deterministic for any number of threads. */
VOR_NODISCARD vor_status vor_engine_measure(struct vor_measure *out, const struct vor_cloud *cloud,
                                            const struct vor_cloud *reference, double peak,
                                            const struct vor_run *run, struct vor_error *err);

#endif
