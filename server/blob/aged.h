/** Files with their sizes and ages, of which the oldest are to go. */
#ifndef VOR_SERVER_BLOB_AGED_H
#define VOR_SERVER_BLOB_AGED_H

#include <stddef.h>
#include <stdint.h>

/** A list begins with all zero. */
struct vor_aged {
    struct vor_aged_file {
        char name[256]; /**< a file's on Linux, with the NUL; or a key */
        uint64_t size;
        int64_t since_ms; /**< since 1970 */
    } * item;
    size_t count, capacity;
    int is_short; /**< of memory: some are missing */
};

void vor_aged_add(struct vor_aged *list, const char *name, uint64_t size, int64_t since_ms);

/** Puts the newest first. */
void vor_aged_sort(struct vor_aged *list);

void vor_aged_free(struct vor_aged *list);

#endif
