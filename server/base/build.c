#include "server/base/build.h"

#include <stdlib.h>

struct vor_build vor_build_own(void)
{
    struct vor_build build = {VOR_ENGINE, 0};
    const char *version = VOR_VERSION;

    for (int part = 0; part < 3; part++) {
        char *end;

        build.release = build.release * 1000 + strtol(version, &end, 10);
        version = *end == '.' ? end + 1 : end;
    }
    return build;
}
