/** Which build this is, as daemons that work together have to know of each other. */
#ifndef VOR_SERVER_BASE_BUILD_H
#define VOR_SERVER_BASE_BUILD_H

#include <stdint.h>

struct vor_build {
    char engine[16]; /**< digest of the sources of the engine: the same bytes of results */
    int64_t release; /**< the version as a number that grows: 1.2.3 is 1002003 */
};

/** That of this program. */
struct vor_build vor_build_own(void);

#endif
