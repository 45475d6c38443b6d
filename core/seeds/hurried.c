#include "core/seeds/hurried.h"

#include "core/base/linalg.h"

#include <math.h>

static unsigned few_of(const struct vor_domain *domain)
{
    return domain->n < VOR_PLANE_POINTS ? (unsigned)domain->n : VOR_PLANE_POINTS;
}

double vor_hurried_area(const struct vor_domain *domain, const float x[3])
{
    unsigned k = few_of(domain);
    uint32_t index[VOR_PLANE_POINTS];
    float distance2[VOR_PLANE_POINTS];

    vor_knn_search(domain->knn, x, 1, k, index, distance2);
    return M_PI * (double)distance2[k - 1] / (k - 1);
}

void vor_hurried_draw(float out[3], const struct vor_domain *domain, const float x[3],
                      const double unit[2])
{
    unsigned k = few_of(domain);
    uint32_t index[VOR_PLANE_POINTS];
    float distance2[VOR_PLANE_POINTS];
    const float *to;

    vor_knn_search(domain->knn, x, 1, k, index, distance2);
    to = &domain->xyz[3 * (size_t)index[1 + (unsigned)(unit[0] * (k - 1))]];
    for (int c = 0; c < 3; c++)
        out[c] = x[c] + (float)(unit[1] / 2) * (to[c] - x[c]);
}

int vor_hurried_hold(float x[3], const struct vor_domain *domain, double far)
{
    const float *foot;
    uint32_t index;
    float distance2;

    vor_knn_search(domain->knn, x, 1, 1, &index, &distance2);
    if ((double)distance2 <= far * far)
        return 0;
    foot = &domain->xyz[3 * (size_t)index];
    for (int c = 0; c < 3; c++)
        x[c] = foot[c] + (float)(far / sqrt((double)distance2)) * (x[c] - foot[c]);
    return 1;
}
