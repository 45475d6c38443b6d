#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* sched_getaffinity */
#endif
#include "server/base/machine.h"

#include "core/base/parallel.h"

#include <malloc.h>
#include <sched.h>
#include <stdio.h>
#include <unistd.h>

unsigned vor_machine_cores(void)
{
    cpu_set_t set;

    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return 1;
    return CPU_COUNT(&set) > VOR_THREADS_MAX ? VOR_THREADS_MAX : (unsigned)CPU_COUNT(&set);
}

static size_t read_limit(const char *path)
{
    FILE *file = fopen(path, "re");
    unsigned long long value = 0;

    if (file == NULL)
        return 0;
    if (fscanf(file, "%llu", &value) != 1)
        value = 0;
    (void)fclose(file);
    return (size_t)value;
}

size_t vor_machine_memory(void)
{
    static const char *const limits[] = {"/sys/fs/cgroup/memory.max",
                                         "/sys/fs/cgroup/memory/memory.limit_in_bytes"};
    size_t memory = (size_t)sysconf(_SC_PHYS_PAGES) * (size_t)sysconf(_SC_PAGESIZE);

    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        size_t limit = read_limit(limits[i]);

        if (limit > 0 && limit < memory)
            memory = limit;
    }
    return memory;
}

void vor_machine_set_oom_score(int score)
{
    FILE *file = fopen("/proc/self/oom_score_adj", "we");

    if (file == NULL)
        return;
    (void)fprintf(file, "%d", score);
    (void)fclose(file); /* which may fail: not everybody may */
}

/* Bytes. What a daemon holds more after lists of 1,000 jobs (1 MB each), 120 of them by four
 * clients: 0.8 / 0.9 / 1.0 MB at half, this and double, 1.8 at four times as much, 5.5 as the C
 * library is by itself. */
enum { LARGE_PIECE = 256 << 10 };

void vor_machine_give_back(void)
{
    (void)mallopt(M_MMAP_THRESHOLD, LARGE_PIECE);
    (void)mallopt(M_TRIM_THRESHOLD, LARGE_PIECE);
}
