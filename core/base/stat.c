#include "core/base/stat.h"

#include <stdlib.h>

static int ascending_float(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;

    return (x > y) - (x < y);
}

static int ascending_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

void vor_sort_floats(float *values, size_t n)
{
    qsort(values, n, sizeof *values, ascending_float);
}

void vor_sort_doubles(double *values, size_t n)
{
    const size_t few = 32;

    for (size_t i = 1; n <= few && i < n; i++) { /* a sixth of the time */
        double value = values[i];
        size_t at = i;

        for (; at > 0 && value < values[at - 1]; at--)
            values[at] = values[at - 1];
        values[at] = value;
    }
    if (n > few)
        qsort(values, n, sizeof *values, ascending_double);
}

double vor_quantile(const float *sorted, size_t n, double share)
{
    double rank = share * (double)(n - 1);
    size_t low = (size_t)rank;

    if (low + 1 >= n)
        return (double)sorted[n - 1];
    return (double)sorted[low] +
           (rank - (double)low) * ((double)sorted[low + 1] - (double)sorted[low]);
}
