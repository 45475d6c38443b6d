/** Loops over lanes, for the compiler to turn into vector instructions. */
#ifndef VOR_BASE_VECTOR_H
#define VOR_BASE_VECTOR_H

/** Before a function: compiled for wider vectors too, and the one for this machine is picked when
 *  the program starts. What it computes must not depend on the width: element by element, no sums
 *  across lanes; multiply-adds are not contracted anyway. Sanitizers cannot stand the picking. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__OPTIMIZE__) &&    \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(VOR_NO_CLONES)
#define VOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define VOR_CLONES
#endif

/** A static function that is to be a part of such a one: what is called from it instead is compiled
 *  once, for the narrowest vectors. */
#define VOR_INLINE static inline __attribute__((always_inline))

#endif
