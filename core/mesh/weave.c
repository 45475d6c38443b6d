#include "core/mesh/weave.h"

#include "core/mesh/quality.h"
#include "core/mesh/twosided.h"

#include <stdlib.h>
#include <string.h>

/* A triangle that fewer than three cells propose. */
struct candidate {
    uint32_t corner[3]; /* ascending */
    uint32_t votes;
    double quality;
};

struct weave {
    struct vor_complex *complex;
    struct vor_woven *told;
    const struct vor_fans *fans;
    const struct vor_sheet *sheet;
    struct candidate *open; /* those that wait */
    size_t count, room;
    struct vor_twosided sides; /* of the triangles taken */
};

static void sort_three(uint32_t corner[3])
{
    for (int pass = 0; pass < 2; pass++)
        for (int c = 0; c < 2; c++)
            if (corner[c] > corner[c + 1]) {
                uint32_t more = corner[c];

                corner[c] = corner[c + 1];
                corner[c + 1] = more;
            }
}

static vor_status wait(struct weave *weave, const uint32_t corner[3], unsigned votes,
                       struct vor_error *err)
{
    struct candidate *next;

    if (weave->count == weave->room) {
        size_t room = 2 * weave->room + 256;
        struct candidate *grown =
            vor_realloc(weave->complex->memory, weave->open, room, sizeof *grown);

        if (grown == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu proposed triangles", room);
        weave->open = grown;
        weave->room = room;
    }
    next = &weave->open[weave->count++];
    memcpy(next->corner, corner, sizeof next->corner);
    next->votes = votes;
    next->quality = vor_triangle_quality(weave->sheet->seeds->xyz, corner);
    return VOR_OK;
}

/* Takes the triangle of a corner of the cell of i, or lets it wait, where i is the first of those
 * that propose it. */
static vor_status propose(struct weave *weave, uint32_t i, uint32_t j, uint32_t k,
                          struct vor_error *err)
{
    uint32_t corner[3] = {i, j, k};
    unsigned votes = 0;

    sort_three(corner);
    for (int c = 0; c < 3; c++) {
        if (!vor_fans_has(weave->fans, corner[c], corner[(c + 1) % 3], corner[(c + 2) % 3]))
            continue;
        if (votes++ == 0 && corner[c] != i)
            return VOR_OK;
    }
    if (votes < 3)
        return wait(weave, corner, votes, err);
    weave->told->agreed[3]++;
    return vor_complex_add(weave->complex, corner, err);
}

static vor_status propose_all(struct weave *weave, struct vor_error *err)
{
    const struct vor_fans *fans = weave->fans;
    vor_status status = VOR_OK;

    for (size_t i = 0; i < fans->n; i++) {
        const uint32_t *neighbor = &fans->neighbor[i * VOR_FAN_MOST];
        unsigned count = fans->count[i];

        for (unsigned e = 0; e < count && status == VOR_OK; e++) {
            uint32_t j = neighbor[e], k = neighbor[e + 1 < count ? e + 1 : 0];

            if (j != VOR_FAN_OPEN && k != VOR_FAN_OPEN && j != k)
                status = propose(weave, (uint32_t)i, j, k, err);
        }
    }
    return status;
}

static int better(const void *a, const void *b)
{
    const struct candidate *x = a, *y = b;

    if (x->votes != y->votes)
        return x->votes > y->votes ? -1 : 1;
    if (x->quality != y->quality)
        return x->quality > y->quality ? -1 : 1;
    return memcmp(x->corner, y->corner, sizeof x->corner);
}

/* Directions to other points in the tangent plane of one, by two axes of any length alike. */
struct plane {
    const float *xyz, *at;
    double axis[2][3];
};

static void plane_of(struct plane *plane, const struct vor_sheet *sheet, uint32_t i)
{
    struct vor_frame frame;

    vor_frame_of(&frame, &sheet->normal[3 * (size_t)i]);
    memcpy(plane->axis, frame.axis, sizeof plane->axis);
    plane->xyz = sheet->seeds->xyz;
    plane->at = &plane->xyz[3 * (size_t)i];
}

static void look(const struct plane *plane, uint32_t j, double out[2])
{
    const float *x = &plane->xyz[3 * (size_t)j];

    out[0] = out[1] = 0;
    for (int c = 0; c < 3; c++) {
        double d = (double)x[c] - (double)plane->at[c];

        out[0] += plane->axis[0][c] * d;
        out[1] += plane->axis[1][c] * d;
    }
}

static double turn(const double a[2], const double b[2])
{
    return a[0] * b[1] - a[1] * b[0];
}

/* Whether direction x is strictly between a and b, on the side where they are less than half a turn
 * apart. */
static int between(const double x[2], const double a[2], const double b[2])
{
    double sign = turn(a, b) < 0 ? -1 : 1;

    return sign * turn(a, x) > 0 && sign * turn(x, b) > 0;
}

/* Whether the triangles at point i leave the sector from j to k free. */
static int is_free(const struct weave *weave, uint32_t i, uint32_t j, uint32_t k)
{
    const struct vor_complex *complex = weave->complex;
    const uint32_t *around = &complex->around[(size_t)i * VOR_AROUND_MOST];
    struct plane plane;
    double a[2], b[2], middle[2];

    plane_of(&plane, weave->sheet, i);
    look(&plane, j, a);
    look(&plane, k, b);
    middle[0] = a[0] + b[0];
    middle[1] = a[1] + b[1];
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t other[2];
        double c[2], d[2];

        vor_complex_others(complex, around[t], i, other);
        look(&plane, other[0], c);
        look(&plane, other[1], d);
        if (between(c, a, b) || between(d, a, b) || between(middle, c, d))
            return 0;
    }
    return 1;
}

static vor_status take(struct weave *weave, const struct candidate *next, struct vor_error *err)
{
    const uint32_t *corner = next->corner;

    vor_status status;

    if (!vor_complex_takes(weave->complex, corner) ||
        !vor_twosided_takes(&weave->sides, weave->complex, corner))
        return VOR_OK;
    for (int c = 0; c < 3; c++)
        if (!is_free(weave, corner[c], corner[(c + 1) % 3], corner[(c + 2) % 3]))
            return VOR_OK;
    if (!vor_sheet_is_along(weave->sheet, corner) || !vor_sheet_is_under(weave->sheet, corner))
        return VOR_OK;
    weave->told->agreed[next->votes]++;
    status = vor_complex_add(weave->complex, corner, err);
    if (status == VOR_OK)
        vor_twosided_add(&weave->sides, weave->complex, (uint32_t)(weave->complex->count - 1));
    return status;
}

vor_status vor_weave(struct vor_complex *complex, struct vor_woven *told,
                     const struct vor_fans *fans, const struct vor_sheet *sheet,
                     struct vor_error *err)
{
    struct weave weave = {complex, told, fans, sheet, NULL, 0, 0, {NULL}};
    vor_status status;

    memset(told, 0, sizeof *told);
    status = propose_all(&weave, err);
    if (status == VOR_OK)
        status = vor_twosided_make(&weave.sides, complex, weave.count, err);
    if (weave.count > 0)
        qsort(weave.open, weave.count, sizeof *weave.open, better);
    for (size_t c = 0; c < weave.count && status == VOR_OK; c++)
        status = take(&weave, &weave.open[c], err);
    vor_twosided_free(&weave.sides);
    vor_free(complex->memory, weave.open);
    return status;
}
