/** Random numbers that depend on (seed, stream, index) alone, not on a state, an order or a thread.
 *
 *  Source: the finaliser of SplitMix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom
 *  number generators"), applied to a counter. */
#ifndef VOR_BASE_RNG_H
#define VOR_BASE_RNG_H

#include <stdint.h>

static inline uint64_t vor_rng_mix(uint64_t z)
{
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/** 64 random bits for draw `index` of stream `stream` under `seed`. */
static inline uint64_t vor_rng_bits(uint64_t seed, uint64_t stream, uint64_t index)
{
    uint64_t z = vor_rng_mix(seed + UINT64_C(0x9e3779b97f4a7c15));

    z = vor_rng_mix(z ^ (stream + UINT64_C(0x9e3779b97f4a7c15)));
    return vor_rng_mix(z + (index + 1) * UINT64_C(0x9e3779b97f4a7c15));
}

/** Uniform in [0, 1), 53 bits. */
static inline double vor_rng_unit(uint64_t seed, uint64_t stream, uint64_t index)
{
    return (double)(vor_rng_bits(seed, stream, index) >> 11) * 0x1p-53;
}

/** Uniform in 0 .. bound - 1 (bound > 0); the bias is below bound / 2^64. */
static inline uint64_t vor_rng_below(uint64_t seed, uint64_t stream, uint64_t index, uint64_t bound)
{
    return (uint64_t)(((unsigned __int128)vor_rng_bits(seed, stream, index) * bound) >> 64);
}

#endif
