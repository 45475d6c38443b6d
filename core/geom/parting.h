/** Groups of nodes by pairs that belong together and pairs that do not, of which some are wrong.
 *
 *  Source: Wolf et al. 2018, "The Mutex Watershed: Efficient, Parameter-Free Image Partitioning",
 *  algorithm 1: the strongest pair decides first; one that joins makes one group of two unless they
 *  were parted, one that parts keeps two groups from ever becoming one.
 *  Departure: one strong wrong pair must not join two large groups. So groups grow by levels, and
 *  at each the sum of all pairs between two groups decides, as in Keuper et al. 2015, "Efficient
 *  decomposition of image and mesh graphs by lifted multicuts". Points of shell60k in a group of
 *  the other sheet, of 60,000: by single pairs 687, by levels 455. */
#ifndef VOR_GEOM_PARTING_H
#define VOR_GEOM_PARTING_H

#include "core/base/run.h"

/** Two different nodes. */
struct vor_bond {
    uint32_t a, b;
    float strength; /**< above 0: they belong together; below: they do not */
};

/** Finds the groups.
 *
 *  @param[out]    group  n: the same for all nodes of a group: the number of its first one
 *  @param[in,out] bond   count pairs; lost. The groups do not depend on their order
 *
 *  @retval VOR_E_NOMEM 16 bytes a node, 12 a pair and 16 one that parts do not fit, or such pairs
 *                      are 2^31 or more
 *  @retval VOR_E_CANCELLED, VOR_E_STOPPED  as vor_run_for, asked after each level
 *
 *  O(count log count) and, for each pair that is asked about, the groups parted from the one of
 *  its two that fewer were parted from: O(count^1.5) at worst. One thread. */
VOR_NODISCARD vor_status vor_parting_make(uint32_t *group, size_t n, struct vor_bond *bond,
                                          size_t count, const struct vor_run *run,
                                          struct vor_error *err);

#endif
