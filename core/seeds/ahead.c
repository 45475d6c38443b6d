#include "core/seeds/seeds.h"

void vor_seeds_input_ahead(struct vor_seeds *seeds, size_t begin, size_t end)
{
    size_t next;

    for (size_t i = begin; i < end; i = next) {
        unsigned k = seeds->last_fit[i].k > 0 ? 0 : vor_seeds_asked(seeds, &seeds->xyz[3 * i]);

        for (next = i + 1; k > 0 && next < end && seeds->last_fit[next].k == 0 &&
                           vor_seeds_asked(seeds, &seeds->xyz[3 * next]) == k;)
            next++;
        if (next - i < 2)
            continue;
        vor_input_lists_make(&seeds->input_lists, i, next - i, seeds->xyz, k);
        for (size_t j = i; j < next; j++)
            seeds->last_fit[j].k = (uint16_t)k;
    }
}

void vor_seeds_crowd_ahead(struct vor_seeds *seeds, struct vor_scratch *scratch,
                           const uint32_t *who, size_t count)
{
    scratch->queries += vor_point_lists_renew(&seeds->point_lists, &seeds->view, who, count);
}
