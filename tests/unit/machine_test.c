/* What a process of ours takes of the machine. */
#include "server/base/machine.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

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

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) /* which have their own heap   \
                                                                     */
VT_TEST(large_pieces_go_back_each_time)
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
#endif

VT_TEST(a_machine_has_cores_and_memory)
{
    ck_assert_uint_ge(vor_machine_cores(), 1);
    ck_assert_uint_ge(vor_machine_memory(), (size_t)64 << 20);
}

/* Writes a file of that text below dir, and the folders that it lies in. */
static void put_file(const char *dir, const char *name, const char *text)
{
    char path[256], command[300];
    FILE *file;

    (void)snprintf(path, sizeof path, "%s/%s", dir, name);
    (void)snprintf(command, sizeof command, "mkdir -p $(dirname '%s')", path);
    ck_assert_int_eq(system(command), 0);
    file = fopen(path, "we");
    ck_assert_ptr_nonnull(file);
    ck_assert_int_ge(fputs(text, file), 0);
    (void)fclose(file);
}

static size_t group_memory(const char *dir, const char *groups)
{
    char path[256];

    put_file(dir, "groups", groups);
    (void)snprintf(path, sizeof path, "%s/groups", dir);
    return vor_machine_group_memory(path, dir);
}

VT_TEST(the_least_limit_of_the_groups_around_holds)
{
    const char *dir = vt_dir_make();

    ck_assert_uint_eq(group_memory(dir, "0::/a.slice/b.service\n"), 0);
    put_file(dir, "a.slice/memory.max", "max\n");
    put_file(dir, "a.slice/b.service/memory.max", "3000\n");
    ck_assert_uint_eq(group_memory(dir, "1:name=systemd:/x\n0::/a.slice/b.service\n"), 3000);
    put_file(dir, "a.slice/memory.max", "2000\n");
    ck_assert_uint_eq(group_memory(dir, "0::/a.slice/b.service\n"), 2000);
    ck_assert_uint_eq(group_memory(dir, "0::/../elsewhere\n"), 0);
    put_file(dir, "memory/outer/inner/memory.limit_in_bytes", "500\n");
    ck_assert_uint_eq(group_memory(dir, "4:cpu,memory:/outer/inner\n0::/\n"), 500);
    ck_assert_uint_eq(group_memory(dir, "4:cpu:/outer/inner\n0::/\n"), 0);
}

VT_TEST(a_container_finds_its_limit_at_the_top)
{
    const char *dir = vt_dir_make();

    put_file(dir, "memory.max", "7000\n");
    ck_assert_uint_eq(group_memory(dir, "0::/docker/0123\n"), 7000);
    ck_assert_uint_eq(vor_machine_group_memory("/nonexistent", dir), 7000);
    put_file(dir, "memory/memory.limit_in_bytes", "6000\n");
    ck_assert_uint_eq(group_memory(dir, "5:memory:/docker/0123\n"), 6000);
}
