#include "server/work/asker.h"

#include <stdlib.h>

struct vor_askers {
    struct vor_askers *next;
    struct vor_asker asker;
};

int vor_waiting_add(struct vor_askers **list, const struct vor_asker *asker)
{
    struct vor_askers *waiting = malloc(sizeof *waiting);

    if (waiting == NULL)
        return 0;
    *waiting = (struct vor_askers){*list, *asker};
    *list = waiting;
    return 1;
}

struct vor_askers *vor_waiting_take(struct vor_askers **list)
{
    struct vor_askers *taken = *list;

    *list = NULL;
    return taken;
}

void vor_waiting_wake(struct vor_askers *list)
{
    while (list != NULL) {
        struct vor_askers *next = list->next;

        list->asker.wake(list->asker.ctx);
        free(list);
        list = next;
    }
}
