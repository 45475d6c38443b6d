/** A request to start a job whose body is JSON, as clients of OGC API - Processes send it. A cloud
 *  does not come that way here; who tries is told where things belong. */
#ifndef VOR_SERVER_API_HANDLERS_SUBMIT_JSON_H
#define VOR_SERVER_API_HANDLERS_SUBMIT_JSON_H

#include "server/api/app.h"

/** A vor_handler: reads the body and refuses it. Parameters in it are named, each with the place
 *  where it stands and the query that it belongs into (invalid-parameter); a body without any is
 *  no format that is read (unsupported-format), and one that is no JSON malformed-request. */
enum vor_next vor_submit_json(struct vor_app *app, struct vor_request *request, enum vor_step step);

#endif
