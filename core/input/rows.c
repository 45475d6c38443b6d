#include "core/input/rows.h"

#include "core/base/linalg.h"
#include "core/knn/knn.h"

#include <stdlib.h>
#include <string.h>

/* Ends near to one that are looked at: enough to pass over those of its own corner and of rows that
 * are joined already. */
enum { NEAR = 16 };

/* Radii between the centres of two discs: of the same disc, and of two that may be joined. Loops of
 * half of armadillo's cut, of four, and open rows of autzen: NEARLY 1 / 1.5 / 3: 2, 204 / 3, 189 /
 * 4, 96. */
#define SAME 0.5
#define NEARLY 3.0

struct rows {
    const struct vor_corner *corner;
    size_t n;
    double radius;
    size_t *mate;
};

static const float *middle_of(const struct rows *rows, size_t end)
{
    return rows->corner[end / 2].middle[end % 2];
}

/* Squared distance between the centres of two ends' discs, over that which is allowed. */
static double apart2(const struct rows *rows, size_t a, size_t b, double allowed)
{
    double radius = allowed * rows->radius *
                    (double)fminf(rows->corner[a / 2].spacing, rows->corner[b / 2].spacing);

    return vor_distance2f(middle_of(rows, a), middle_of(rows, b)) / (radius * radius);
}

/* The first corner of a point, or of the next one that has any. */
static size_t first_of(const struct rows *rows, uint32_t point)
{
    size_t low = 0, high = rows->n;

    while (low < high) {
        size_t middle = low + (high - low) / 2;

        if (rows->corner[middle].point < point)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The end whose disc stops at the corner of this one, and is nearest to its disc. */
static size_t best_of(const struct rows *rows, size_t end)
{
    uint32_t from = rows->corner[end / 2].point, to = rows->corner[end / 2].end[end % 2];
    size_t best = VOR_ROWS_NO_END;
    double least = 1;

    for (size_t c = first_of(rows, to); c < rows->n && rows->corner[c].point == to; c++) {
        for (size_t e = 0; e < 2; e++) {
            double apart = apart2(rows, end, 2 * c + e, SAME);

            if (rows->corner[c].end[e] == from && apart < least) {
                least = apart;
                best = 2 * c + e;
            }
        }
    }
    return best;
}

/* Joins the ends that stop each other's discs. Returns how many are left over. */
static size_t join_same(struct rows *rows)
{
    size_t left = 0;

    for (size_t end = 0; end < 2 * rows->n; end++)
        rows->mate[end] = best_of(rows, end);
    for (size_t end = 0; end < 2 * rows->n; end++) {
        size_t other = rows->mate[end];

        /* The mate of an earlier end is set: it is that end, or none. */
        if (other != VOR_ROWS_NO_END && rows->mate[other] != end)
            rows->mate[end] = VOR_ROWS_NO_END;
        left += rows->mate[end] == VOR_ROWS_NO_END;
    }
    return left;
}

/* Two ends that may be joined. */
struct pair {
    double apart;
    size_t a, b;
};

static int nearer(const void *left, const void *right)
{
    const struct pair *a = left, *b = right;

    if (a->apart != b->apart)
        return a->apart < b->apart ? -1 : 1;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return (a->b > b->b) - (a->b < b->b);
}

/* The ends left over. */
struct left {
    size_t n;
    size_t *end;
    float *middle;
    struct vor_knn *knn;
    struct pair *pair;
};

static vor_status gather(struct left *left, const struct rows *rows, struct vor_memory *memory,
                         struct vor_error *err)
{
    size_t count = 0;

    left->end = vor_malloc(memory, left->n, sizeof *left->end);
    left->middle = vor_malloc(memory, left->n, 3 * sizeof *left->middle);
    left->pair = vor_malloc(memory, left->n, NEAR * sizeof *left->pair);
    if (left->end == NULL || left->middle == NULL || left->pair == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", left->n);
    for (size_t end = 0; end < 2 * rows->n; end++) {
        if (rows->mate[end] != VOR_ROWS_NO_END)
            continue;
        left->end[count] = end;
        memcpy(&left->middle[3 * count++], middle_of(rows, end), 3 * sizeof *left->middle);
    }
    return vor_knn_build(&left->knn, left->middle, left->n, memory, err);
}

/* Sets the pairs of ends near to each other, the nearest first. Returns how many there are. */
static size_t set_pairs(struct left *left, const struct rows *rows)
{
    unsigned k = left->n < NEAR ? (unsigned)left->n : NEAR;
    size_t count = 0;

    for (size_t i = 0; i < left->n; i++) {
        uint32_t index[NEAR];
        float distance2[NEAR];

        vor_knn_search(left->knn, &left->middle[3 * i], 1, k, index, distance2);
        for (unsigned j = 0; j < k; j++) {
            struct pair pair = {.a = left->end[i], .b = left->end[index[j]]};

            pair.apart = apart2(rows, pair.a, pair.b, NEARLY);
            if (pair.a / 2 != pair.b / 2 && pair.apart < 1)
                left->pair[count++] = pair;
        }
    }
    qsort(left->pair, count, sizeof *left->pair, nearer);
    return count;
}

static vor_status join_nearly(struct rows *rows, size_t n, struct vor_memory *memory,
                              struct vor_error *err)
{
    struct left left = {.n = n};
    vor_status status = gather(&left, rows, memory, err);
    size_t count = status == VOR_OK ? set_pairs(&left, rows) : 0;

    for (size_t i = 0; i < count; i++) {
        size_t a = left.pair[i].a, b = left.pair[i].b;

        if (rows->mate[a] == VOR_ROWS_NO_END && rows->mate[b] == VOR_ROWS_NO_END) {
            rows->mate[a] = b;
            rows->mate[b] = a;
        }
    }
    vor_knn_free(left.knn);
    VOR_FREE_ALL(memory, left.pair, left.middle, left.end);
    return status;
}

vor_status vor_rows_join(size_t *mate, const struct vor_corner *corner, size_t n, double radius,
                         struct vor_memory *memory, struct vor_error *err)
{
    struct rows rows = {corner, n, radius, mate};
    size_t left = join_same(&rows);

    return left > 1 ? join_nearly(&rows, left, memory, err) : VOR_OK;
}
