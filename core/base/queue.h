/** A queue that hands out the point with the largest key; of equal keys the smallest point. */
#ifndef VOR_BASE_QUEUE_H
#define VOR_BASE_QUEUE_H

#include <stddef.h>
#include <stdint.h>

/** One entry. */
struct vor_queue_entry {
    float key;
    uint32_t point;
};

/** True if a is handed out before b. */
static inline int vor_queue_before(struct vor_queue_entry a, struct vor_queue_entry b)
{
    return a.key > b.key || (a.key >= b.key && a.point < b.point);
}

/** Adds an entry to a queue of n, with room for one more. O(log n), of late entries mostly O(1). */
static inline void vor_queue_push(struct vor_queue_entry *queue, size_t n,
                                  struct vor_queue_entry entry)
{
    while (n > 0 && vor_queue_before(entry, queue[(n - 1) / 4])) {
        queue[n] = queue[(n - 1) / 4];
        n = (n - 1) / 4;
    }
    queue[n] = entry;
}

/** Gives the first entry of a queue of n >= 1 a smaller key. O(log n). */
static inline void vor_queue_lower(struct vor_queue_entry *queue, size_t n, float key)
{
    struct vor_queue_entry entry = {key, queue[0].point};
    size_t at = 0;

    for (;;) {
        size_t first = 4 * at + 1, best = first;

        if (first >= n)
            break;
        for (size_t i = first + 1; i < n && i < first + 4; i++)
            if (vor_queue_before(queue[i], queue[best]))
                best = i;
        if (!vor_queue_before(queue[best], entry))
            break;
        queue[at] = queue[best];
        at = best;
    }
    queue[at] = entry;
}

#endif
