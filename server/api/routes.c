#include "server/api/route_table.h"

#include "server/api/auth.h"
#include "server/api/links.h"
#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/metrics.h"

#include <math.h>
#include <string.h>

static const struct vor_route routes[] = {
#define ROUTE_ROW(method, path, scope, handler, codes)                                             \
    {VOR_##method, path, VOR_SCOPE_##scope, handler, codes},
    VOR_ROUTE_TABLE(ROUTE_ROW)
#undef ROUTE_ROW
/* The column says 1 or 0: picks the row, or nothing. */
#define OFFERED_1(name)                                                                            \
    {VOR_POST, "/v1/" #name, VOR_SCOPE_SUBMIT, vor_handle_submit, VOR_CODES_SUBMIT},
#define OFFERED_0(name)
#define PROCESS_ROUTE(id, name, http, groups, methods, least, most, inputs, outputs, title, text)  \
    OFFERED_##http(name)
        VOR_PROCESS_TABLE(PROCESS_ROUTE)
#undef PROCESS_ROUTE
#undef OFFERED_0
#undef OFFERED_1
};

enum { ROUTE_COUNT = sizeof routes / sizeof routes[0] };

static const char *const method_words[VOR_METHOD_COUNT] = {"GET", "HEAD", "POST", "DELETE",
                                                           "OPTIONS"};

void vor_routes_print(FILE *out)
{
    for (int i = 0; i < ROUTE_COUNT; i++)
        (void)fprintf(out, "%s %s %s %s\n", method_words[routes[i].method], routes[i].path,
                      vor_scope_word(routes[i].scope), routes[i].codes);
}

static bool path_matches(const char *pattern, const char *path)
{
    while (*pattern != '\0') {
        if (*pattern == '{') {
            size_t length = strcspn(path, "/");

            if (length == 0)
                return false;
            path += length;
            pattern += strcspn(pattern, "}") + 1;
        } else if (*pattern++ != *path++) {
            return false;
        }
    }
    return *path == '\0';
}

static bool origin_is_ours(const struct vor_request *request, const char *origin)
{
    const char *public_url = request->app->config->text[VOR_SET_PUBLIC_URL];
    size_t length = strlen(origin);
    char own[VOR_URL_MAX];

    if (vor_config_list_has(request->app->config->text[VOR_SET_CORS_ORIGIN], origin, length,
                            strncmp))
        return true;
    if (strncmp(public_url, origin, length) == 0 && strstr(origin, "://") != NULL &&
        (public_url[length] == '/' || public_url[length] == '\0'))
        return true;
    return strcmp(origin, vor_app_origin(request, own)) == 0;
}

static void add_cors(struct vor_request *request)
{
    const char *list = request->app->config->text[VOR_SET_CORS_ORIGIN];
    const char *origin = vor_request_header(request, "Origin");

    if (list[0] == '\0')
        return;
    vor_reply_header(request, "Vary", "Origin");
    if (origin == NULL || !vor_config_list_has(list, origin, strlen(origin), strncmp))
        return;
    vor_reply_header(request, "Access-Control-Allow-Origin", origin);
    vor_reply_header(request, "Access-Control-Expose-Headers",
                     "Location, ETag, Retry-After, Content-Range, Accept-Ranges, "
                     "Content-Disposition, Preference-Applied, Voronoid-Origin, X-Request-Id, "
                     "Idempotent-Replayed, RateLimit, RateLimit-Policy, WWW-Authenticate");
    if (request->method != VOR_OPTIONS)
        return;
    vor_reply_header(request, "Access-Control-Allow-Headers",
                     "Accept, Authorization, Content-Encoding, Content-Type, Idempotency-Key, "
                     "If-None-Match, If-Range, Last-Event-ID, Prefer, Range, traceparent, "
                     "tracestate, X-API-Key, X-Request-Id");
    vor_reply_header(request, "Access-Control-Max-Age", "600");
}

/* A form needs no leave of CORS, and a page may send one without an Origin; but no page can unsay
 * this header. Pages of --cors-origin may, and any page may have a link that somebody follows. */
static bool is_from_other_site(const struct vor_request *request)
{
    const char *site = vor_request_header(request, "Sec-Fetch-Site");
    const char *mode = vor_request_header(request, "Sec-Fetch-Mode");
    const char *origin = vor_request_header(request, "Origin");
    enum vor_method method = request->method;

    if (site == NULL || strcmp(site, "cross-site") != 0)
        return false;
    if (mode != NULL && strcmp(mode, "navigate") == 0 && (method == VOR_GET || method == VOR_HEAD))
        return false;
    return origin == NULL || !vor_config_list_has(request->app->config->text[VOR_SET_CORS_ORIGIN],
                                                  origin, strlen(origin), strncmp);
}

/* True when the request may come from where it comes; else it is answered. */
static bool check_source(struct vor_request *request)
{
    const char *host = vor_request_header(request, "Host");
    const char *origin = vor_request_header(request, "Origin");
    const char *refused = vor_host_refused(request);

    if (host != NULL && !vor_host_is_sound(host))
        vor_problem_say(request, "malformed-request", "Host is not NAME or NAME:PORT");
    else if (refused != NULL)
        vor_problem_say(request, "forbidden",
                        "Host is %.100s, want localhost, 127.0.0.1, [::1], the host of "
                        "--public-url or one of --allowed-hosts",
                        refused);
    else if (origin != NULL && !origin_is_ours(request, origin))
        vor_problem_say(request, "forbidden",
                        "Origin is %.100s, want one of --cors-origin or the origin of this "
                        "daemon",
                        origin);
    else if (is_from_other_site(request))
        vor_problem_say(
            request, "forbidden",
            "Sec-Fetch-Site is cross-site, and the page's origin is not in --cors-origin");
    else
        return true;
    return false;
}

static enum vor_next reply_no_route(struct vor_request *request)
{
    const char *path = request->path;
    char methods[64];
    size_t at = 0;

    /* "GET, HEAD, OPTIONS": what a path answers; "" when there is nothing at it. */
    methods[0] = '\0';
    for (int i = 0; i < ROUTE_COUNT; i++)
        if (path_matches(routes[i].path, path) && at < (sizeof methods))
            at += (size_t)snprintf(methods + at, (sizeof methods) - at, "%s%s, ",
                                   method_words[routes[i].method],
                                   routes[i].method == VOR_GET ? ", HEAD" : "");
    if (at > 0 && at < (sizeof methods))
        (void)snprintf(methods + at, (sizeof methods) - at, "OPTIONS");
    if (methods[0] == '\0')
        return vor_problem_say(request, "no-such-resource", "there is nothing at %.200s", path);
    if (request->method == VOR_OPTIONS) {
        vor_reply_header(request, "Allow", methods);
        vor_reply_header(request, "Access-Control-Allow-Methods", methods);
        vor_reply_bytes(request, 204, NULL, "", 0);
        return VOR_NEXT_REPLY;
    }
    return vor_problem_reply(
        request, &VOR_PROBLEM("method-not-allowed", .allow = methods,
                              .detail = "the Allow header lists the methods of this resource"));
}

enum vor_next vor_route_dispatch(struct vor_request *request, enum vor_step step)
{
    const struct vor_route *route = request->route;
    const enum vor_method method = request->method == VOR_HEAD ? VOR_GET : request->method;
    unsigned most;
    int i = 0;

    if (step != VOR_STEP_HEAD)
        return route->handler(request, step);
    if (!check_source(request))
        return VOR_NEXT_REPLY;
    add_cors(request);
    while (i < ROUTE_COUNT &&
           (routes[i].method != method || !path_matches(routes[i].path, request->path)))
        i++;
    if (i == ROUTE_COUNT)
        return reply_no_route(request);
    request->route = route = &routes[i];
    if (!vor_auth_check(request, route->scope))
        return VOR_NEXT_REPLY;
    most = strncmp(route->path, "/v1", 3) == 0 ? vor_request_excess(request) : 0;
    if (most > 0) {
        request->reply.close = true;
        return vor_problem_say(request, "too-many-connections",
                               "more than %u connections are open, in total or from this "
                               "client",
                               most);
    }
    return route->handler(request, step);
}

void vor_route_refuse(struct vor_request *request, const struct vor_refusal *refusal)
{
    vor_problem_reply(request, &VOR_PROBLEM(refusal->slug, .detail = refusal->detail,
                                            .limit = refusal->limit, .got = refusal->got));
}

void vor_route_done(const struct vor_request *request)
{
    const struct vor_route *route = request->route;
    const char *job = request->job;
    enum vor_method method = request->method;
    const char *word = method < VOR_METHOD_COUNT ? method_words[method] : "other";
    const char *tenant = request->principal.name;
    const char *path = route != NULL ? route->path : "none";
    int status = request->reply.http;
    char code[8];

    if (vor_request_gone(request) || status == 0)
        status = 499;
    /* For /metrics the paths of strangers are all one. */
    (void)snprintf(code, sizeof code, "%d", status);
    vor_metric_add(VOR_METRIC_HTTP_REQUESTS, 1, VOR_LABELS(path, word, code));
    vor_metric_observe(VOR_METRIC_HTTP_SECONDS, vor_clock_seconds() - request->began,
                       VOR_LABELS(path));
    vor_metric_add(VOR_METRIC_HTTP_BYTES_IN, (double)request->received, NULL);
    vor_metric_add(VOR_METRIC_HTTP_BYTES_OUT, (double)vor_request_bytes_out(request), NULL);
    if (request->problem != NULL)
        vor_metric_add(VOR_METRIC_REJECTED, 1, VOR_LABELS(request->problem));
    vor_log(VOR_LOG_INFO, "request", VOR_TEXT("request_id", request->id), VOR_TEXT("method", word),
            VOR_TEXT("route", route != NULL ? route->path : ""), VOR_TEXT("path", request->path),
            VOR_TEXT("client", request->via.client),
            VOR_TEXT("tenant", tenant[0] != '\0' ? tenant : NULL),
            VOR_TEXT("job", job[0] != '\0' ? job : NULL),
            VOR_KNOWN("trace_id", request->span.trace), VOR_KNOWN("span_id", request->span.id),
            VOR_COUNT("status", status), VOR_TEXT("problem", request->problem),
            VOR_REAL("dur_s", round((vor_clock_seconds() - request->began) * 1e6) / 1e6),
            VOR_COUNT("bytes_in", request->received),
            VOR_COUNT("bytes", vor_request_bytes_out(request)));
}
