/** Loops over lanes, for the compiler to turn into vector instructions. */
#ifndef VOR_BASE_VECTOR_H
#define VOR_BASE_VECTOR_H

/** Before a function: it is also compiled for wider vectors, and the program picks the one for its
 *  machine when it starts. What the function computes must not depend on the width: element by
 *  element, no sums across lanes; multiply-adds are not contracted anyway. Not with sanitizers,
 *  which crash when the program picks. Measured: without it a search of knn_boxes takes half as
 *  long again. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__OPTIMIZE__) &&    \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(VOR_NO_CLONES)
#define VOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define VOR_HAS_CLONES 1
#else
#define VOR_CLONES
#define VOR_HAS_CLONES 0
#endif

/** The vectors that such functions were picked for: x86-64-v4 (512 bits), x86-64-v3 (256), or
 *  baseline, the narrowest of the machine's architecture. Results are the same for each. */
static inline const char *vor_vector_name(void)
{
#if VOR_HAS_CLONES
    __builtin_cpu_init();
    if (__builtin_cpu_supports("x86-64-v4"))
        return "x86-64-v4";
    if (__builtin_cpu_supports("x86-64-v3"))
        return "x86-64-v3";
#endif
    return "baseline";
}

/** Before a static function that such a function calls: it becomes part of it. A call would go to
 *  code for the narrowest vectors. */
#define VOR_INLINE static inline __attribute__((always_inline))

#endif
