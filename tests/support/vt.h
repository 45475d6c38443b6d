/** What every test program needs: a runner that prints TAP, seeds, allocator and clouds. */
#ifndef VT_H
#define VT_H

#include "core/base/memory.h"
#include "core/base/parallel.h"
#include "core/base/rng.h"
#include "core/cloud/cloud.h"

#include <check.h>
#include <stddef.h>
#include <stdint.h>

/** A test, with its body behind it; or a loop of `loops` seeds of one (_i = 0 .. loops - 1), of
 * which a file needs no list. VT_TEST_FIGURES is for a test of what comes out, whatever the
 * threads: none under ThreadSanitizer, which looks at how they meet, in the other tests of the same
 * code. VT_FIGURES is 0 there: for such a part of a test. */
#define VT_TEST(name) VT_TEST_LOOP(name, 0)
#define VT_TEST_LOOP(name, loops)                                                                  \
    static void name##_fn(int _i);                                                                 \
    static const TTest name = {#name, name##_fn, __FILE__, __LINE__};                              \
    static int name##_loops(void)                                                                  \
    {                                                                                              \
        return loops;                                                                              \
    }                                                                                              \
    __attribute__((constructor)) static void name##_register(void)                                 \
    {                                                                                              \
        vt_register(&name, name##_loops);                                                          \
    }                                                                                              \
    static void name##_fn(int _i VOR_UNUSED)
#if defined(__SANITIZE_THREAD__)
#define VT_FIGURES 0
#define VT_TEST_FIGURES(name, loops)                                                               \
    static void name##_fn(int _i);                                                                 \
    __attribute__((unused)) static const TTest name = {#name, name##_fn, __FILE__, __LINE__};      \
    static void name##_fn(int _i VOR_UNUSED)
#else
#define VT_FIGURES 1
#define VT_TEST_FIGURES(name, loops) VT_TEST_LOOP(name, loops)
#endif
void vt_register(const TTest *test, int (*loops)(void));

/** Before the tests, in a program that has to prepare something, or adds tests that depend on more
 *  than their place; one that wants more than that has a main() of its own. */
void vt_suite(Suite *suite) __attribute__((weak));

/** Runs a suite and all that was registered, file by file and line by line, prints TAP on stdout,
 * returns the exit status for main(). */
int vt_run(Suite *suite);

/** JSON that must be valid, and elements or members of a value. */
struct vor_json;
struct vor_json *vt_json(const char *json);
size_t vt_json_count(const struct vor_json *value);

/** Adds a case with one test, or with a loop of `loops` seeds (_i = 0 .. loops - 1). */
#define vt_add(suite, test) vt_add_loop(suite, test, 0)
#define vt_add_loop(suite, test, loops) vt_add_case(suite, #test, test, loops)

/** Loops of a test that costs much. VT_FEWER: a quarter under AddressSanitizer, where each takes
 *  four times as long. Both: one under ThreadSanitizer, where each takes twelve times as long, and
 *  which looks at how threads meet and not at what they come to. VT_STEP: of moments tried one by
 *  one, each 4th and each 16th there. VT_STEP_FAILS: of allocations that fail one by one, each
 *  2nd under AddressSanitizer and each 16th under ThreadSanitizer.
 *  VT_SMALLER: by what a cloud is smaller of which only threads are judged. */
#if defined(__SANITIZE_THREAD__)
#define VT_FEWER(loops) 1
#define VT_ONCE(loops) 1
#define VT_STEP 16
#define VT_STEP_FAILS 16
#define VT_SMALLER 4
#elif defined(__SANITIZE_ADDRESS__)
#define VT_FEWER(loops) (((loops) + 3) / 4)
#define VT_ONCE(loops) (loops)
#define VT_STEP 4
#define VT_STEP_FAILS 2
#define VT_SMALLER 1
#else
#define VT_FEWER(loops) (loops)
#define VT_ONCE(loops) (loops)
#define VT_STEP 1
#define VT_STEP_FAILS 1
#define VT_SMALLER 1
#endif

/** Loops that are a seed each: `few` in every run, `many` in `make soak`. The same is asserted. */
#define VT_SOAK_LOOPS(few, many) (vt_soaks() ? (many) : (few))

/** True in `make soak`, which sets VT_SOAK. */
int vt_soaks(void);
void vt_add_case(Suite *suite, const char *name, const TTest *test, int loops);

/** Waits a millisecond, between two looks of a test at what another thread or process does. */
void vt_nap(void);

/** Check tells its runner of each assertion that holds, by a system call: half of the time of a
 * test that looks at every point. Here it tells of one in some milliseconds, which serves for the
 * place that is named when a test crashes or hangs. */
void vt_held(const char *file, int line);
#undef ck_assert_msg
#define ck_assert_msg(expr, ...)                                                                   \
    ((expr)                                                                                        \
         ? vt_held(__FILE__, __LINE__)                                                             \
         : _ck_assert_failed(__FILE__, __LINE__, "Assertion '" #expr "' failed", ##__VA_ARGS__))

/** The last error of the code under test; pass &vt_err and assert. */
extern struct vor_error vt_err;

#define vt_assert_ok(expression)                                                                   \
    do {                                                                                           \
        vor_status vt_status_ = (expression);                                                      \
        ck_assert_msg(vt_status_ == VOR_OK, "%s: %s: %s", #expression,                             \
                      vor_status_slug(vt_status_), vt_err.message);                                \
    } while (0)

#define vt_assert_fails(expected, expression)                                                      \
    do {                                                                                           \
        vor_status vt_status_ = (expression);                                                      \
        ck_assert_msg(vt_status_ == (expected), "%s: got %s, want %s (%s)", #expression,           \
                      vor_status_slug(vt_status_), vor_status_slug(expected), vt_err.message);     \
    } while (0)

/** An uncapped allocator shared by a test. Nothing may be left in it at the end of each test, which
 *  looks by vt_assert_no_leak. */
extern struct vor_memory vt_memory;
void vt_assert_no_leak(void);

/** Frees two clouds. */
void vt_free_last(struct vor_cloud *one, struct vor_cloud *other);

/** That two clouds have the same points and attributes, bit for bit. */
void vt_assert_same(const struct vor_cloud *a, const struct vor_cloud *b);

/** Calls attempt with the first allocation of vt_memory failing, then the second, until it returns
 *  VOR_OK, which frees what it made. Asserts that it wants memory, returns VOR_E_NOMEM each time
 *  before, and leaves as many bytes in use as there were. */
void vt_fail_each(vor_status (*attempt)(void *ctx), void *ctx);

/** The index-th uniform number in [0, 1) of a seed. */
double vt_unit(uint64_t seed, uint64_t index);

/** Reflects x by the mirror across a vector of any length, 0 being no mirror; both have n numbers.
 */
void vt_reflect(double *x, const double *across, int n);

/** n points in the unit cube / on the unit sphere / on a unit square with z = 0, float32. The cloud
 *  allocates from vt_memory; free it with vor_cloud_free. */
void vt_cloud_cube(struct vor_cloud *cloud, uint64_t seed, size_t n);
void vt_cloud_sphere(struct vor_cloud *cloud, uint64_t seed, size_t n);
void vt_cloud_square(struct vor_cloud *cloud, uint64_t seed, size_t n);

/** A whole file in memory (malloc), or NULL; *size gets its length. */
uint8_t *vt_slurp(const char *path, size_t *size);

/** Path of a file in ../shared/data, or NULL when it is not there. */
const char *vt_data(const char *name);

/** The same for a test that is skipped without it: prints a comment that names it, and returns
 * NULL; fails the test where CI is set, which has them all. */
const char *vt_data_or_skip(const char *name);

/** A sink (proto/codec.h) that collects bytes. */
struct vt_bytes {
    uint8_t *data;
    size_t size, capacity;
};
int vt_bytes_write(void *bytes, const void *data, size_t size);

#endif
