/* The capped allocator. */
#include "tests/support/vt.h"

#include <pthread.h>
#include <stdint.h>
#include <string.h>

VT_TEST(what_is_freed_is_given_back)
{
    struct vor_memory memory;
    void *p[10];

    vor_memory_init(&memory, 1 << 20);
    for (size_t i = 0; i < 10; i++) {
        p[i] = vor_malloc(&memory, i * 1000, 3);
        ck_assert_ptr_nonnull(p[i]);
        ck_assert_uint_eq((uintptr_t)p[i] % 64, 0);
        memset(p[i], 0xff, i * 3000);
    }
    ck_assert_uint_ge(atomic_load(&memory.used), 45 * 3000);
    ck_assert_uint_eq(atomic_load(&memory.calls), 10);
    for (size_t i = 0; i < 10; i++)
        vor_free(&memory, p[i]);
    vor_free(&memory, NULL);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    ck_assert_uint_ge(atomic_load(&memory.peak), 45 * 3000);
}

VT_TEST(the_cap_holds_and_what_fits_under_it_is_given)
{
    struct vor_memory memory;
    void *p, *q;

    vor_memory_init(&memory, 10000);
    ck_assert_ptr_null(vor_malloc(&memory, 10001, 1));
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    p = vor_malloc(&memory, 6000, 1);
    ck_assert_ptr_nonnull(p);
    ck_assert_ptr_null(vor_malloc(&memory, 6000, 1));
    q = vor_malloc(&memory, 2000, 1);
    ck_assert_ptr_nonnull(q);
    vor_free(&memory, p);
    p = vor_malloc(&memory, 6000, 1);
    ck_assert_ptr_nonnull(p);
    ck_assert_uint_le(atomic_load(&memory.peak), 10000);
    vor_free(&memory, p);
    vor_free(&memory, q);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
}

VT_TEST(a_product_that_overflows_is_refused)
{
    struct vor_memory memory;

    vor_memory_init(&memory, SIZE_MAX);
    ck_assert_ptr_null(vor_malloc(&memory, SIZE_MAX, 2));
    ck_assert_ptr_null(vor_malloc(&memory, (size_t)1 << 62, 4));
    ck_assert_ptr_null(vor_calloc(&memory, SIZE_MAX / 8 + 2, 8));
    ck_assert_ptr_null(vor_malloc(&memory, SIZE_MAX, 1));
    ck_assert_ptr_null(vor_malloc(&memory, SIZE_MAX - 100, 1));
    ck_assert_ptr_null(vor_realloc(&memory, NULL, SIZE_MAX, 16));
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
}

VT_TEST(nothing_is_a_valid_pointer)
{
    struct vor_memory memory;
    void *p, *q;

    vor_memory_init(&memory, SIZE_MAX);
    p = vor_malloc(&memory, 0, 8);
    q = vor_calloc(&memory, 8, 0);
    ck_assert(p != NULL && q != NULL && p != q);
    vor_free(&memory, p);
    vor_free(&memory, q);
}

VT_TEST(calloc_is_zero_even_where_memory_was_used)
{
    struct vor_memory memory;

    vor_memory_init(&memory, SIZE_MAX);
    for (size_t round = 0; round < 20; round++) {
        uint8_t *p = vor_calloc(&memory, 100, 7);

        ck_assert_ptr_nonnull(p);
        for (size_t i = 0; i < 700; i++)
            ck_assert_uint_eq(p[i], 0);
        memset(p, 0xee, 700);
        vor_free(&memory, p);
    }
}

VT_TEST(realloc_keeps_the_content_and_the_old_block_on_failure)
{
    struct vor_memory memory;
    uint8_t *p, *grown;
    size_t used;

    vor_memory_init(&memory, 100000);
    p = vor_realloc(&memory, NULL, 100, 1);
    ck_assert_ptr_nonnull(p);
    for (int i = 0; i < 100; i++)
        p[i] = (uint8_t)i;
    grown = vor_realloc(&memory, p, 5000, 2);
    ck_assert_ptr_nonnull(grown);
    for (int i = 0; i < 100; i++)
        ck_assert_uint_eq(grown[i], i);
    used = atomic_load(&memory.used);
    ck_assert_ptr_null(vor_realloc(&memory, grown, 100000, 1));
    ck_assert_uint_eq(atomic_load(&memory.used), used);
    for (int i = 0; i < 100; i++)
        ck_assert_uint_eq(grown[i], i);
    p = vor_realloc(&memory, grown, 10, 1);
    ck_assert_ptr_nonnull(p);
    for (int i = 0; i < 10; i++)
        ck_assert_uint_eq(p[i], i);
    vor_free(&memory, p);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
}

VT_TEST(the_call_asked_to_fail_fails_and_no_other)
{
    for (size_t k = 0; k <= 5; k++) {
        struct vor_memory memory;

        vor_memory_init(&memory, SIZE_MAX);
        memory.fail_at = k;
        for (size_t call = 1; call <= 6; call++) {
            void *p = call % 2 == 0 ? vor_malloc(&memory, 8, 1) : vor_calloc(&memory, 8, 1);

            ck_assert_int_eq(p == NULL, call == k);
            vor_free(&memory, p);
        }
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
}

VT_TEST(a_library_s_own_bytes_count_against_the_cap)
{
    struct vor_memory memory;

    vor_memory_init(&memory, 1000);
    ck_assert(vor_memory_charge(&memory, 1000));
    ck_assert(!vor_memory_charge(&memory, 1));
    ck_assert(!vor_memory_charge(&memory, SIZE_MAX));
    ck_assert_ptr_null(vor_malloc(&memory, 1, 1));
    ck_assert_uint_eq(atomic_load(&memory.used), 1000);
    vor_memory_release(&memory, 600);
    ck_assert(vor_memory_charge(&memory, 600));
    vor_memory_release(&memory, 1000);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    ck_assert_uint_eq(atomic_load(&memory.peak), 1000);
}

enum { THREADS = 4, ROUNDS = 2000 };

static void *churn(void *ctx)
{
    struct vor_memory *memory = ctx;

    for (size_t i = 0; i < ROUNDS; i++) {
        void *p = vor_malloc(memory, 1 + i % 700, 3);

        if (p != NULL)
            memset(p, 1, (1 + i % 700) * 3);
        vor_free(memory, p);
    }
    return NULL;
}

VT_TEST(threads_share_one_cap)
{
    struct vor_memory memory;
    pthread_t threads[THREADS];

    vor_memory_init(&memory, 5000);
    for (int i = 0; i < THREADS; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, churn, &memory), 0);
    for (int i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    ck_assert_uint_le(atomic_load(&memory.peak), 5000);
    ck_assert_uint_eq(atomic_load(&memory.calls), THREADS * ROUNDS);
}
