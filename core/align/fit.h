/** Moves a cloud onto a reference from a pose near the right one: iterative closest points, to the
 *  planes of the reference's samples.
 *
 *  Source: Chen and Medioni 1992, "Object modelling by registration of multiple range images";
 *  Chetverikov et al. 2005, "Robust Euclidean alignment of 3D point sets: the trimmed ICP". */
#ifndef VOR_ALIGN_FIT_H
#define VOR_ALIGN_FIT_H

#include "core/align/match.h"
#include "core/align/points.h"

/** What is fitted to what. */
struct vor_align_fit_of {
    const struct vor_align_samples *cloud, *reference;
    const struct vor_align_grid *grid;        /**< of the reference */
    const struct vor_align_points *points[2]; /**< of the cloud, of the reference */
    int scales;                               /**< the scale is free */
    unsigned every;                           /**< one sample in so many is looked at, */
    unsigned first;                           /**< as poses are refined from this one on */
    double overlap; /**< share of the cloud that has a counterpart; 0: unknown */
};

/** How well a pose fits. Lengths are normalised. */
struct vor_align_fit {
    struct vor_pose pose;
    int flip;
    double score;       /**< share of both clouds' samples that lie on the other one */
    double overlap[2];  /**< of the cloud's, of the reference's */
    double conflict[2]; /**< share of those that are near the other cloud, but not on it */
    double rms;         /**< distance of the cloud's samples to the planes that they lie on */
    double median;      /**< of these distances */
    double on;          /**< share of the points of both clouds that lie on the other one */
    double hover;  /**< of those over the inside of the other one's surface, share that do not */
    double beside; /**< the same of those near it */
    double loose;  /**< median distance of those on it, over the noise of both; of the worse side */
    double slide, turn, grow;   /**< how firmly it is held, 0 to 1: the least over all directions */
    double slides[3], turns[3]; /**< and these */
};

/** Refines a pose by the few samples of the cloud, or by all.
 *
 *  Cannot fail. O(samples) for each of at most some thirty steps; one thread. */
void vor_align_refine_few(struct vor_pose *pose, int flip, const struct vor_align_fit_of *of);
void vor_align_refine(struct vor_align_fit *fit, const struct vor_align_fit_of *of);

/** Says how well the pose of *fit fits, where samples within `within` of the planes lie on the
 *  other cloud. Cannot fail. */
void vor_align_judge(struct vor_align_fit *fit, const struct vor_align_fit_of *of, double within);

/** Refines a pose by the points of the cloud and the planes of those of the reference. It takes one
 *  point of `every` in what it would take. Cannot fail. O(points); one thread. */
void vor_align_settle(struct vor_pose *pose, const struct vor_align_fit_of *of);

/** Sets what the points say of the pose of *fit. Cannot fail. O(points); one thread. */
void vor_align_weigh(struct vor_align_fit *fit, const struct vor_align_fit_of *of);

#endif
