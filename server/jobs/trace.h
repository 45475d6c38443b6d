/** The events of a job that ended, as the store keeps them. */
#ifndef VOR_SERVER_JOBS_TRACE_H
#define VOR_SERVER_JOBS_TRACE_H

#include "core/base/status.h"
#include "server/jobs/bus.h"

#include <stddef.h>
#include <stdint.h>

/** Everything that was published on a bus so far, as bytes.
 *
 *  @param[out] bytes malloc, the caller frees; only set when VOR_OK is returned
 *  @retval VOR_E_NOMEM
 *
 *  Any thread; what is published meanwhile is not in it. */
VOR_NODISCARD vor_status vor_trace_pack(struct vor_bus *bus, uint8_t **bytes, size_t *size,
                                        struct vor_error *err);

/** A bus with the events of a trace, with one reference.
 *
 *  @param[out] out only set when VOR_OK is returned
 *  @retval VOR_E_FORMAT the bytes are not a trace, or one of a build with stages that this one does
 * not have
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_trace_unpack(struct vor_bus **out, const uint8_t *bytes, size_t size,
                                          struct vor_error *err);

#endif
