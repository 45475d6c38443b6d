#include "core/geom/layers.h"

#include "core/base/linalg.h"
#include "core/base/vector.h"

#include <string.h>

/* Figures are of two inputs of 16,000 points of white noise, to 1,000: "shell" is igea and igea
 * scaled by 0.985 about its middle, rms distance to the true surfaces over the diagonal (spread 2
 * %); "squares" are two unit squares 0.012 apart, points off both. Where sheets are not found at
 * all, shell is 12.4e-4. Inputs of one sheet are protected by LEAST of input/sheets.c: CLEAR
 * of 1.5, SAME of 0.9 and OVER of 3 change nothing on fandisk, autzen and igea with noise. */

enum {
    TERMS = 5, /* of the shared quadric: u, v, uu, uv, vv */
    /* Points that each layer has at least: two of as many have one point more than the quadric and
     * two heights have coefficients. */
    LEAST_IN_LAYER = (TERMS + 2) / 2 + 1
};

/* Times the rms distance of points from their own layer: a gap between layers is at least that
 * wide. At 1.5 / 3 / 6: shell 6.4e-4 / 7.4e-4 / 12.4e-4. */
#define CLEAR VOR_SURE
/* Of the widest gap: another one that wide separates layers too. At 0.25 / 0.5 / 0.9: shell 12.4e-4
 * / 7.4e-4 / 7.1e-4; with 0.9 the gaps of three sheets would have to agree within a tenth. */
#define SAME 0.5
/* Times what white noise has: how far points may be from other layers if these lie over them.
 * At 1.2 / 1.55 / 3: shell 12.4e-4 / 7.4e-4 / 7.3e-4, points off both squares 6 / 0 / 0. It is more
 * than 1 by what few points scatter. */
#define OVER 1.55

/* Numbers of one point that are added at once. Each sum is of the same terms in the same order as
 * one by one. */
enum { LANES = 4 };
typedef double lanes __attribute__((vector_size(8 * LANES)));

/* Numbers that are compared at once. */
enum { KEY_LANES = 16 };
typedef int32_t keys __attribute__((vector_size(4 * KEY_LANES)));

/* The points of a neighbourhood, in the frame of the layers. */
struct stack {
    lanes low[VOR_NEIGHBORS_MAX], high[VOR_NEIGHBORS_MAX]; /* u, v, uu, uv; vv, w, 1, 0 */
    double x[TERMS][VOR_NEIGHBORS_MAX]; /* u, v, uu, uv, vv; lengths over the reach */
    double w[VOR_NEIGHBORS_MAX];
    double square[TERMS * TERMS], xw[TERMS]; /* sums of x x^T, below the diagonal, and of x w */
    double height[VOR_NEIGHBORS_MAX];        /* of each point over the shared quadric */
    double sorted[VOR_NEIGHBORS_MAX];        /* the heights, ascending */
    unsigned k;
};

static void terms(double x[TERMS], double u, double v)
{
    x[0] = u;
    x[1] = v;
    x[2] = u * u;
    x[3] = u * v;
    x[4] = v * v;
}

/* Fills the stack. The first heights are over the surface's quadric, or, where that was fitted to
 * few points, over its tangent plane (`plane`). */
static void gather(struct stack *out, const struct vor_surface *surface, const float *near,
                   unsigned k, int plane)
{
    double scale = 1 / surface->reach;
    lanes low[TERMS] = {{0}}, high = {0}; /* sums of u, v, uu, uv by each; of vv, w, 1 by vv */
    lanes by_w = {0};

    out->k = k;
    memset(out->sorted, 0, k * sizeof *out->sorted); /* gcc-analyzer cannot see that sort sets it */
    for (unsigned i = 0; i < k; i++) {
        double x[3] = {(double)near[3 * i], (double)near[3 * i + 1], (double)near[3 * i + 2]};
        double local[3], at[TERMS];

        vor_surface_to_local(surface, x, local);
        out->w[i] = scale * local[2];
        out->height[i] = out->w[i];
        if (!plane)
            out->height[i] -= scale * vor_surface_height(surface, local[0], local[1], NULL);
        terms(at, scale * (local[0] - surface->center[0]), scale * (local[1] - surface->center[1]));
        for (int t = 0; t < TERMS; t++)
            out->x[t][i] = at[t];
        out->low[i] = (lanes){at[0], at[1], at[2], at[3]};
        out->high[i] = (lanes){at[4], out->w[i], 1, 0};
        for (int t = 0; t < TERMS; t++)
            low[t] += at[t] * out->low[i];
        by_w += out->w[i] * out->low[i];
        high += at[4] * out->high[i];
    }
    for (int t = 0; t < LANES; t++) {
        for (int s = 0; s < LANES; s++)
            out->square[TERMS * t + s] = low[t][s];
        out->square[TERMS * LANES + t] = low[LANES][t];
        out->xw[t] = by_w[t];
    }
    out->square[TERMS * LANES + LANES] = high[0];
    out->xw[LANES] = high[1];
}

/* Sorts the heights: each goes to as many places from the start as there are lower ones, by their
 * first bits and their numbers; then those that are still out of order move. Quicker for so few, in
 * lanes and without branches, than what moves them all. */
VOR_CLONES static void sort(struct stack *stack)
{
    _Static_assert((VOR_NEIGHBORS_MAX & (VOR_NEIGHBORS_MAX - 1)) == 0, "bits of a point's number");
    int32_t key[VOR_NEIGHBORS_MAX], lower[VOR_NEIGHBORS_MAX];
    double *sorted = stack->sorted;
    int32_t k = (int32_t)stack->k, whole = (k + KEY_LANES - 1) / KEY_LANES * KEY_LANES;

    for (int32_t i = k; i < whole; i++)
        key[i] = 0;
    for (int32_t i = 0; i < k; i++) {
        union {
            float height;
            int32_t bits;
        } to = {(float)stack->height[i]};

        key[i] = ((to.bits < 0 ? to.bits ^ INT32_MAX : to.bits) & -VOR_NEIGHBORS_MAX) | i;
        lower[i] = 0;
    }
    for (int32_t from = 0; from < whole; from += KEY_LANES) {
        keys own, count = {0};

        memcpy(&own, &key[from], sizeof own);
        for (int32_t j = 0; j < k; j++)
            count -= key[j] < own;
        memcpy(&lower[from], &count, sizeof count);
    }
    for (int32_t i = 0; i < k; i++)
        sorted[lower[i]] = stack->height[i];
    for (int32_t i = 1; i < k; i++) {
        double height = sorted[i];
        int32_t at = i;

        for (; at > 0 && height < sorted[at - 1]; at--)
            sorted[at] = sorted[at - 1];
        sorted[at] = height;
    }
}

/* The height that splits the sorted heights in two with the least variance within the parts (Otsu
 * 1979, "A threshold selection method from gray-level histograms"). */
VOR_CLONES static double best_split(const struct stack *stack)
{
    const double *h = stack->sorted;
    double low[VOR_NEIGHBORS_MAX], between[VOR_NEIGHBORS_MAX], total = 0, best = -1;
    unsigned at = 0, last = stack->k - 1;

    for (unsigned i = 0; i <= last; i++)
        low[i] = total += h[i];
    for (unsigned i = 0; i < last; i++) {
        double n = i + 1, m = last - i, apart = low[i] / n - (total - low[i]) / m;

        between[i] = n * m * apart * apart;
    }
    for (unsigned i = 0; i < last; i++)
        if (between[i] > best)
            best = between[at = i];
    return best > -1 ? (h[at] + h[at + 1]) / 2 : h[0];
}

/* Labels the points by one split. Returns whether any label changed. */
static int split(struct vor_layers *layers, const struct stack *stack)
{
    double at = best_split(stack);
    int changed = layers->count != 2;

    layers->count = 2;
    for (unsigned i = 0; i < stack->k; i++) {
        unsigned char of = stack->height[i] > at;

        changed |= of != layers->of[i];
        layers->of[i] = of;
    }
    return changed;
}

/* Labels the points by every gap that is at least SAME times as wide as the widest. */
static void split_all(struct vor_layers *layers, struct stack *stack)
{
    double widest = 0, cut[VOR_LAYERS_MAX] = {0};
    const double *h = stack->sorted;
    unsigned cuts = 0;

    for (unsigned i = 0; i + 1 < stack->k; i++)
        widest = h[i + 1] - h[i] > widest ? h[i + 1] - h[i] : widest;
    for (unsigned i = 0; i + 1 < stack->k; i++) {
        if (h[i + 1] - h[i] < SAME * widest)
            continue;
        if (cuts == VOR_LAYERS_MAX - 1) {
            layers->count = 1;
            return;
        }
        cut[cuts++] = (h[i] + h[i + 1]) / 2;
    }
    layers->count = cuts + 1;
    for (unsigned i = 0; i < stack->k; i++) {
        layers->of[i] = 0;
        for (unsigned l = 0; l < cuts; l++)
            layers->of[i] = (unsigned char)(layers->of[i] + (stack->height[i] > cut[l]));
    }
}

/* Sums of the points of each layer, two at a time: each chain of sums waits for itself. */
VOR_CLONES static void sum_layers(lanes low[VOR_LAYERS_MAX], lanes high[VOR_LAYERS_MAX],
                                  const struct vor_layers *layers, const struct stack *stack)
{
    for (unsigned l = 0; l < layers->count; l += 2) {
        lanes sum[4] = {{0}};

        for (unsigned i = 0; i < stack->k; i++) {
            double one = layers->of[i] == l, other = layers->of[i] == l + 1;

            sum[0] += one * stack->low[i];
            sum[1] += one * stack->high[i];
            sum[2] += other * stack->low[i];
            sum[3] += other * stack->high[i];
        }
        low[l] = sum[0];
        high[l] = sum[1];
        low[l + 1] = sum[2];
        high[l + 1] = sum[3];
    }
}

/* The points' heights over the quadric. */
VOR_CLONES static void set_heights(struct stack *stack, const double shape[TERMS])
{
    for (unsigned i = 0; i < stack->k; i++) {
        double height = stack->w[i];

        for (int t = 0; t < TERMS; t++)
            height -= shape[t] * stack->x[t][i];
        stack->height[i] = height;
    }
}

/* Fits the quadric that the layers share, and computes their heights and the points' heights over
 * it. Returns false when the points do not determine it. */
static int share(struct vor_layers *layers, struct stack *stack)
{
    double a[TERMS * TERMS], x[VOR_LAYERS_MAX][TERMS], w[VOR_LAYERS_MAX];
    lanes low[VOR_LAYERS_MAX] = {{0}}, high[VOR_LAYERS_MAX] = {{0}};

    sum_layers(low, high, layers, stack);
    memcpy(a, stack->square, sizeof a);
    memcpy(layers->shape, stack->xw, sizeof layers->shape);
    for (unsigned l = 0; l < layers->count; l++) {
        double n = high[l][2];

        for (int t = 0; t < LANES; t++)
            x[l][t] = low[l][t];
        x[l][LANES] = high[l][0];
        w[l] = high[l][1] / n;
        for (int t = 0; t < TERMS; t++) {
            for (int s = 0; s < t; s++)
                a[TERMS * t + s] -= x[l][t] * x[l][s];
            a[TERMS * t + t] -= x[l][t] * x[l][t] / n;
            layers->shape[t] -= x[l][t] * w[l];
            x[l][t] /= n;
        }
    }
    if (!(vor_solve_spd(a, layers->shape, TERMS, VOR_ROUNDED) > 0))
        return 0;
    set_heights(stack, layers->shape);
    for (unsigned l = 0; l < layers->count; l++) {
        layers->height[l] = w[l];
        for (int t = 0; t < TERMS; t++)
            layers->height[l] -= layers->shape[t] * x[l][t];
    }
    return 1;
}

/* Whether the gaps between layers are wide compared with the points' distances from their own layer
 * and with the spacing. */
static int clear_between(const struct vor_layers *layers, const struct stack *stack, double spacing)
{
    double low[VOR_LAYERS_MAX], high[VOR_LAYERS_MAX], sum = 0;
    double lowest = 2 * sqrt(VOR_LAYERS_POSSIBLE2) * spacing; /* half off what lies between */
    unsigned count[VOR_LAYERS_MAX] = {0};

    for (unsigned l = 0; l < layers->count; l++)
        low[l] = high[l] = layers->height[l];
    for (unsigned i = 0; i < stack->k; i++) {
        unsigned l = layers->of[i];
        double off = stack->height[i] - layers->height[l];

        count[l]++;
        sum += off * off;
        low[l] = stack->height[i] < low[l] ? stack->height[i] : low[l];
        high[l] = stack->height[i] > high[l] ? stack->height[i] : high[l];
    }
    sum = sqrt(sum / (stack->k - TERMS - layers->count));
    for (unsigned l = 0; l < layers->count; l++)
        if (count[l] < LEAST_IN_LAYER)
            return 0;
    for (unsigned l = 1; l < layers->count; l++)
        if (low[l] - high[l - 1] < CLEAR * sum ||
            layers->height[l] - layers->height[l - 1] < lowest)
            return 0;
    return 1;
}

/* Squared distance along the surface from point i to the nearest point of another layer. */
static double other2(const struct vor_layers *layers, const struct stack *stack, unsigned i)
{
    double least = INFINITY;

    for (unsigned j = 0; j < stack->k; j++) {
        double u = stack->x[0][j] - stack->x[0][i], v = stack->x[1][j] - stack->x[1][i];

        if (layers->of[j] != layers->of[i] && u * u + v * v < least)
            least = u * u + v * v;
    }
    return least;
}

/* Whether each layer, except the one with the most points, lies over the others. In white noise the
 * nearest point is half a spacing away on average (Clark and Evans 1954): so far is a point from
 * the others' if they lie over it. */
static int one_over_another(const struct vor_layers *layers, const struct stack *stack,
                            double spacing)
{
    double sum[VOR_LAYERS_MAX] = {0}, n[VOR_LAYERS_MAX] = {0}, most = 0;

    for (unsigned i = 0; i < stack->k; i++)
        most = fmax(most, ++n[layers->of[i]]);
    for (unsigned i = 0; i < stack->k; i++)
        if (n[layers->of[i]] < most)
            sum[layers->of[i]] += sqrt(other2(layers, stack, i));
    for (unsigned l = 0; l < layers->count; l++) {
        double expected = 0.5 * spacing * sqrt(stack->k / (stack->k - n[l]));

        if (n[l] < most && sum[l] > OVER * expected * n[l])
            return 0;
    }
    return 1;
}

/* Splits the heights and fits the shape in turn until nothing changes. Returns whether the parts
 * are layers. */
static int settle(struct vor_layers *out, struct stack *stack, double spacing)
{
    sort(stack);
    for (unsigned round = 0; round < stack->k && split(out, stack); round++) {
        if (!share(out, stack))
            return 0;
        sort(stack);
    }
    split_all(out, stack);
    return out->count > 1 && share(out, stack) && clear_between(out, stack, spacing) &&
           one_over_another(out, stack, spacing);
}

/* Looks for layers over the tangent plane of the `few` nearest points; `all` is the surface of all
 * of them. */
static int find_in(struct vor_layers *out, const float *near, unsigned k, unsigned few,
                   const struct vor_surface *all)
{
    struct stack stack;

    out->count = 1;
    out->frame = *all;
    if (few < k)
        vor_surface_fit(&out->frame, near, few);
    if (out->frame.kind == VOR_SURFACE_NONE)
        return 0;
    gather(&stack, &out->frame, near, k, few < k);
    return settle(out, &stack, all->spacing / out->frame.reach);
}

static void none(struct vor_layers *out)
{
    out->count = 1;
    memset(out->of, 0, sizeof out->of);
}

void vor_layers_find(struct vor_layers *out, const float *near, unsigned k)
{
    /* Points that the tangent plane is fitted to. With the first alone shell is 12.4e-4, with three
     * 7.4e-4. */
    static const unsigned first[] = {VOR_NEIGHBORS_MAX, 8, 14, 26, 5};
    struct vor_surface all;

    if (k >= 2 * LEAST_IN_LAYER) {
        vor_surface_fit(&all, near, k);
        for (size_t i = 0; i < sizeof first / sizeof *first; i++)
            if ((i == 0 || first[i] < k) && find_in(out, near, k, first[i], &all))
                return;
    }
    none(out);
}

int vor_layers_find_like(struct vor_layers *out, const struct vor_layers *like, const float *near,
                         unsigned k)
{
    struct vor_surface all;
    struct stack stack;

    if (k < 2 * LEAST_IN_LAYER)
        return 0;
    vor_surface_fit(&all, near, k);
    out->count = 1;
    out->frame = like->frame;
    gather(&stack, &out->frame, near, k, 1);
    for (unsigned i = 0; i < k; i++)
        for (int t = 0; t < TERMS; t++)
            stack.height[i] -= like->shape[t] * stack.x[t][i];
    if (settle(out, &stack, all.spacing / out->frame.reach))
        return 1;
    none(out);
    return 0;
}

unsigned vor_layers_nearest(const struct vor_layers *layers, const double x[3])
{
    double local[3], at[TERMS], height, scale = 1 / layers->frame.reach;
    unsigned best = 0;

    if (layers->count == 1)
        return 0;
    vor_surface_to_local(&layers->frame, x, local);
    terms(at, scale * (local[0] - layers->frame.center[0]),
          scale * (local[1] - layers->frame.center[1]));
    height = scale * local[2];
    for (int t = 0; t < TERMS; t++)
        height -= layers->shape[t] * at[t];
    for (unsigned l = 1; l < layers->count; l++)
        if (fabs(height - layers->height[l]) < fabs(height - layers->height[best]))
            best = l;
    return best;
}
