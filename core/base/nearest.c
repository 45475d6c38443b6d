#include "core/base/nearest.h"

#include <stdio.h>
#include <string.h>

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

void vor_nearest_init(struct vor_nearest *nearest, const char *word, size_t length)
{
    memset(nearest, 0, sizeof *nearest);
    for (size_t i = 0; i < length && length <= VOR_NEAREST_WORD; i++)
        nearest->word[i] = lower(word[i]);
    nearest->near = length / 3;
}

void vor_nearest_init_any(struct vor_nearest *nearest, const char *word, size_t length)
{
    vor_nearest_init(nearest, word, length);
    nearest->near = 2 * VOR_NEAREST_WORD;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Optimal string alignment: Damerau 1964, no part edited twice; three rows of the table. */
static size_t edits_to(const char *from, const char *to, size_t length)
{
    size_t rows[3][VOR_NEAREST_WORD + 1];
    size_t *before = rows[0], *above = rows[1], *row = rows[2], *spare;

    for (size_t k = 0; k <= length; k++)
        above[k] = k;
    for (size_t i = 1; from[i - 1] != '\0'; i++) {
        row[0] = i;
        for (size_t k = 1; k <= length; k++) {
            size_t differs = from[i - 1] != lower(to[k - 1]);

            row[k] = least(least(above[k], row[k - 1]) + 1, above[k - 1] + differs);
            if (i > 1 && k > 1 && from[i - 1] == lower(to[k - 2]) &&
                from[i - 2] == lower(to[k - 1]))
                row[k] = least(row[k], before[k - 2] + 1);
        }
        spare = before;
        before = above;
        above = row;
        row = spare;
    }
    return above[length];
}

void vor_nearest_try(struct vor_nearest *nearest, const char *word, size_t length)
{
    size_t edits, at = nearest->count;

    if (nearest->word[0] == '\0' || length == 0 || length > VOR_NEAREST_WORD)
        return;
    edits = edits_to(nearest->word, word, length);
    if (edits > nearest->near)
        return;
    while (at > 0 && nearest->found[at - 1].edits > edits)
        at--;
    if (at == VOR_NEAREST_MAX)
        return;
    nearest->count += nearest->count < VOR_NEAREST_MAX;
    memmove(&nearest->found[at + 1], &nearest->found[at],
            (nearest->count - 1 - at) * sizeof nearest->found[0]);
    nearest->found[at].word = word;
    nearest->found[at].length = length;
    nearest->found[at].edits = edits;
}

const char *vor_nearest_text(const struct vor_nearest *nearest, const char *prefix,
                             char out[VOR_NEAREST_TEXT_SIZE])
{
    size_t at = 0;

    out[0] = '\0';
    for (unsigned i = 0; i < nearest->count; i++) {
        const char *between = i == 0 ? "; did you mean " : i < nearest->count - 1 ? ", " : " or ";

        at += (size_t)snprintf(out + at, VOR_NEAREST_TEXT_SIZE - at, "%s%s%.*s", between, prefix,
                               (int)nearest->found[i].length, nearest->found[i].word);
    }
    if (at > 0)
        (void)snprintf(out + at, VOR_NEAREST_TEXT_SIZE - at, "?");
    return out;
}
