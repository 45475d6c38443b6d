/** The kinds of children that the daemon forks from its zygote: one table. */
#ifndef VOR_SERVER_WORK_KINDS_H
#define VOR_SERVER_WORK_KINDS_H

#include "server/proc/zygote.h"

/** Numbers of the kinds, for vor_zygote_spawn. */
enum vor_child_number {
    VOR_CHILD_CODEC,  /**< one piece of work with strangers' bytes: codec_child.h */
    VOR_CHILD_WORKER, /**< runs of jobs: station.h */
    VOR_CHILD_KINDS
};

extern const struct vor_child_kind vor_child_kinds[VOR_CHILD_KINDS];

#endif
