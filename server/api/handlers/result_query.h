/** What a request for a result asks for besides its path. */
#ifndef VOR_SERVER_API_HANDLERS_RESULT_QUERY_H
#define VOR_SERVER_API_HANDLERS_RESULT_QUERY_H

#include "server/api/app.h"

/** The query of a request for a result. */
struct vor_result_query {
    bool has_format;
    unsigned format; /**< index of vor_format */
    bool stays;      /**< link=false: the bytes come from here, wherever they lie */
};

/** Reads the query of a request for a result.
 *
 *  @param[in] takes_format  it may have the parameter format; one for one result may have link
 *                           and a ticket, and no other
 *
 *  @return true, or false after an invalid-query-parameter-value problem has been replied */
bool vor_result_query_read(struct vor_app *app, struct vor_request *request, bool takes_format,
                           struct vor_result_query *out);

/** Checks that the caller takes what will be sent.
 *
 *  @return true, or false after a not-acceptable problem has been replied */
bool vor_result_accepts(struct vor_app *app, struct vor_request *request, const char *media_type);

#endif
