/** A request from its first line to the last byte of its reply: the library's callbacks. Their
 *  first argument is the struct vor_http. */
#ifndef VOR_SERVER_HTTP_MHD_CALLBACKS_H
#define VOR_SERVER_HTTP_MHD_CALLBACKS_H

#include <microhttpd.h>

/** MHD_OPTION_URI_LOG_CALLBACK: the request line is in; makes the struct vor_request. */
void *vor_mhd_begin(void *cls, const char *target, struct MHD_Connection *connection);

/** The access handler of MHD_start_daemon: the head, each piece of the body, its end, and again
 *  after a suspension. */
enum MHD_Result vor_mhd_step(void *cls, struct MHD_Connection *connection, const char *url,
                             const char *method, const char *version, const char *data,
                             size_t *size, void **con_cls);

/** MHD_OPTION_NOTIFY_COMPLETED: the request is over, however it ended. */
void vor_mhd_end(void *cls, struct MHD_Connection *connection, void **con_cls,
                 enum MHD_RequestTerminationCode code);

#endif
