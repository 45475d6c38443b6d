/** Mean, root mean square, maximum and quantiles of numbers, and the order to sort them in. */
#ifndef VOR_BASE_STAT_H
#define VOR_BASE_STAT_H

#include <math.h>
#include <stddef.h>

/** Mean, root mean square and maximum; in the unit of the values. */
struct vor_stat {
    double mean, rms, max;
};

/** Running sums of values >= 0; all zero is none. Sums of blocks are merged in the order of the
 *  blocks, so that the same values give the same bits for any number of threads. */
struct vor_sums {
    double sum, sum2, max;
};

/** Takes in a value, whose square the caller has at hand. */
static inline void vor_sums_add(struct vor_sums *sums, double value, double square)
{
    sums->sum += value;
    sums->sum2 += square;
    sums->max = fmax(sums->max, value);
}

/** Takes in what other sums hold. */
static inline void vor_sums_merge(struct vor_sums *sums, const struct vor_sums *other)
{
    sums->sum += other->sum;
    sums->sum2 += other->sum2;
    sums->max = fmax(sums->max, other->max);
}

/** Of the n >= 1 values that were taken in. */
static inline struct vor_stat vor_sums_stat(const struct vor_sums *sums, size_t n)
{
    return (struct vor_stat){sums->sum / (double)n, sqrt(sums->sum2 / (double)n), sums->max};
}

/** Puts the smallest first. No NaN. O(n log n). */
void vor_sort_floats(float *values, size_t n);
void vor_sort_doubles(double *values, size_t n);

/** Index, among n >= 1 sorted values, of the one that `share` (0 .. 1) of them do not exceed: the
 *  nearest rank below. */
static inline size_t vor_quantile_rank(double share, size_t n)
{
    return (size_t)(share * (double)(n - 1));
}

/** Quantile of n >= 1 sorted values, linear between the two nearest ranks. */
double vor_quantile(const float *sorted, size_t n, double share);

#endif
