/** Open files: as many as connections and streams may need. */
#ifndef VOR_SERVER_BASE_DESCRIPTORS_H
#define VOR_SERVER_BASE_DESCRIPTORS_H

#include "server/base/config.h"

/** Raises the limit of open files so that it is enough for CONNECTIONS, each with a file of its own
 *  (an upload, a result), STREAMS, and what the daemon itself has open. Where the hard limit is too
 *  small, both are lowered to what fits, which the log says; unless one of them was asked for.
 *
 *  @retval VOR_E_PARAM one was asked for, or the hard limit is too small for anything (message:
 * what is needed and the limit) */
VOR_NODISCARD vor_status vor_descriptors_raise(struct vor_config *config, struct vor_error *err);

#endif
