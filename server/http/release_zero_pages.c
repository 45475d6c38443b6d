#include "server/http/release_zero_pages.h"

#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

void vor_release_zero_pages(void *start, size_t bytes)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    uint8_t *memory = start;
    size_t from = 0;

    if (((uintptr_t)start & (page - 1)) != 0)
        return;
    for (size_t at = 0; at + page <= bytes; at += page) {
        if (memory[at] == 0 && memcmp(memory + at, memory + at + 1, page - 1) == 0)
            continue;
        if (at > from)
            (void)madvise(memory + from, at - from, MADV_DONTNEED);
        from = at + page;
    }
    if (from + page <= bytes)
        (void)madvise(memory + from, (bytes - from) / page * page, MADV_DONTNEED);
}
