/** libmicrohttpd, loaded when the daemon opens its first address. With what it needs it is ten of
 * the libraries that the command line would start with. */
#ifndef VOR_SERVER_HTTP_MHD_LIBRARY_H
#define VOR_SERVER_HTTP_MHD_LIBRARY_H

#include "core/base/status.h"

#include <microhttpd.h>

#define VOR_MHD_TABLE(X)                                                                           \
    X(add_connection)                                                                              \
    X(add_response_header)                                                                         \
    X(create_response_from_buffer)                                                                 \
    X(create_response_from_callback)                                                               \
    X(create_response_from_fd_at_offset64)                                                         \
    X(destroy_response)                                                                            \
    X(get_connection_info)                                                                         \
    X(get_connection_values)                                                                       \
    X(queue_response)                                                                              \
    X(quiesce_daemon)                                                                              \
    X(resume_connection)                                                                           \
    X(start_daemon)                                                                                \
    X(stop_daemon)                                                                                 \
    X(suspend_connection)

struct vor_mhd {
#define VOR_MHD_MEMBER(name) __typeof__(&MHD_##name) name;
    VOR_MHD_TABLE(VOR_MHD_MEMBER)
#undef VOR_MHD_MEMBER
};

/** Its functions without their prefix, as in vor_mhd->stop_daemon(), once it is loaded. */
extern const struct vor_mhd *const vor_mhd;

/** Loads the library, once. Thread-safe.
 *
 *  @retval VOR_E_IO it is not installed, or lacks a function */
VOR_NODISCARD vor_status vor_mhd_load(struct vor_error *err);

#endif
