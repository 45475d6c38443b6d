#include "core/cloud/notes.h"

#include <stdio.h>
#include <string.h>

void vor_dropped_add(struct vor_dropped list[VOR_DROPPED_MAX], unsigned *list_count,
                     const char *what, uint64_t count)
{
    unsigned at = 0;

    if (count == 0)
        return;
    while (at < *list_count && strncmp(list[at].what, what, sizeof list[at].what - 1) != 0)
        at++;
    if (at == VOR_DROPPED_MAX) {
        at--;
        (void)snprintf(list[at].what, sizeof list[at].what, "others");
    } else if (at == *list_count) {
        (void)snprintf(list[at].what, sizeof list[at].what, "%s", what);
        list[at].count = 0;
        (*list_count)++;
    }
    if (__builtin_add_overflow(list[at].count, count, &list[at].count))
        list[at].count = UINT64_MAX;
}

uint64_t vor_notes_remarks(const struct vor_notes *notes, const char *word)
{
    size_t length = strlen(word);
    uint64_t count = 0;

    for (size_t at = 0; at < notes->remarks_size; at++) {
        const char *line = notes->remarks + at;
        const char *end = memchr(line, '\n', notes->remarks_size - at);
        size_t size = end != NULL ? (size_t)(end - line) : notes->remarks_size - at;

        count += size >= length && memcmp(line, word, length) == 0;
        at += size;
    }
    return count;
}

vor_status vor_notes_copy_remarks(struct vor_notes *out, const struct vor_notes *in,
                                  struct vor_memory *memory, struct vor_error *err)
{
    char *remarks;

    if (in->remarks_size == 0)
        return VOR_OK;
    remarks = vor_malloc(memory, in->remarks_size, 1);
    if (remarks == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu bytes of comments", in->remarks_size);
    memcpy(remarks, in->remarks, in->remarks_size);
    out->remarks = remarks;
    out->remarks_size = in->remarks_size;
    return VOR_OK;
}
