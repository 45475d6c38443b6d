/** What the body of a request to start a job is, by its headers. */
#ifndef VOR_SERVER_API_HANDLERS_SUBMIT_BODY_H
#define VOR_SERVER_API_HANDLERS_SUBMIT_BODY_H

#include "server/api/app.h"

#include <stdbool.h>

/** A body is a cloud unless it says otherwise: curl calls what it sends a form of the other kind
 *  (application/x-www-form-urlencoded), so only what cannot be a cloud counts. */
struct vor_submit_body {
    bool is_form; /**< multipart/form-data; then not is_gzip */
    bool is_gzip; /**< Content-Encoding: gzip */
};

/** Reads Content-Type and Content-Encoding.
 *
 *  @return true, or false after unsupported-format was replied: a coding other than gzip, more than
 *          one, or one of a whole form */
bool vor_submit_body_read(struct vor_app *app, struct vor_request *request,
                          struct vor_submit_body *out);

/** Whether one coding (a token, not a list) says gzip.
 *
 *  @retval 1 gzip, 0 "" or identity, -1 something else */
int vor_submit_coding(const char *coding);

/** True when the media type is JSON: application/json, or one that ends in +json. */
bool vor_submit_body_is_json(const struct vor_request *request);

#endif
