/** Clouds of ../shared/data. */
#ifndef VT_DATA_H
#define VT_DATA_H

#include "core/cloud/cloud.h"

/** Reads a file of ../shared/data. False if it is not there (vt_data_or_skip). */
int vt_cloud_open(struct vor_cloud *cloud, const char *name);

#endif
