/** What a request to start a job asks for, read off its head before its body comes. */
#ifndef VOR_SERVER_API_HANDLERS_SUBMIT_HEAD_H
#define VOR_SERVER_API_HANDLERS_SUBMIT_HEAD_H

#include "server/api/handlers/submit_body.h"
#include "server/api/handlers/submit_options.h"

enum vor_submit_mode {
    VOR_SUBMIT_SYNC,  /**< wait for the result */
    VOR_SUBMIT_ASYNC, /**< 201 as soon as the job is accepted */
    VOR_SUBMIT_STREAM /**< the job as an event stream */
};

struct vor_submit_head {
    struct vor_spec spec; /**< checked (vor_spec_check) once complete */
    struct vor_submit_options options;
    struct vor_submit_body body;
    enum vor_submit_mode mode;
    double wait_seconds; /**< SYNC: then 201 after all; negative: for as long as it takes */
    bool is_async;       /**< respond-async was asked for (perhaps with wait) */
};

/** Reads a head; it is complete, but for that of a form, whose parameters are still to come.
 *
 *  @return true, or false after a problem has been replied: no-such-process, a coding that is not
 *          taken, a parameter unknown, given twice or out of range, a key that is none, no
 *          acceptable format */
bool vor_submit_read(struct vor_app *app, struct vor_request *request, struct vor_submit_head *out);

/** Completes a head whose parameters are all set, and chooses the format.
 *
 *  @return true, or false after a problem has been replied, as above */
bool vor_submit_complete(struct vor_app *app, struct vor_request *request,
                         struct vor_submit_head *head);

#endif
