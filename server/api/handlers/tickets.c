/* Links to one result that need no key for a minute: for a download that something else than the
 * caller's own program fetches, such as a browser. */
#include "server/api/tickets.h"

#include "core/base/quote.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/base/clock.h"

#include <stdio.h>
#include <string.h>

enum { SHOWN_SIZE = 64, MS = 1000 };

/* The output that the query asks for, else the main one; NULL after a problem has been replied. */
static const struct vor_artefact_info *read_output(struct vor_request *request,
                                                   const struct vor_job_view *view)
{
    const struct vor_artefact_info *output = &view->spec.process->outputs[0];

    for (int i = 0; i < request->pair_count; i++) {
        const char *name = request->pairs[i].name, *value = request->pairs[i].value;

        if (strcmp(name, "output") != 0) {
            vor_problem_say(request, "invalid-query-parameter-value",
                            "unknown parameter \"%s\"; want output",
                            VOR_QUOTED(SHOWN_SIZE, name, strlen(name)));
            return NULL;
        }
        output = vor_artefact_find(view->spec.process->outputs, value);
        if (output == NULL) {
            vor_problem_say(request, "no-such-output", "there is no output %s",
                            VOR_QUOTED(SHOWN_SIZE, value, strlen(value)));
            return NULL;
        }
    }
    return output;
}

enum vor_next vor_handle_ticket(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    const struct vor_artefact_info *output;
    struct vor_job_view view;
    char url[VOR_URL_MAX], ticket[VOR_TICKET_SIZE], whole[VOR_URL_MAX + VOR_TICKET_SIZE + 16];
    char expires[VOR_CLOCK_TEXT_SIZE];
    struct vor_text text;

    if (!vor_job_look_up(request, &view))
        return VOR_NEXT_REPLY;
    output = read_output(request, &view);
    if (output == NULL)
        return VOR_NEXT_REPLY;
    if (view.status != VOR_JOB_SUCCESSFUL || view.expired)
        return vor_result_missing(request, &view);
    vor_app_result_url(request, &view.id, output->name, url);
    vor_ticket_write(request->app->tickets, &view.id, output->name,
                     vor_tickets_now(request->app->tickets), ticket);
    (void)snprintf(whole, sizeof whole, "%s?ticket=%s", url, ticket);
    vor_clock_text(vor_clock_wall_ms() + (int64_t)VOR_TICKET_SECONDS * MS, expires);
    vor_document_begin(&text);
    vor_json_put_string(&text, "href", whole);
    vor_json_put_string(&text, "ticket", ticket);
    vor_json_put_string(&text, "expires", expires);
    vor_json_end_object(&text);
    vor_reply_header(request, "Location", whole);
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_reply_json(request, 201, &text);
}
