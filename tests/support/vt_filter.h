/** Spheres with noise and strays, and requests that filter them. */
#ifndef VT_FILTER_H
#define VT_FILTER_H

#include "tests/support/vt_ask.h"

enum { VT_STRAYS = 60 };

/** Gives each point its number as an attribute. */
void vt_number(struct vor_cloud *cloud);

/** The number of the point of the input that point i was. */
size_t vt_number_of(const struct vor_cloud *cloud, size_t i);

/** Moves every point of a sphere or square along its normal by normally distributed lengths. */
void vt_noise_radial(struct vor_cloud *cloud, uint64_t seed, double deviation, int is_sphere);

/** Moves the first VT_STRAYS points off the unit sphere, by a tenth of its radius to a whole one.
 */
void vt_stray(struct vor_cloud *cloud, uint64_t seed);

/** How far point i, and the rms of all, are off the unit sphere. */
double vt_off_sphere(const struct vor_cloud *cloud, size_t i);
double vt_rms_off_sphere(const struct vor_cloud *cloud);

/** One request to resample with these filters and outliers, on two threads; none may fail. */
void vt_filter(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
               const char *filters, const char *outliers);

#endif
