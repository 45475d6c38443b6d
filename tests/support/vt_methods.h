/** Every process and every method, as rows for the drivers. */
#ifndef VT_METHODS_H
#define VT_METHODS_H

#include "tests/support/vt_drive.h"

enum { VT_METHODS_MAX = 64 };

/** Requests that between them run each process, method, filter, density, metric, treatment of
 *  borders and sheets, and order. The last row's name is NULL. */
extern const struct vt_row vt_methods[VT_METHODS_MAX];

/** A sphere, and the first 30 of its points close together and far from all others. */
void vt_cloud_island(struct vor_cloud *cloud, uint64_t seed, size_t n);

/** How many requests there are. */
int vt_methods_count(void);

#endif
