#include "core/input/remote.h"

#include "core/base/stat.h"
#include "core/input/conditioning.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Points that the middle of the cloud is taken from, at equal steps. */
enum { SAMPLES = VOR_NEIGHBORS_PLACES };

/* How much farther than usual from the middle a point must be: beside it, float32 leaves the others
 * some thousand places along each axis, of which the engine's fits tell few apart. */
#define REMOTE 1e4

static double distance(const struct vor_cloud *cloud, size_t i, const double middle[3])
{
    double sum = 0;

    for (size_t c = 0; c < 3; c++) {
        double d = (double)cloud->xyz[3 * i + c] - middle[c];

        sum += d * d;
    }
    return sqrt(sum);
}

/* The median over the samples of a coordinate or, with a middle, of their distance from it. */
static double median(const struct vor_cloud *cloud, size_t step, size_t c, const double *middle)
{
    double value[SAMPLES] = {0}; /* cppcheck cannot see that n >= 1 */
    size_t count = 0;

    for (size_t i = 0; i < cloud->n && count < SAMPLES; i += step)
        value[count++] =
            middle != NULL ? distance(cloud, i, middle) : (double)cloud->xyz[3 * i + c];
    vor_sort_doubles(value, count);
    return value[count / 2];
}

int vor_remote_is(const struct vor_remote *remote, const struct vor_cloud *cloud, size_t i)
{
    return remote->count > 0 && distance(cloud, i, remote->middle) > remote->near;
}

void vor_remote_find(struct vor_remote *out, const struct vor_cloud *cloud)
{
    size_t step = cloud->n / SAMPLES + 1;
    struct vor_remote remote = {.count = 0};

    for (size_t c = 0; c < 3 && cloud->n > 0; c++)
        remote.middle[c] = median(cloud, step, c, NULL);
    remote.near = cloud->n > 0 ? REMOTE * median(cloud, step, 0, remote.middle) : 0;
    for (size_t i = 0; i < cloud->n; i++) {
        double d = distance(cloud, i, remote.middle);

        remote.count += (size_t)(d > remote.near);
        remote.farthest = d > remote.far ? i : remote.farthest;
        remote.far = d > remote.far ? d : remote.far;
    }
    if (remote.count * VOR_REMOTE_FEW > cloud->n)
        remote.count = 0;
    *out = remote;
}

void vor_remote_tell(const struct vor_cloud *cloud, struct vor_error *err)
{
    struct vor_remote remote;
    size_t length;
    double x[3];

    if (err == NULL)
        return;
    vor_remote_find(&remote, cloud);
    if (remote.count == 0)
        return;
    vor_cloud_position(cloud, remote.farthest, x);
    length = strlen(err->message);
    (void)snprintf(err->message + length, sizeof err->message - length,
                   "; point %zu at %.9g %.9g %.9g is %.3g away from the other points. At this "
                   "distance, float32 cannot separate the other points. outliers=drop leaves "
                   "the far point out",
                   remote.farthest, x[0], x[1], x[2], remote.far);
}
