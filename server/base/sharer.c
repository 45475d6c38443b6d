#include "server/base/sharer.h"

#include <stdio.h>
#include <string.h>

struct vor_sharer vor_sharer_of_address(const char *text)
{
    static const uint8_t ipv4[12] = {[10] = 0xff, [11] = 0xff};
    struct vor_sharer sharer = {.name = ""};
    char shown[VOR_ADDRESS_TEXT];
    struct vor_address address;

    if (!vor_address_parse(&address, text, strlen(text)))
        return sharer;
    if (memcmp(address.bytes, ipv4, sizeof ipv4) != 0)
        memset(address.bytes + 8, 0, 8);
    (void)snprintf(sharer.name, sizeof sharer.name, "address %s",
                   vor_address_text(&address, shown));
    return sharer;
}

struct vor_sharer vor_sharer_of_key(const char *name)
{
    struct vor_sharer sharer;

    (void)snprintf(sharer.name, sizeof sharer.name, "key %s", name);
    return sharer;
}

bool vor_sharer_same(const struct vor_sharer *a, const struct vor_sharer *b)
{
    return strcmp(a->name, b->name) == 0;
}
