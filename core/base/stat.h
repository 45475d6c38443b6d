/** Mean, root mean square, maximum and quantiles of numbers, and the order to sort them in. */
#ifndef VOR_BASE_STAT_H
#define VOR_BASE_STAT_H

#include <math.h>
#include <stddef.h>

/** Mean, root mean square and maximum; in the unit of the values. */
struct vor_stat {
    double mean, rms, max;
};

/** Running sums of values >= 0; all zero at first. Merge the sums of blocks in the order of the
 *  blocks: then the same values give the same bits for any number of threads. */
struct vor_sums {
    double sum, sum2, max;
};

/** Adds a value and its square. */
static inline void vor_sums_add(struct vor_sums *sums, double value, double square)
{
    sums->sum += value;
    sums->sum2 += square;
    sums->max = fmax(sums->max, value);
}

/** Adds other sums. */
static inline void vor_sums_merge(struct vor_sums *sums, const struct vor_sums *other)
{
    sums->sum += other->sum;
    sums->sum2 += other->sum2;
    sums->max = fmax(sums->max, other->max);
}

/** Mean, rms and maximum of the n >= 1 values that were added. */
static inline struct vor_stat vor_sums_stat(const struct vor_sums *sums, size_t n)
{
    return (struct vor_stat){sums->sum / (double)n, sqrt(sums->sum2 / (double)n), sums->max};
}

/** Sorts n values, none of them NaN, in ascending order. O(n log n). */
void vor_sort_floats(float *values, size_t n);
void vor_sort_doubles(double *values, size_t n);

/** Index of a quantile of n >= 1 sorted values, share 0 .. 1: the nearest rank below. */
static inline size_t vor_quantile_rank(double share, size_t n)
{
    return (size_t)(share * (double)(n - 1));
}

/** Quantile of n >= 1 sorted values, linear between the two nearest ranks. */
double vor_quantile(const float *sorted, size_t n, double share);

#endif
