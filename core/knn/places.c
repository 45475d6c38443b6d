#include "core/knn/places.h"

#include "core/base/linalg.h"

#include <string.h>

/* Slots that are looked at for one point, so that nobody's points make this slow. Of a table half
 * full of 4 million places (random, a lattice, a plane, a line, a sphere) the longest row of used
 * slots has 61. A point that finds no slot has a place of its own, which costs time in a search and
 * changes no answer. */
enum { PROBES = 64 };

/* Coordinates nearer to 0 are taken as 0: squares of such differences are 0 in float32, or next to
 * it, and the points as far from everything as if they shared a place. */
#define TINY 1e-20f

#define NONE UINT32_MAX

struct table {
    const float *xyz;
    uint32_t *slot;  /* a place, or NONE */
    uint32_t *first; /* of each place: its first point */
    size_t mask, places;
};

static float no_tiny(float x)
{
    return x > -TINY && x < TINY ? 0 : x;
}

static size_t hash_of(const float x[3])
{
    uint64_t hash = 0;

    for (int c = 0; c < 3; c++) {
        float value = no_tiny(x[c]);
        uint32_t bits;

        memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ bits) * UINT64_C(0x9e3779b97f4a7c15);
        hash ^= hash >> 32;
    }
    return (size_t)hash;
}

/* The place of point i, which may be a new one. */
static uint32_t place_of(struct table *table, uint32_t i)
{
    const float *x = &table->xyz[3 * (size_t)i], *other;
    size_t at = hash_of(x) & table->mask;

    for (int probe = 0; probe < PROBES; probe++, at = (at + 1) & table->mask) {
        uint32_t place = table->slot[at];

        if (place == NONE) {
            table->slot[at] = (uint32_t)table->places;
            break;
        }
        other = &table->xyz[3 * (size_t)table->first[place]];
        if (no_tiny(other[0]) == no_tiny(x[0]) && no_tiny(other[1]) == no_tiny(x[1]) &&
            no_tiny(other[2]) == no_tiny(x[2]))
            return place;
    }
    table->first[table->places] = i;
    return (uint32_t)table->places++;
}

static vor_status list(struct vor_places *out, const struct table *table, const uint32_t *place,
                       size_t n, struct vor_error *err)
{
    size_t places = table->places;

    if (VOR_MAKE_ALL(out->memory, err, n, VOR_ARRAY(out->xyz, places, 3),
                     VOR_ZEROED(out->first, places + 2, 1), VOR_ARRAY(out->point, n, 1)) != VOR_OK)
        return VOR_E_NOMEM;
    out->n = places;
    vor_gather(out->xyz, table->xyz, table->first, places);
    for (size_t i = 0; i < n; i++)
        out->first[place[i] + 2]++;
    for (size_t i = 0; i < places; i++)
        out->first[i + 2] += out->first[i + 1];
    for (size_t i = 0; i < n; i++) /* moves the start of a place to that of the next one */
        out->point[out->first[place[i] + 1]++] = (uint32_t)i;
    return VOR_OK;
}

vor_status vor_places_find(struct vor_places *out, const float *xyz, size_t n, size_t many,
                           struct vor_memory *memory, struct vor_error *err)
{
    struct table table = {.xyz = xyz, .mask = 15};
    uint32_t *place, most = 0; /* points that share a place */
    vor_status status = VOR_OK;

    *out = (struct vor_places){.memory = memory};
    while ((table.mask + 1) / 2 < n)
        table.mask = 2 * table.mask + 1;
    table.slot = vor_malloc(memory, table.mask + 1 + 2 * n, sizeof *table.slot);
    if (table.slot == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    table.first = table.slot + table.mask + 1;
    place = table.first + n;
    memset(table.slot, 0xff, (table.mask + 1) * sizeof *table.slot);
    for (size_t i = 0; i < n; i++)
        place[i] = place_of(&table, (uint32_t)i);
    memset(table.slot, 0, (table.mask + 1) * sizeof *table.slot); /* counts from here on */
    for (size_t i = 0; i < n; i++) {
        uint32_t here = ++table.slot[place[i]];

        most = here > most ? here : most;
    }
    if (most > many)
        status = list(out, &table, place, n, err);
    if (status != VOR_OK)
        vor_places_free(out);
    vor_free(memory, table.slot);
    return status;
}

void vor_places_free(struct vor_places *places)
{
    VOR_FREE_ALL(places->memory, places->point, places->first, places->xyz);
    *places = (struct vor_places){.memory = NULL};
}
