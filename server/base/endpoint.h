/** Where a daemon listens. */
#ifndef VOR_SERVER_BASE_ENDPOINT_H
#define VOR_SERVER_BASE_ENDPOINT_H

#include "core/base/status.h"

/** Bytes of a socket's path that the kernel takes, with the NUL. */
enum { VOR_SOCKET_PATH_MAX = 108, VOR_ENDPOINT_HOST_MAX = 256 };

struct vor_endpoint {
    char host[VOR_ENDPOINT_HOST_MAX]; /**< without brackets; "localhost" of a socket's path */
    unsigned port;                    /**< 0 of a socket's path */
    char path[VOR_SOCKET_PATH_MAX];   /**< of a Unix socket; "" of a host */
    int loopback;                     /**< this machine only */
};

/** Reads "HOST:PORT", "[::1]:8080" or "unix:/PATH", the value of a setting.
 *
 *  @retval VOR_E_PARAM it is none of these (message: flag, value, and what is wanted) */
VOR_NODISCARD vor_status vor_endpoint_parse(struct vor_endpoint *out, const char *flag,
                                            const char *text, struct vor_error *err);

#endif
