#include "core/output/sides.h"

#include "core/base/linalg.h"
#include "core/input/carried.h"

#include <math.h>

/* Whether carried normals alone say the sides: with `use` all were checked. */
static vor_status carried_decide(struct vor_sides *sides, const struct vor_sides_of *of,
                                 const struct vor_run *run, struct vor_error *err)
{
    size_t bad = 0, first;
    vor_status status = VOR_OK;

    if (sides->carried == NULL || of->spec->value[VOR_PARAM_NORMALS] != VOR_NORMALS_FIT)
        return VOR_OK;
    if (of->spec->value[VOR_PARAM_INPUT_NORMALS] == VOR_INPUT_NORMALS_AUTO)
        status = vor_carried_count(&bad, &first, sides->carried, of->in->n, run, err);
    sides->carried_decide = bad == 0;
    return status;
}

int vor_sides_asked(const struct vor_spec *spec)
{
    double normals = spec->value[VOR_PARAM_NORMALS];

    return normals == VOR_NORMALS_FIT || normals == VOR_NORMALS_ORIENTED;
}

vor_status vor_sides_find(struct vor_sides *out, const struct vor_sides_of *of,
                          const struct vor_run *run, struct vor_error *err)
{
    struct vor_sides sides = {.domain = of->domain};
    vor_status status;

    if (!vor_sides_asked(of->spec))
        return VOR_OK;
    if (of->spec->value[VOR_PARAM_INPUT_NORMALS] != VOR_INPUT_NORMALS_ESTIMATE)
        sides.carried = vor_carried(of->in);
    status = carried_decide(&sides, of, run, err);
    sides.carried_stay = sides.carried != NULL && !sides.carried_decide &&
                         of->spec->value[VOR_PARAM_NORMALS] == VOR_NORMALS_ORIENTED;
    if (status == VOR_OK && !sides.carried_decide)
        status = vor_orient(&sides.orientation, of->domain,
                            &(struct vor_orient_how){
                                .points = of->points, .area = of->area, .carried = sides.carried},
                            run, err);
    if (status == VOR_OK)
        *out = sides;
    return status;
}

void vor_sides_report(struct vor_report *report, const struct vor_sides *sides)
{
    size_t one_sided = sides->orientation.one_sided;

    report->one_sided = one_sided;
    if (one_sided > 0)
        report->orientation = VOR_ORIENTED_ONE_SIDED;
    else if (sides->orientation.components > 0)
        report->orientation = VOR_ORIENTED_CONSISTENT;
    else if (sides->carried_decide)
        report->orientation = VOR_ORIENTED_CARRIED;
    if (one_sided > 0)
        vor_warn(report->warnings, &report->warnings_count, VOR_WARNING_ONE_SIDED,
                 (double)one_sided, 0);
}

void vor_sides_free(struct vor_sides *sides, struct vor_memory *memory)
{
    vor_orientation_free(&sides->orientation, memory);
}

/* Turns a normal fitted at x to its right side. Where the input's around x lead more than 45
 * degrees away from it, as those of both faces at the rim of a plate, it is theirs together. */
static void turn(double normal[3], const struct vor_sides *sides, const float x[3], uint32_t source)
{
    struct vor_knn_last none = {.k = 0};
    double toward[3], side, length2 = 0;

    if (sides->carried_decide) {
        (void)vor_carried_normal(sides->carried, source, toward);
        side = vor_dot(toward, normal);
    } else {
        side = vor_orientation_side(&sides->orientation, sides->domain, x, normal, toward, &none);
        length2 =
            vor_dot(toward, toward); /* infinite where an input point is; its normal decides */
    }
    if (2 * side * side < length2)
        for (size_t c = 0; c < 3; c++)
            normal[c] = toward[c] / sqrt(length2);
    else if (side < 0)
        for (size_t c = 0; c < 3; c++)
            normal[c] = -normal[c];
}

void vor_sides_normal(float out[3], const struct vor_sides *sides, const float x[3],
                      uint32_t source, const double fitted[3])
{
    double normal[3] = {fitted[0], fitted[1], fitted[2]}, carried[3];

    turn(normal, sides, x, source);
    if (sides->carried_stay && vor_carried_normal(sides->carried, source, carried)) {
        double sign = vor_dot(normal, carried) < 0 ? -1 : 1;

        for (size_t c = 0; c < 3; c++)
            normal[c] = sign * carried[c];
    }
    vor_to_floats(out, normal);
}
