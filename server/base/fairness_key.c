#include "server/base/fairness_key.h"

#include <stdio.h>
#include <string.h>

struct vor_fairness_key vor_fairness_key_of_address(const char *text)
{
    static const uint8_t ipv4[12] = {[10] = 0xff, [11] = 0xff};
    struct vor_fairness_key sharer = {.name = ""};
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

struct vor_fairness_key vor_fairness_key_of_key(const char *name)
{
    struct vor_fairness_key sharer;

    (void)snprintf(sharer.name, sizeof sharer.name, "key %s", name);
    return sharer;
}

bool vor_fairness_key_same(const struct vor_fairness_key *a, const struct vor_fairness_key *b)
{
    return strcmp(a->name, b->name) == 0;
}
