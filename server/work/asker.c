#include "server/work/asker.h"

#include <stdlib.h>

struct vor_waiting {
    struct vor_waiting *next;
    struct vor_asker asker;
};

int vor_waiting_add(struct vor_waiting **list, const struct vor_asker *asker)
{
    struct vor_waiting *waiting = malloc(sizeof *waiting);

    if (waiting == NULL)
        return 0;
    *waiting = (struct vor_waiting){*list, *asker};
    *list = waiting;
    return 1;
}

struct vor_waiting *vor_waiting_take(struct vor_waiting **list)
{
    struct vor_waiting *taken = *list;

    *list = NULL;
    return taken;
}

void vor_waiting_wake(struct vor_waiting *list)
{
    while (list != NULL) {
        struct vor_waiting *next = list->next;

        list->asker.wake(list->asker.ctx);
        free(list);
        list = next;
    }
}
