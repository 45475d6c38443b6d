/** A result in another format than the job's: waits while it is made. */
#ifndef VOR_SERVER_API_HANDLERS_CONVERTED_H
#define VOR_SERVER_API_HANDLERS_CONVERTED_H

#include "server/api/app.h"
#include "server/work/conversion.h"

/** Looks for output `index` of a successful job in that format, and has it made if it was not. HEAD
 *  has nothing made.
 *
 *  @param[out] out  its fd is -1 unless the bytes are there
 *
 *  @retval VOR_NEXT_REPLY  the bytes are there; or, if fd is -1, a reply has been made
 *  @retval VOR_NEXT_WAIT   the request waits; the handler is to call this again at the next step */
enum vor_next vor_converted_get(struct vor_app *app, struct vor_request *request,
                                const struct vor_job_view *view, unsigned index, unsigned format,
                                struct vor_converted *out);

#endif
