/** What a method of spreading points is. The table of methods stands in core/engine.c. */
#ifndef VOR_METHOD_H
#define VOR_METHOD_H

#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** One method. Its name is the word of parameter `method`. */
struct vor_method {
    const char *name;

    /** Places exactly n >= 1 points on the domain, telling run's watch after each step of a stage
     *  (core/report.h).
     *
     *  @param[out]    out     free with vor_seeds_free; on the whole domain; untouched on failure
     *  @param[in,out] told    all zero at first; the method sets what it did
     *  @param[in]     domain  must outlive *out, as must run's watches
     *  @param[in]     run     VOR_STOP ends the run with the best positions so far: the method uses
     *                         vor_run_unstoppable while there are none to hand back
     *
     *  @retval VOR_E_CANCELLED the watch answered VOR_CANCEL
     *  @retval VOR_E_DEGENERATE, VOR_E_NOMEM
     *
     *  On the run's pool. The same points for any number of threads. */
    vor_status (*run)(struct vor_seeds *out, struct vor_outcome *told,
                      const struct vor_domain *domain, size_t n, const struct vor_spec *spec,
                      const struct vor_run *run, struct vor_error *err);
};

#endif
