/** Telling the watch of a step that moved points. */
#ifndef VOR_SEEDS_TELL_H
#define VOR_SEEDS_TELL_H

#include "core/report.h"
#include "core/seeds/seeds.h"

/** Tells a run's watch where n points on a domain are (n x 3, normalised) and the record of the
 * step that brought them there. Returns its answer; VOR_CONTINUE where nobody listens. */
enum vor_answer vor_points_tell(const struct vor_domain *domain, const float *xyz, size_t n,
                                const struct vor_run *run, const struct vor_record *record);

/** The same of seeds. */
enum vor_answer vor_seeds_tell(const struct vor_seeds *seeds, const struct vor_run *run,
                               const struct vor_record *record);

#endif
