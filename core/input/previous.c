#include "core/input/previous.h"

#include "core/base/stat.h"

#include <float.h>
#include <math.h>

/* Leaves numbers for as many points as a cloud may have. */
#define TRACK_MAX (UINT32_MAX - VOR_POINTS_MAX)

/* Checks that no two points have one number. */
static vor_status check_distinct(const struct vor_previous *taken, struct vor_error *err)
{
    double *sorted = vor_malloc(taken->memory, taken->n, sizeof *sorted), twice = -1;

    if (sorted == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", taken->n);
    for (size_t i = 0; i < taken->n; i++)
        sorted[i] = taken->track[i];
    vor_sort_doubles(sorted, taken->n);
    for (size_t i = 1; i < taken->n && twice < 0; i++)
        if (sorted[i] <= sorted[i - 1])
            twice = sorted[i];
    vor_free(taken->memory, sorted);
    if (twice < 0)
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, "previous",
                          "two points of the previous cloud have the " VOR_TRACK
                          " %.0f, want a number of its own for each",
                          twice);
}

static vor_status take_tracks(struct vor_previous *out, const struct vor_attribute *track,
                              struct vor_error *err)
{
    for (size_t i = 0; i < out->n; i++) {
        double value =
            track != NULL ? vor_attribute_scalar(track, i * track->components) : (double)i;

        if (!(value >= 0 && value <= (double)TRACK_MAX && value == floor(value)))
            return vor_fail_param(err, VOR_E_PARAM, "previous",
                                  "the " VOR_TRACK
                                  " of point %zu of the previous cloud is %g, want "
                                  "a whole number from 0 to %zu",
                                  i, value, (size_t)TRACK_MAX);
        out->track[i] = (uint32_t)value;
        if (out->track[i] >= out->unused)
            out->unused = out->track[i] + 1;
    }
    return track != NULL ? check_distinct(out, err) : VOR_OK;
}

vor_status vor_previous_take(struct vor_previous *out, const struct vor_cloud *from,
                             const double middle[3], double unit, struct vor_memory *memory,
                             struct vor_error *err)
{
    struct vor_previous taken = {.memory = memory, .n = from->n};
    vor_status status;

    if (VOR_MAKE_ALL(memory, err, from->n, VOR_ARRAY(taken.xyz, taken.n, 3),
                     VOR_ARRAY(taken.track, taken.n, 1),
                     VOR_ZEROED(taken.bent, taken.n, 1)) != VOR_OK) {
        vor_previous_free(&taken);
        return VOR_E_NOMEM;
    }
    status = take_tracks(&taken, vor_cloud_find_name(from, VOR_TRACK), err);
    if (status != VOR_OK) {
        vor_previous_free(&taken);
        return status;
    }
    for (size_t i = 0; i < taken.n; i++) {
        double x[3];

        vor_cloud_position(from, i, x);
        for (size_t c = 0; c < 3; c++)
            taken.xyz[3 * i + c] =
                (float)fmax(-(double)FLT_MAX, fmin((x[c] - middle[c]) / unit, (double)FLT_MAX));
    }
    *out = taken;
    return VOR_OK;
}

void vor_previous_free(struct vor_previous *previous)
{
    if (previous->memory != NULL)
        VOR_FREE_ALL(previous->memory, previous->bent, previous->track, previous->xyz);
    *previous = (struct vor_previous){.n = 0};
}
