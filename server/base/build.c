#include "server/base/build.h"

#include <stdlib.h>

/* "1.2.3" as a number. */
static int64_t number_of(const char *version)
{
    int64_t number = 0;

    for (int part = 0; part < 3; part++) {
        char *end;

        number = number * 1000 + strtol(version, &end, 10);
        version = *end == '.' ? end + 1 : end;
    }
    return number;
}

struct vor_build vor_build_own(void)
{
    return (struct vor_build){VOR_ENGINE, number_of(VOR_VERSION)};
}
