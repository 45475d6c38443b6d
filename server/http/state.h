/** What the files of this room share of the whole: options, counters, the guard of connections. */
#ifndef VOR_SERVER_HTTP_STATE_H
#define VOR_SERVER_HTTP_STATE_H

#include "server/base/endpoint.h"
#include "server/http/http.h"
#include "server/http/watchdog.h"

#include <stdatomic.h>

enum {
    VOR_CONNECTION_BYTES = 49152 /**< what the library keeps for a connection: the longest header
                                    block, and room to read a body and to answer */
};

struct MHD_Daemon;
struct vor_conn_guard;

struct vor_http {
    struct vor_http_options options;
    struct MHD_Daemon *daemon;
    struct vor_conn_guard *guard;
    char address[VOR_SOCKET_PATH_MAX + 8];
    int fd;           /**< listening; the library's from start to quiesce, -1 then */
    atomic_uint busy; /**< requests under way */
    atomic_bool quiesced, closing;
    struct vor_watchdog watchdog;
};

#endif
