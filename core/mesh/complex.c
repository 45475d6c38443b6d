#include "core/mesh/complex.h"

#include <string.h>

vor_status vor_complex_init(struct vor_complex *out, size_t n, struct vor_memory *memory,
                            struct vor_error *err)
{
    struct vor_complex complex = {.memory = memory, .n = n, .room = 2 * n};

    if (VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(complex.triangle, complex.room, 3),
                     VOR_ARRAY(complex.around, n, VOR_AROUND_MOST),
                     VOR_ZEROED(complex.degree, n, 1)) != VOR_OK) {
        vor_complex_free(&complex);
        return VOR_E_NOMEM;
    }
    *out = complex;
    return VOR_OK;
}

void vor_complex_free(struct vor_complex *complex)
{
    VOR_FREE_ALL(complex->memory, complex->degree, complex->around, complex->triangle);
    memset(complex, 0, sizeof *complex);
}

vor_status vor_complex_add(struct vor_complex *complex, const uint32_t corner[3],
                           struct vor_error *err)
{
    if (complex->count == complex->room) {
        size_t room = complex->room + complex->room / 2 + 16;
        uint32_t *grown =
            vor_realloc(complex->memory, complex->triangle, room, 3 * sizeof *complex->triangle);

        if (grown == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu triangles", room);
        complex->triangle = grown;
        complex->room = room;
    }
    memcpy(&complex->triangle[3 * complex->count], corner, 3 * sizeof *corner);
    for (int c = 0; c < 3; c++)
        complex->around[(size_t)corner[c] * VOR_AROUND_MOST + complex->degree[corner[c]]++] =
            (uint32_t)complex->count;
    complex->count++;
    return VOR_OK;
}

/* Takes triangle t from those at point i. */
static void leave(struct vor_complex *complex, uint32_t i, uint32_t t)
{
    uint32_t *around = &complex->around[(size_t)i * VOR_AROUND_MOST];
    unsigned last = --complex->degree[i];

    for (unsigned a = 0; a < last; a++)
        if (around[a] == t)
            around[a] = around[last];
}

void vor_complex_remove(struct vor_complex *complex, uint32_t t)
{
    uint32_t *corner = &complex->triangle[3 * (size_t)t];

    for (int c = 0; c < 3; c++)
        leave(complex, corner[c], t);
    corner[0] = VOR_COMPLEX_GONE;
}

/* The triangle of three points, which there is. */
static uint32_t triangle_of(const struct vor_complex *complex, uint32_t a, uint32_t b,
                            uint32_t third)
{
    const uint32_t *around = &complex->around[(size_t)a * VOR_AROUND_MOST];
    uint32_t other[2], t = around[0];

    for (unsigned at = 0; at < complex->degree[a]; at++) {
        vor_complex_others(complex, around[at], a, other);
        if ((other[0] == b && other[1] == third) || (other[0] == third && other[1] == b))
            t = around[at];
    }
    return t;
}

/* Gives the triangle of a, b and third the corner `to` in the place of a. */
static void replace(struct vor_complex *complex, uint32_t a, uint32_t b, uint32_t third,
                    uint32_t to)
{
    uint32_t t = triangle_of(complex, a, b, third);

    for (int c = 0; c < 3; c++)
        if (complex->triangle[3 * (size_t)t + (size_t)c] == a)
            complex->triangle[3 * (size_t)t + (size_t)c] = to;
    leave(complex, a, t);
    complex->around[(size_t)to * VOR_AROUND_MOST + complex->degree[to]++] = t;
}

void vor_complex_flip(struct vor_complex *complex, uint32_t a, uint32_t b, const uint32_t third[2])
{
    replace(complex, b, a, third[0], third[1]);
    replace(complex, a, b, third[1], third[0]);
}

int vor_complex_collapses(const struct vor_complex *complex, uint32_t a, uint32_t b)
{
    uint32_t third[2], other[2], none[2];
    unsigned have = vor_complex_edge(complex, a, b, third), common = 0;

    if (have == 0 ||
        (have == 2 && !vor_complex_surrounds(complex, a) && !vor_complex_surrounds(complex, b)))
        return 0;
    for (unsigned t = 0; t < complex->degree[b]; t++) {
        vor_complex_others(complex, complex->around[(size_t)b * VOR_AROUND_MOST + t], b, other);
        for (int e = 0; e < 2; e++)
            common += other[e] != a && vor_complex_edge(complex, a, other[e], none) > 0;
    }
    for (unsigned k = 0; k < have; k++) {
        common -= vor_complex_edge(complex, b, third[k], none);
        if (complex->degree[third[k]] < (vor_complex_surrounds(complex, third[k]) ? 4 : 2))
            return 0;
    }
    return common == 0 && complex->degree[a] + complex->degree[b] <= VOR_AROUND_MOST;
}

unsigned vor_complex_collapse(struct vor_complex *complex, uint32_t a, uint32_t b)
{
    uint32_t *around = &complex->around[(size_t)b * VOR_AROUND_MOST], gone[2] = {0, 0};
    unsigned went = 0;

    for (unsigned t = complex->degree[b]; t-- > 0;) {
        uint32_t at = around[t], other[2], *corner = &complex->triangle[3 * (size_t)at];

        vor_complex_others(complex, at, b, other);
        if (other[0] == a || other[1] == a) {
            vor_complex_remove(complex, at);
            gone[went++] = at;
            continue;
        }
        for (int c = 0; c < 3; c++)
            corner[c] = corner[c] == b ? a : corner[c];
        complex->around[(size_t)a * VOR_AROUND_MOST + complex->degree[a]++] = at;
    }
    complex->degree[b] = 0;
    memcpy(around, gone, went * sizeof *gone);
    return went;
}

void vor_complex_put(struct vor_complex *complex, uint32_t t, const uint32_t corner[3])
{
    memcpy(&complex->triangle[3 * (size_t)t], corner, 3 * sizeof *corner);
    for (int c = 0; c < 3; c++)
        complex->around[(size_t)corner[c] * VOR_AROUND_MOST + complex->degree[corner[c]]++] = t;
}

vor_status vor_complex_split(struct vor_complex *complex, uint32_t a, uint32_t b, uint32_t middle,
                             unsigned spare, struct vor_error *err)
{
    uint32_t third[2], half[2][3], gone[2];
    unsigned have = vor_complex_edge(complex, a, b, third);
    vor_status status = VOR_OK;

    memcpy(gone, &complex->around[(size_t)middle * VOR_AROUND_MOST], sizeof gone);
    for (unsigned k = 0; k < have; k++) {
        uint32_t t = triangle_of(complex, a, b, third[k]);

        memcpy(half[k], &complex->triangle[3 * (size_t)t], sizeof half[k]);
        for (int c = 0; c < 3; c++)
            half[k][c] = half[k][c] == a ? middle : half[k][c];
        replace(complex, b, a, third[k], middle);
    }
    for (unsigned k = 0; k < have && status == VOR_OK; k++)
        if (k < spare)
            vor_complex_put(complex, gone[k], half[k]);
        else
            status = vor_complex_add(complex, half[k], err);
    return status;
}

uint32_t vor_complex_across(const struct vor_complex *complex, uint32_t t, uint32_t a, uint32_t b)
{
    for (unsigned at = 0; at < complex->degree[a]; at++) {
        uint32_t other[2], u = complex->around[(size_t)a * VOR_AROUND_MOST + at];

        vor_complex_others(complex, u, a, other);
        if (u != t && (other[0] == b || other[1] == b))
            return u;
    }
    return t;
}

int vor_complex_is_open(const struct vor_complex *complex, size_t t, int c)
{
    const uint32_t *corner = &complex->triangle[3 * t];

    return vor_complex_across(complex, (uint32_t)t, corner[c], corner[(c + 1) % 3]) == t;
}

int vor_complex_runs(const uint32_t corner[3], uint32_t a, uint32_t b)
{
    for (int c = 0; c < 3; c++)
        if (corner[c] == a && corner[(c + 1) % 3] == b)
            return 1;
    return 0;
}

unsigned vor_complex_edge(const struct vor_complex *complex, uint32_t a, uint32_t b,
                          uint32_t third[2])
{
    unsigned found = 0;
    uint32_t other[2];

    for (unsigned t = 0; t < complex->degree[a]; t++) {
        vor_complex_others(complex, complex->around[(size_t)a * VOR_AROUND_MOST + t], a, other);
        if (other[0] != b && other[1] != b)
            continue;
        if (found < 2)
            third[found] = other[0] == b ? other[1] : other[0];
        found++;
    }
    return found;
}

/* Whether the triangles at point i stay runs of one fan with one more between its neighbours a and
 * b, whose edges to i have one triangle each or none. */
static int fan_takes(const struct vor_complex *complex, uint32_t i, uint32_t a, uint32_t b)
{
    uint32_t third[2], before = a, at;
    unsigned steps = 1;

    if (complex->degree[i] == VOR_AROUND_MOST)
        return 0;
    if (vor_complex_edge(complex, i, a, third) == 0)
        return 1;
    at = third[0];
    while (at != b && vor_complex_edge(complex, i, at, third) == 2) {
        uint32_t next = third[0] == before ? third[1] : third[0];

        before = at;
        at = next;
        steps++;
    }
    return at != b || steps == complex->degree[i];
}

int vor_complex_takes(const struct vor_complex *complex, const uint32_t corner[3])
{
    uint32_t third[2];

    for (int c = 0; c < 3; c++) {
        uint32_t a = corner[c], b = corner[(c + 1) % 3], opposite = corner[(c + 2) % 3];
        unsigned have = vor_complex_edge(complex, a, b, third);

        if (have > 1 || (have == 1 && third[0] == opposite))
            return 0;
    }
    for (int c = 0; c < 3; c++)
        if (!fan_takes(complex, corner[c], corner[(c + 1) % 3], corner[(c + 2) % 3]))
            return 0;
    return 1;
}

int vor_complex_surrounds(const struct vor_complex *complex, uint32_t i)
{
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t other[2], third[2];

        vor_complex_others(complex, complex->around[(size_t)i * VOR_AROUND_MOST + t], i, other);
        if (vor_complex_edge(complex, i, other[0], third) != 2 ||
            vor_complex_edge(complex, i, other[1], third) != 2)
            return 0;
    }
    return complex->degree[i] > 0;
}

unsigned vor_complex_fans(const struct vor_complex *complex, uint32_t i,
                          unsigned char fan[VOR_AROUND_MOST])
{
    const uint32_t *around = &complex->around[(size_t)i * VOR_AROUND_MOST];
    unsigned degree = complex->degree[i], fans = 0;
    uint32_t other[VOR_AROUND_MOST][2];

    for (unsigned t = 0; t < degree; t++) {
        vor_complex_others(complex, around[t], i, other[t]);
        fan[t] = VOR_AROUND_MOST;
    }
    for (unsigned t = 0; t < degree; t++) {
        int grew = fan[t] == VOR_AROUND_MOST;

        if (grew)
            fan[t] = (unsigned char)fans++;
        while (grew) {
            grew = 0;
            for (unsigned u = 0; u < degree; u++)
                for (unsigned v = 0; fan[u] == fans - 1 && v < degree; v++)
                    if (fan[v] == VOR_AROUND_MOST &&
                        (other[u][0] == other[v][0] || other[u][0] == other[v][1] ||
                         other[u][1] == other[v][0] || other[u][1] == other[v][1])) {
                        fan[v] = fan[u];
                        grew = 1;
                    }
        }
    }
    return fans;
}

/* The fan with most triangles. */
static unsigned largest(const unsigned char *fan, unsigned degree, unsigned fans)
{
    unsigned size[VOR_AROUND_MOST] = {0}, best = 0;

    for (unsigned t = 0; t < degree; t++)
        size[fan[t]]++;
    for (unsigned f = 1; f < fans; f++)
        best = size[f] > size[best] ? f : best;
    return best;
}

/* Leaves point i one fan; returns the least point whose triangles changed, or i. */
static uint32_t prune_point(struct vor_complex *complex, uint32_t i)
{
    unsigned char fan[VOR_AROUND_MOST];
    unsigned degree = complex->degree[i], fans = vor_complex_fans(complex, i, fan), keep;
    uint32_t doomed[VOR_AROUND_MOST], least = i, other[2];

    if (fans < 2)
        return i;
    keep = largest(fan, degree, fans);
    memcpy(doomed, &complex->around[(size_t)i * VOR_AROUND_MOST], degree * sizeof *doomed);
    for (unsigned t = 0; t < degree; t++)
        if (fan[t] != keep) {
            vor_complex_others(complex, doomed[t], i, other);
            least = other[0] < least ? other[0] : least;
            least = other[1] < least ? other[1] : least;
            vor_complex_remove(complex, doomed[t]);
        }
    return least;
}

void vor_complex_prune(struct vor_complex *complex)
{
    int again = 1;

    while (again) {
        again = 0;
        for (size_t i = 0; i < complex->n; i++)
            again |= prune_point(complex, (uint32_t)i) < i;
    }
}
