/** The events of a job, in the pieces that the store keeps. */
#ifndef VOR_SERVER_JOBS_TRACE_H
#define VOR_SERVER_JOBS_TRACE_H

#include "core/base/status.h"
#include "server/jobs/bus.h"
#include "server/store/store.h"

#include <stddef.h>
#include <stdint.h>

/** What was published on a bus after number `after`, as a piece.
 *
 *  @param[out] piece  of size 0 when nothing was; its data is *bytes
 *  @param[out] bytes  malloc, the caller frees; NULL when nothing was, or on failure
 *  @retval VOR_E_NOMEM
 *
 *  Any thread; what is published meanwhile is not in it. */
VOR_NODISCARD vor_status vor_trace_pack(struct vor_bus *bus, uint32_t after,
                                        struct vor_event_piece *piece, uint8_t **bytes,
                                        struct vor_error *err);

/** Publishes the events of a piece on a bus.
 *
 *  @retval VOR_E_FORMAT the bytes are no piece, or one of a build with stages that this one does
 * not have; the events before are published
 *  @retval VOR_E_NOMEM  likewise */
VOR_NODISCARD vor_status vor_trace_unpack(struct vor_bus *bus, const struct vor_event_piece *piece,
                                          struct vor_error *err);

#endif
