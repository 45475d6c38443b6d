/** What a request to start a job asks for, read off its head before its body comes. */
#ifndef VOR_SERVER_API_HANDLERS_SUBMIT_HEAD_H
#define VOR_SERVER_API_HANDLERS_SUBMIT_HEAD_H

#include "server/api/handlers/submit_besides.h"

enum vor_submit_mode {
    VOR_SUBMIT_SYNC,  /**< wait for the result */
    VOR_SUBMIT_ASYNC, /**< 201 as soon as the job is accepted */
    VOR_SUBMIT_STREAM /**< the job as an event stream */
};

struct vor_submit_head {
    struct vor_spec spec; /**< checked (vor_spec_check) */
    struct vor_submit_besides besides;
    enum vor_submit_mode mode;
    double wait_seconds; /**< SYNC: then 201 after all; negative: for as long as it takes */
    bool is_async;       /**< respond-async was asked for (perhaps with wait) */
};

/** True, or false after a problem has been replied: no-such-process, a parameter unknown, given
 *  twice or out of range, a key that is none, no acceptable format. */
bool vor_submit_read(struct vor_app *app, struct vor_request *request, struct vor_submit_head *out);

#endif
