#include "server/base/caller.h"

#include <stdio.h>
#include <string.h>

struct vor_caller vor_caller_of_address(const char *text)
{
    static const uint8_t ipv4[12] = {[10] = 0xff, [11] = 0xff};
    struct vor_caller caller = {.name = ""};
    char shown[VOR_ADDRESS_TEXT];
    struct vor_address address;

    if (!vor_address_parse(&address, text, strlen(text)))
        return caller;
    if (memcmp(address.bytes, ipv4, sizeof ipv4) != 0)
        memset(address.bytes + 8, 0, 8);
    (void)snprintf(caller.name, sizeof caller.name, "address %s",
                   vor_address_text(&address, shown));
    return caller;
}

bool vor_caller_same(const struct vor_caller *a, const struct vor_caller *b)
{
    return strcmp(a->name, b->name) == 0;
}
