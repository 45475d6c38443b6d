/** What a request for a result asks for besides its path. */
#ifndef VOR_SERVER_API_HANDLERS_ASK_H
#define VOR_SERVER_API_HANDLERS_ASK_H

#include "server/api/app.h"

/** The query of a request for a result. */
struct vor_result_ask {
    bool has_format;
    unsigned format; /**< index of vor_format */
};

/** Reads the query of a request for a result.
 *
 *  @param[in] takes_format  it may have the parameter format; it may have no other, but for a
 * ticket to one result
 *
 *  @return true, or false after an invalid-query-parameter-value problem has been replied */
bool vor_ask_read(struct vor_app *app, struct vor_request *request, bool takes_format,
                  struct vor_result_ask *out);

/** Checks that the caller takes what will be sent.
 *
 *  @return true, or false after a not-acceptable problem has been replied */
bool vor_ask_accepts(struct vor_app *app, struct vor_request *request, const char *media_type);

#endif
