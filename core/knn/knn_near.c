/* The tree is walked once, for the box around all queries; of the points that this finds, each
 * query picks its own by comparing all distances at once, and sorts them by counting how many are
 * less. Both are a pass over lanes, where a search of the tree mispredicts branches. How far to
 * look is guessed from what the last queries found, or what the first one finds in the tree; one
 * that finds too few looks farther. Of 100,000 points on igea the 9, 20, 32 and 120 nearest take
 * .44, .73, .73 and 2.6 us each by a first query's guess, by the tree .62, 1.0, 1.4 and 4.9, and
 * where it is known how far they are .23, .31, .37 and 1.3. */
#include "core/knn/knn_near.h"

#include "core/base/linalg.h"
#include "core/knn/knn_boxes.h"
#include "core/knn/knn_tree.h"

#include <math.h>
#include <string.h>

enum {
    LANES = VOR_BOXES_LANES,
    WIDTH = 16,        /* of the longest vectors, in floats */
    ROOM = 1024,       /* points around the queries; where there are more, halves of these search.
                        * At 512 / 1,024: denoise of 655,000 points 45.5 / 42.5 CPU s */
    MORE = 8,          /* neighbours that the first query looks for to guess how far the others'
                        * are, and times whose distance that is. At 8, 1.1 / 16, 1 / 8, 1.2: 20
                        * neighbours .73 / .88 / .93 us, 120 of them 2.7 / 3.5 / 2.9 */
    NARROW = 6,        /* steps towards the distance of the k-th; on a surface one or two do */
    STACK = 96 * LANES /* as in knn_boxes.c */
};

#define GUESS 1.1F

float vor_knn_near_guess(float far2, unsigned had, unsigned k)
{
    return GUESS * GUESS * far2 * (float)(k + MORE) / (float)had;
}

/* What is found around the queries. */
struct around {
    unsigned count; /* ROOM + 1: too many */
    float xyz[3][ROOM + WIDTH];
    uint32_t index[ROOM + WIDTH];
};

/* The box around the queries. */
struct extent {
    float low[3], high[3];
};

/* Adds the points of a leaf that are within the squared distance of the box. */
VOR_INLINE void take_leaf(struct around *around, const struct vor_boxes *boxes, uint32_t begin,
                          uint32_t n, const struct extent *box, float most2)
{
    const float *xyz = vor_boxes_leaf(boxes, begin);
    float x[3][LANES], distance2[LANES]; /* what is beyond the leaf is not used */
    unsigned count = around->count;

    if (count + n > ROOM) {
        around->count = ROOM + 1;
        return;
    }
    for (size_t j = 0; j < LANES; j++)
        for (size_t c = 0; c < 3; c++)
            x[c][j] = xyz[3 * j + c];
    vor_boxes_distances(distance2, x[0], x[0], LANES, box->low, box->high);
    for (uint32_t j = 0; j < n; j++) {
        around->xyz[0][count] = x[0][j];
        around->xyz[1][count] = x[1][j];
        around->xyz[2][count] = x[2][j];
        around->index[count] = begin + j;
        count += distance2[j] < most2;
    }
    around->count = count;
}

/* Finds the points within the squared distance of the box, in the order of the tree. */
VOR_CLONES static void gather(struct around *around, const struct vor_boxes *boxes,
                              const struct extent *box, float most2)
{
    uint32_t at[STACK];
    unsigned char kind[STACK];
    unsigned high = 1;

    at[0] = 0;
    kind[0] = boxes->root;
    while (high > 0 && around->count <= ROOM) {
        struct vor_boxes_node node;
        float distance2[LANES];

        if (kind[--high] <= LANES) {
            take_leaf(around, boxes, at[high], kind[high], box, most2);
            continue;
        }
        node = vor_boxes_node_at(boxes, at[high], kind[high]);
        vor_boxes_distances(distance2, node.low, node.high, node.lanes, box->low, box->high);
        for (size_t j = node.lanes; j-- > 0;) {
            at[high] = node.child[j];
            kind[high] = node.kind[j];
            high += distance2[j] < most2;
        }
    }
}

VOR_INLINE unsigned count_within(const float *all2, unsigned n, float most2)
{
    unsigned count = 0;

    for (unsigned i = 0; i < n; i++)
        count += all2[i] < most2;
    return count;
}

/* Lessens a squared distance as long as k are within it and a quarter as many again: sorting takes
 * the square of their number, which on a surface is in proportion to that distance. */
VOR_INLINE float narrow(const float *all2, unsigned n, float most2, unsigned k)
{
    unsigned within = count_within(all2, n, most2), under = 0, aim = k + k / 8 + MORE / 2;
    float under2 = 0;

    for (int i = 0; i < NARROW && within > k + k / 4 + MORE; i++) {
        float share = (float)(aim - under) / (float)(within - under);
        float try2 = under2 + (most2 - under2) * share;
        unsigned count = count_within(all2, n, try2);

        if (count < k) {
            under2 = try2;
            under = count;
        } else {
            most2 = try2;
            within = count;
        }
    }
    return most2;
}

/* The first of the least of n squared distances that are less than most2; n if none is. */
VOR_INLINE unsigned first_of(const float *all2, unsigned n, float most2)
{
    vor_lanes least2 = most2 - (vor_lanes){0};
    float least = most2;
    unsigned first = 0;

    for (unsigned i = 0; i < n; i += LANES) {
        vor_lanes here2 = *(const vor_lanes_at *)&all2[i];
        vor_marks less = here2 < least2;

        least2 = (vor_lanes)(((vor_marks)here2 & less) | ((vor_marks)least2 & ~less));
    }
    for (unsigned j = 0; j < LANES; j++)
        least = least2[j] < least ? least2[j] : least;
    if (!(least < most2))
        return n;
    while (all2[first] > least)
        first++;
    return first;
}

/* Picks the k nearest of those around within a squared distance. Returns false if there are fewer.
 */
VOR_CLONES static int pick(const struct around *around, const float q[3], float most2, unsigned k,
                           uint32_t *index, float *distance2)
{
    float all2[ROOM + WIDTH], picked2[ROOM + WIDTH];
    uint32_t picked[ROOM + WIDTH], less[ROOM + WIDTH];
    unsigned count = 0, wide;

    for (size_t i = 0; i < around->count; i++) {
        float x = around->xyz[0][i] - q[0], y = around->xyz[1][i] - q[1],
              z = around->xyz[2][i] - q[2];

        all2[i] = x * x + y * y + z * z;
    }
    for (unsigned i = 0; i < WIDTH; i++)
        all2[around->count + i] = INFINITY;
    if (k == 1) {
        unsigned first = first_of(all2, around->count, most2);

        if (first == around->count)
            return 0;
        *index = around->index[first];
        *distance2 = all2[first];
        return 1;
    }
    most2 = narrow(all2, around->count, most2, k);
    for (unsigned i = 0; i < around->count; i += LANES) {
        vor_marks in = *(const vor_lanes_at *)&all2[i] < most2 - (vor_lanes){0};
        uint64_t any[sizeof in / sizeof(uint64_t)];

        memcpy(any, &in, sizeof any);
        if ((any[0] | any[1] | any[2] | any[3]) == 0)
            continue;
        for (unsigned j = i; j < i + LANES; j++) {
            picked2[count] = all2[j];
            picked[count] = around->index[j];
            count += all2[j] < most2;
        }
    }
    if (count < k)
        return 0;
    wide = (count + WIDTH - 1) / WIDTH * WIDTH;
    for (unsigned i = 0; i < WIDTH; i++)
        picked2[count + i] = INFINITY;
    for (unsigned i = 0; i < wide; i += WIDTH) {
        const vor_lanes_at *own2 = (const vor_lanes_at *)&picked2[i];
        const vor_marks lane = {0, 1, 2, 3, 4, 5, 6, 7};
        vor_marks first = {0}, second = {0}; /* a comparison that holds gives -1 */

        for (unsigned j = 0; j < i; j++) {
            first -= picked2[j] <= own2[0];
            second -= picked2[j] <= own2[1];
        }
        for (unsigned j = i; j < count; j++) {
            first -= picked2[j] < own2[0];
            second -= picked2[j] < own2[1];
        }
        for (int j = 0; j < WIDTH; j++) { /* of equally far ones the first ones first */
            first -= (picked2[i + (unsigned)j] == own2[0]) & (lane > j);
            second -= (picked2[i + (unsigned)j] == own2[1]) & (lane + LANES > j);
        }
        *(vor_marks_at *)&less[i] = first;
        *(vor_marks_at *)&less[i + LANES] = second;
    }
    for (unsigned i = 0; i < count; i++)
        if (less[i] < k) {
            index[less[i]] = picked[i];
            distance2[less[i]] = picked2[i];
        }
    return 1;
}

/* How far, squared, the k-th points of the queries may be, by what the first one finds. */
static float guess_by_first(const struct vor_boxes *boxes, const struct vor_knn_near *near)
{
    uint32_t index[ROOM];
    float distance2[ROOM];
    unsigned last = near->k + MORE <= boxes->n ? near->k + MORE - 1 : near->k - 1;

    last = last < ROOM ? last : ROOM - 1;
    vor_boxes_search(boxes, near->queries, last + 1, INFINITY, index, distance2);
    return GUESS * GUESS * distance2[last];
}

/* The k nearest of a query that has fewer within a squared distance: looks twice as far, squared,
 * again and again. */
static void widen(const struct vor_boxes *boxes, const float q[3], float most2, unsigned k,
                  uint32_t *index, float *distance2)
{
    const struct extent box = {{q[0], q[1], q[2]}, {q[0], q[1], q[2]}};
    struct around around;

    do {
        most2 *= 2;
        around.count = 0;
        gather(&around, boxes, &box, most2);
        if (around.count > ROOM) {
            vor_boxes_search(boxes, q, k, INFINITY, index, distance2);
            return;
        }
    } while (!pick(&around, q, most2, k, index, distance2));
}

void vor_boxes_search_near(const struct vor_boxes *boxes, struct vor_knn_near *near,
                           uint32_t *index, float *distance2)
{
    struct extent box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    float most2[VOR_KNN_NEAR_MAX], far = 0, widest2 = 0, sum2 = 0;
    struct around around;
    unsigned k = near->k;
    int wide = 0, guessed = near->within == NULL && near->guess > 0;

    around.count = 0;
    if (near->within == NULL)
        far = sqrtf(guessed ? near->guess : guess_by_first(boxes, near));
    for (size_t i = 0; i < near->count; i++) {
        const float *at = &near->queries[3 * i];
        float most = near->within != NULL ? near->within[i] : far;

        most2[i] = vor_boxes_wider(most);
        widest2 = most2[i] > widest2 ? most2[i] : widest2;
        for (size_t c = 0; c < 3; c++) {
            box.low[c] = at[c] < box.low[c] ? at[c] : box.low[c];
            box.high[c] = at[c] > box.high[c] ? at[c] : box.high[c];
        }
    }
    gather(&around, boxes, &box, widest2);
    for (int c = 0; c < 3; c++)
        wide |= box.low[c] < box.high[c];
    if (around.count > ROOM && (wide || guessed)) { /* else halves would find as many */
        size_t few = guessed ? near->count : near->count / 2;
        struct vor_knn_near part = {near->queries, few, k, near->within, 0};

        vor_boxes_search_near(boxes, &part, index, distance2);
        near->guess = part.guess;
        if (guessed)
            return;
        part = (struct vor_knn_near){&near->queries[3 * few], near->count - few, k,
                                     near->within != NULL ? &near->within[few] : NULL, 0};
        vor_boxes_search_near(boxes, &part, &index[few * k], &distance2[few * k]);
        return;
    }
    for (size_t i = 0; i < near->count; i++) {
        const float *q = &near->queries[3 * i];

        if (around.count > ROOM)
            vor_boxes_search(boxes, q, k, sqrtf(most2[i]), &index[i * k], &distance2[i * k]);
        else if (!pick(&around, q, most2[i], k, &index[i * k], &distance2[i * k]))
            widen(boxes, q, most2[i], k, &index[i * k], &distance2[i * k]);
        sum2 += distance2[(i + 1) * k - 1];
    }
    near->guess = vor_knn_near_guess(sum2 / (float)near->count, k, k);
}
