/** Moves a cloud onto a reference from a pose near the right one: iterative closest points, to the
 *  planes of the reference's samples.
 *
 *  Source: Chen and Medioni 1992, "Object modelling by registration of multiple range images";
 *  Chetverikov et al. 2005, "Robust Euclidean alignment of 3D point sets: the trimmed ICP". */
#ifndef VOR_ALIGN_FIT_H
#define VOR_ALIGN_FIT_H

#include "core/align/match.h"

/** What is fitted to what. */
struct vor_align_fit_of {
    const struct vor_align_samples *cloud, *reference;
    const struct vor_align_grid *grid; /**< of the reference */
    int scales;                        /**< the scale is free */
    unsigned every;                    /**< one sample in so many is looked at, */
    unsigned first;                    /**< as poses are refined from this one on */
    double overlap;                    /**< share of the cloud that has a counterpart; 0: unknown */
};

/** How well a pose fits. Lengths are normalised. */
struct vor_align_fit {
    struct vor_pose pose;
    int flip;
    double score;             /**< share of both clouds' samples that lie on the other one */
    double agree;             /**< how well those lie on it that are near it, 0 to 1 */
    double overlap[2];        /**< of the cloud's, of the reference's */
    double conflict[2];       /**< share of those that are near the other cloud, but not on it */
    double rms;               /**< distance of the cloud's samples to the planes that they lie on */
    double median;            /**< of these distances */
    double slide, turn, grow; /**< how firmly it is held, 0 to 1: the least over all directions */
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

/** Median distance of the samples to the plane of the one nearest to each: what noise and curvature
 *  leave between samples of one surface. 0 where all of these face other ways. O(samples); one
 *  thread. */
double vor_align_roughness(const struct vor_align_samples *samples);

#endif
