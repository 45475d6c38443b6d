/** A queue of indices by keys, the least key first; of equal keys the smaller index. */
#ifndef VOR_BASE_HEAP_H
#define VOR_BASE_HEAP_H

#include <stddef.h>
#include <stdint.h>

/** Places of indices that are not in the queue: not put in yet; taken out. */
#define VOR_HEAP_WAITS UINT32_MAX
#define VOR_HEAP_DONE (UINT32_MAX - 1)

/** Borrows its arrays, each as long as there are indices. */
struct vor_heap {
    const float *key;
    uint32_t *item;  /**< a binary heap, count long */
    uint32_t *place; /**< where each index is in item; the caller sets all to VOR_HEAP_WAITS */
    size_t count;
};

static inline int vor_heap_before(const struct vor_heap *heap, uint32_t a, uint32_t b)
{
    float first = heap->key[a], second = heap->key[b];

    return first < second || (first <= second && a < b);
}

static inline void vor_heap_put(struct vor_heap *heap, size_t at, uint32_t i)
{
    heap->item[at] = i;
    heap->place[i] = (uint32_t)at;
}

/** Puts index i at a place, or above or below, where its key belongs. */
static inline void vor_heap_sift(struct vor_heap *heap, size_t at, uint32_t i)
{
    size_t child;

    for (; at > 0 && vor_heap_before(heap, i, heap->item[(at - 1) / 2]); at = (at - 1) / 2)
        vor_heap_put(heap, at, heap->item[(at - 1) / 2]);
    while ((child = 2 * at + 1) < heap->count) {
        if (child + 1 < heap->count &&
            vor_heap_before(heap, heap->item[child + 1], heap->item[child]))
            child++;
        if (!vor_heap_before(heap, heap->item[child], i))
            break;
        vor_heap_put(heap, at, heap->item[child]);
        at = child;
    }
    vor_heap_put(heap, at, i);
}

/** Puts index i in, or moves it where its key, which changed, belongs; it was not taken. O(log n).
 */
static inline void vor_heap_move(struct vor_heap *heap, uint32_t i)
{
    vor_heap_sift(heap, heap->place[i] == VOR_HEAP_WAITS ? heap->count++ : heap->place[i], i);
}

/** Takes index i out, which is in; its place becomes VOR_HEAP_DONE. O(log n). */
static inline void vor_heap_remove(struct vor_heap *heap, uint32_t i)
{
    size_t at = heap->place[i];
    uint32_t last = heap->item[--heap->count];

    if (last != i)
        vor_heap_sift(heap, at, last);
    heap->place[i] = VOR_HEAP_DONE;
}

/** Takes the first index out, of at least one. O(log n). */
static inline uint32_t vor_heap_take(struct vor_heap *heap)
{
    uint32_t first = heap->item[0];

    vor_heap_remove(heap, first);
    return first;
}

#endif
