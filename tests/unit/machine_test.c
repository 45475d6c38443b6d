/* What a process of ours takes of the machine. */
#include "server/base/machine.h"
#include "tests/support/vt.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { PIECE = 8 << 20, PAGE = 4096 };

static size_t resident_bytes(void)
{
    FILE *file = fopen("/proc/self/statm", "re");
    unsigned long all, resident;

    ck_assert_ptr_nonnull(file);
    ck_assert_int_eq(fscanf(file, "%lu %lu", &all, &resident), 2);
    (void)fclose(file);
    return resident * PAGE;
}

/* A small block that is allocated behind a large one keeps the top of the heap from going back. */
static void *leave_behind(void)
{
    volatile char *large = malloc(PIECE);
    void *small = malloc(64);

    ck_assert(large != NULL && small != NULL);
    for (size_t i = 0; i < PIECE; i += PAGE)
        large[i] = 1;
    free((void *)(uintptr_t)large);
    return small;
}

START_TEST(large_pieces_go_back_each_time)
{
    size_t before;
    void *small[4];

    vor_machine_give_back();
    before = resident_bytes();
    for (size_t i = 0; i < 4; i++)
        small[i] = leave_behind();
    ck_assert_uint_lt(resident_bytes(), before + PIECE / 4);
    for (size_t i = 0; i < 4; i++)
        free(small[i]);
}
END_TEST

START_TEST(a_machine_has_cores_and_memory)
{
    ck_assert_uint_ge(vor_machine_cores(), 1);
    ck_assert_uint_ge(vor_machine_memory(), (size_t)64 << 20);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("machine");

    vt_add(suite, a_machine_has_cores_and_memory);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) /* which have their own heap   \
                                                                     */
    vt_add(suite, large_pieces_go_back_each_time);
#endif
    return vt_run(suite);
}
