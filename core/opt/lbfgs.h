/** Minimises a smooth function of many variables, of which the gradient is known.
 *
 *  Source: Nocedal 1980, "Updating quasi-Newton matrices with limited storage"; Chen et al. 2018,
 *  "Point cloud resampling using centroidal Voronoi tessellation methods", Sec. 4.3.3, takes five
 *  such steps with a backtracking line search, then changes the function and begins anew.
 *  Departure: the caller may know about how strongly the function bends along each variable. Where
 *  it does, the first step of a run, which knows nothing else, is as good as one of Lloyd's method.
 */
#ifndef VOR_OPT_LBFGS_H
#define VOR_OPT_LBFGS_H

#include "core/base/memory.h"

/** Steps that are remembered, and of a run where the function changes after it: Chen 2018. */
enum { VOR_LBFGS_STEPS = 5 };

/** The function. Its variables are doubles. */
struct vor_lbfgs_function {
    void *ctx;

    /** Computes value and gradient at x. A failure ends the run and is handed on. */
    vor_status (*at)(void *ctx, const double *x, double *value, double *gradient,
                     struct vor_error *err);

    /** Shortens a step from x where it leads too far: may scale its components, by a factor from 0
     *  to 1 each. May be NULL. */
    void (*shorten)(void *ctx, const double *x, double *step);

    const double *bend; /**< about the second derivative along each variable, > 0; NULL: all 1 */
};

/** What is remembered; owns everything. */
struct vor_lbfgs {
    struct vor_memory *memory;
    size_t length;                   /**< variables */
    unsigned depth, begin;           /**< steps that are remembered; slot of the oldest */
    double *step[VOR_LBFGS_STEPS];   /**< from one place to the next */
    double *change[VOR_LBFGS_STEPS]; /**< of the gradient between them */
    double product[VOR_LBFGS_STEPS]; /**< of the two, > 0 */
    double *gradient, *direction, *place, *there; /**< there: the gradient at place */
};

/** What a run did. */
struct vor_lbfgs_told {
    unsigned steps, evaluations;
    double before, after; /**< value of the function at the beginning and at the end */
};

/** Prepares for functions of `length` variables.
 *
 *  @param[out] out  free with vor_lbfgs_free; untouched on failure
 *
 *  @retval VOR_E_NOMEM 112 length bytes do not fit */
VOR_NODISCARD vor_status vor_lbfgs_init(struct vor_lbfgs *out, size_t length,
                                        struct vor_memory *memory, struct vor_error *err);

/** lbfgs may be all zero. */
void vor_lbfgs_free(struct vor_lbfgs *lbfgs);

/** Takes at most `steps` steps from x, remembering none of before. Each lowers the function. Ends
 *  sooner where the gradient is 0, or no step along the direction lowers the function any more.
 *
 *  @param[in,out] x     length doubles; where the function is least of all places it was asked at
 *                       and taken to
 *  @param[out]    told  also on failure
 *
 *  Fails as the function does; x is then the last place taken.
 *
 *  O(length) a step, and about one evaluation. Sums run in the order of the variables: the
 *  same bits whatever the function does with threads. */
VOR_NODISCARD vor_status vor_lbfgs_run(struct vor_lbfgs *lbfgs, double *x,
                                       const struct vor_lbfgs_function *function, unsigned steps,
                                       struct vor_lbfgs_told *told, struct vor_error *err);

#endif
