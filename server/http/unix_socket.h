/** A listening socket in the file system. */
#ifndef VOR_SERVER_HTTP_UNIX_SOCKET_H
#define VOR_SERVER_HTTP_UNIX_SOCKET_H

#include "core/base/status.h"

/** Listens on a path. A socket that nobody answers on is replaced.
 *
 *  @param[in] path  of at most VOR_SOCKET_PATH_MAX - 1 bytes
 *  @param[in] mode  of the file: who may connect
 *
 *  @retval VOR_E_IO a daemon answers on it, a file that is no socket stands there, or it cannot be
 *                   made (message: path and reason) */
VOR_NODISCARD vor_status vor_unix_socket_open(int *out, const char *path, unsigned mode,
                                              struct vor_error *err);

/** Removes the file of "unix:PATH"; does nothing with other addresses. */
void vor_unix_socket_remove(const char *address);

#endif
