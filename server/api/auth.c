#include "server/api/auth.h"

#include "server/api/problem.h"
#include "server/api/tickets.h"
#include "server/base/keys.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#define REALM "Bearer realm=\"voronoid\""

/* Who has a ticket, which is good for one result alone. */
static const struct vor_principal ticket_holder = {.scopes = 1u << VOR_SCOPE_READ,
                                                   .sees_all = true};

const char *vor_auth_tenant(const struct vor_request *request)
{
    const struct vor_principal *caller = &request->principal;

    return caller->sees_all ? NULL : caller->name;
}

static bool refuse(struct vor_request *request, const char *challenge, const char *detail)
{
    return vor_problem_reply(
        request, &VOR_PROBLEM("unauthorized", .detail = detail, .challenge = challenge));
}

static bool refuse_scope(struct vor_request *request, const struct vor_principal *caller,
                         enum vor_scope scope)
{
    char challenge[128], detail[192], scopes[64];
    size_t at = 0;

    /* The words of the scopes that a caller has, with blanks between. */
    scopes[0] = '\0';
    for (int i = VOR_SCOPE_OPEN + 1; i < VOR_SCOPES && at < sizeof scopes; i++)
        if (vor_principal_may(caller, (enum vor_scope)i))
            at += (size_t)snprintf(scopes + at, sizeof scopes - at, "%s%s", at > 0 ? " " : "",
                                   vor_scope_word((enum vor_scope)i));
    (void)snprintf(challenge, sizeof challenge,
                   REALM ", error=\"insufficient_scope\", scope=\"%s\"", vor_scope_word(scope));
    (void)snprintf(detail, sizeof detail,
                   "the key %s has the scopes %s, but this request also "
                   "needs the scope %s",
                   caller->name, scopes, vor_scope_word(scope));
    return vor_problem_reply(request,
                             &VOR_PROBLEM("forbidden", .detail = detail, .challenge = challenge));
}

/* True when the request is for a result and has a good ticket to it. */
static bool has_ticket(const struct vor_request *request, const char *ticket)
{
    const char *path = request->path, *job, *results, *output;
    size_t job_length = vor_path_segment(path, 2, &job);
    size_t results_length = vor_path_segment(path, 3, &results);
    size_t output_length = vor_path_segment(path, 4, &output);
    struct vor_uuid id;

    return results_length == strlen("results") && memcmp(results, "results", results_length) == 0 &&
           vor_uuid_parse(&id, job, job_length) &&
           vor_ticket_check(request->app->tickets, ticket, &id, output, output_length,
                            vor_tickets_now(request->app->tickets));
}

bool vor_auth_check(struct vor_request *request, enum vor_scope scope)
{
    static const char scheme[] = "bearer ";
    const char *value = vor_request_header(request, "Authorization"), *key = NULL;
    const char *ticket = vor_request_query(request, "ticket");
    struct vor_principal caller;

    if (request->app->keys == NULL || scope == VOR_SCOPE_OPEN) {
        request->principal = vor_principal_anybody;
        return true;
    }
    /* The key behind "Bearer" (RFC 6750, 2.1), whose letters may be of any case. */
    if (value != NULL && strncasecmp(value, scheme, sizeof scheme - 1) == 0)
        key = value + sizeof scheme - 1 + strspn(value + sizeof scheme - 1, " ");
    if (key == NULL)
        key = vor_request_header(request, "X-API-Key");
    if (key == NULL && ticket == NULL)
        return refuse(
            request, REALM,
            "the request has no key; send one as Authorization: Bearer KEY, or X-API-Key: KEY");
    if (key == NULL && !has_ticket(request, ticket))
        return refuse(request, REALM,
                      "the ticket has expired or is for another result; make a new one with POST "
                      "/v1/jobs/ID/tickets");
    caller = ticket_holder;
    if (key != NULL && !vor_keys_find(request->app->keys, key, &caller))
        return refuse(request, REALM ", error=\"invalid_token\"",
                      "this daemon does not know the key");
    request->principal = caller;
    return vor_principal_may(&caller, scope) || refuse_scope(request, &caller, scope);
}

struct vor_fairness_key vor_auth_fairness_key(const struct vor_request *request)
{
    const char *name = request->principal.name;

    return name[0] != '\0' ? vor_fairness_key_of_key(name)
                           : vor_fairness_key_of_address(request->via.client);
}
