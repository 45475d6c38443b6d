#include "core/base/linalg.h"
#include "core/input/adjacency.h"
#include "core/input/back.h"
#include "core/input/orient.h"

#include <float.h>

/* How far point i is from x, squared, with what lies along the normal at x counted twice: the other
 * face of a thin wall may be nearer than the points of its own. */
static double distance_on_sheet(const struct vor_domain *on, size_t i, const float x[3],
                                const double normal[3])
{
    double from[3], along;

    for (size_t c = 0; c < 3; c++)
        from[c] = (double)on->xyz[3 * i + c] - (double)x[c];
    along = vor_dot(from, normal);
    return vor_dot(from, from) + along * along;
}

double vor_orientation_side(const struct vor_orientation *orientation,
                            const struct vor_domain *domain, const float x[3], double normal[3],
                            double toward[3], struct vor_knn_last *last)
{
    const struct vor_domain *on = orientation->thin.n > 0 ? &orientation->thin : domain;
    unsigned k = on->n < VOR_ADJACENT ? (unsigned)on->n : VOR_ADJACENT;
    uint32_t index[VOR_ADJACENT];
    float distance2[VOR_ADJACENT];
    struct vor_implicit back;
    double own[3];

    toward[0] = toward[1] = toward[2] = 0;
    vor_knn_search_next(on->knn, last, x, k, index, distance2);
    if ((orientation->back[index[0]] == VOR_BACK || orientation->back[index[0]] == VOR_BACK_FEW) &&
        vor_back_fit(&back, on, x)) {
        double agree = 0;

        for (unsigned j = 0; j < k; j++)
            agree += vor_back_along(&back, &on->xyz[3 * (size_t)index[j]],
                                    &orientation->normal[3 * (size_t)index[j]]);
        vor_implicit_normal(&back, x, toward);
        for (int c = 0; c < 3; c++)
            toward[c] *= agree < 0 ? -1 : 1;
        agree = vor_dot(toward, normal);
        for (int c = 0; c < 3; c++)
            normal[c] = agree < 0 ? -toward[c] : toward[c];
        return agree;
    }
    for (unsigned j = 0; j < k; j++) {
        double d2 = distance_on_sheet(on, index[j], x, normal);

        vor_to_doubles(own, &orientation->normal[3 * (size_t)index[j]]);
        for (int c = 0; c < 3; c++)
            toward[c] += own[c] / fmax(d2 * d2, DBL_MIN);
    }
    return vor_dot(toward, normal);
}
