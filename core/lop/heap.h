/** A queue that hands out the point with the largest key; of equal keys the smallest point. */
#ifndef VOR_LOP_HEAP_H
#define VOR_LOP_HEAP_H

#include <stddef.h>
#include <stdint.h>

/** One entry. */
struct vor_lop_heap_entry {
    float key;
    uint32_t point;
};

/** True if a is handed out before b. */
static inline int vor_lop_heap_before(struct vor_lop_heap_entry a, struct vor_lop_heap_entry b)
{
    return a.key > b.key || (a.key >= b.key && a.point < b.point);
}

/** Adds an entry to a heap of n, with room for one more. O(log n), of late entries mostly O(1). */
static inline void vor_lop_heap_push(struct vor_lop_heap_entry *heap, size_t n,
                                     struct vor_lop_heap_entry entry)
{
    while (n > 0 && vor_lop_heap_before(entry, heap[(n - 1) / 4])) {
        heap[n] = heap[(n - 1) / 4];
        n = (n - 1) / 4;
    }
    heap[n] = entry;
}

/** Gives the first entry of a heap of n >= 1 a smaller key. O(log n). */
static inline void vor_lop_heap_lower(struct vor_lop_heap_entry *heap, size_t n, float key)
{
    struct vor_lop_heap_entry entry = {key, heap[0].point};
    size_t at = 0;

    for (;;) {
        size_t first = 4 * at + 1, best = first;

        if (first >= n)
            break;
        for (size_t i = first + 1; i < n && i < first + 4; i++)
            if (vor_lop_heap_before(heap[i], heap[best]))
                best = i;
        if (!vor_lop_heap_before(heap[best], entry))
            break;
        heap[at] = heap[best];
        at = best;
    }
    heap[at] = entry;
}

#endif
