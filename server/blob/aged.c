#include "server/blob/aged.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void vor_aged_add(struct vor_aged *list, const char *name, uint64_t size, int64_t since_ms)
{
    struct vor_aged_file *file;

    if (list->count == list->capacity) {
        size_t capacity = list->capacity > 0 ? 2 * list->capacity : 64;

        file = realloc(list->item, capacity * sizeof *file);
        if (file == NULL) {
            list->is_short = 1;
            return;
        }
        list->item = file;
        list->capacity = capacity;
    }
    file = &list->item[list->count++];
    (void)snprintf(file->name, sizeof file->name, "%s", name);
    file->size = size;
    file->since_ms = since_ms;
}

static int newest_first(const void *a, const void *b)
{
    const struct vor_aged_file *x = a, *y = b;

    if (x->since_ms != y->since_ms)
        return x->since_ms < y->since_ms ? 1 : -1;
    return strcmp(x->name, y->name);
}

void vor_aged_sort(struct vor_aged *list)
{
    if (list->count > 0)
        qsort(list->item, list->count, sizeof *list->item, newest_first);
}

void vor_aged_free(struct vor_aged *list)
{
    free(list->item);
    *list = (struct vor_aged){.item = NULL};
}
