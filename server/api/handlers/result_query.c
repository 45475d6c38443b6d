#include "server/api/handlers/handlers.h"

#include "core/base/quote.h"
#include "proto/codec.h"
#include "server/api/accept.h"
#include "server/api/links.h"
#include "server/api/problem.h"

#include <stdio.h>
#include <string.h>

enum { SHOWN = 64 };

/* Reads the value of format; NULL, or what is wrong with it. */
static const char *read_format(struct vor_result_query *ask, const char *value, char *out,
                               size_t size)
{
    int at;

    if (ask->has_format)
        return "format is given more than once";
    for (unsigned i = 0; vor_format(i) != NULL; i++)
        if (strcmp(vor_format(i)->name, value) == 0) {
            ask->has_format = true;
            ask->format = i;
            return NULL;
        }
    at = snprintf(out, size, "format is \"%s\", want one of ",
                  VOR_QUOTED(SHOWN, value, strlen(value)));
    for (unsigned i = 0; vor_format(i) != NULL && (size_t)at < size; i++)
        at += snprintf(out + at, size - (size_t)at, "%s%s", i > 0 ? ", " : "", vor_format(i)->name);
    return out;
}

bool vor_result_query_read(struct vor_request *request, bool takes_format,
                           struct vor_result_query *out)
{
    char detail[256];
    const char *segment, *why;
    bool is_for_one = vor_path_segment(request->path, 4, &segment) > 0;

    *out = (struct vor_result_query){.has_format = false};
    for (int i = 0; i < request->pair_count; i++) {
        const char *name = request->pairs[i].name, *value = request->pairs[i].value;

        why = NULL;
        if (is_for_one && strcmp(name, "ticket") == 0)
            continue; /* it says who sends the request, and is checked by then */
        if (takes_format && strcmp(name, "format") == 0) {
            why = read_format(out, value, detail, sizeof detail);
        } else if (is_for_one && strcmp(name, "link") == 0) {
            out->stays = strcmp(value, "false") == 0;
            if (!out->stays && strcmp(value, "true") != 0)
                why = "link must be true or false";
        } else {
            (void)snprintf(detail, sizeof detail, "unknown parameter \"%s\"; want %s",
                           VOR_QUOTED(SHOWN, name, strlen(name)),
                           takes_format ? "format or link"
                           : is_for_one ? "link"
                                        : "none");
            why = detail;
        }
        if (why != NULL)
            return vor_problem_reply(request, &VOR_PROBLEM("invalid-query-parameter-value",
                                                           .parameter = name, .detail = why));
    }
    return true;
}

bool vor_result_accepts(struct vor_request *request, const char *media_type)
{
    if (vor_accept_takes(request, media_type))
        return true;
    return vor_problem_say(request, "not-acceptable",
                           "the response is %s, but the Accept header "
                           "does not allow this media type",
                           media_type);
}
