#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"

#include <string.h>

static void put_link(struct vor_request *request, struct vor_text *text, const char *rel,
                     const char *type, const char *path)
{
    char url[VOR_URL_MAX];
    struct vor_link link = {rel, type, NULL, vor_app_url(request, path, url), -1};

    vor_json_link(text, &link);
}

enum vor_next vor_handle_landing(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    static const char json[] = "application/json";
    struct vor_text text;

    vor_document_begin(&text);
    vor_json_put_string(&text, "title", "voronoid");
    vor_json_put_string(&text, "description", "Resamples point clouds");
    vor_json_put_array(&text, "links");
    put_link(request, &text, "self", json, "/v1/");
    put_link(request, &text, "service-desc", "application/vnd.oai.openapi;version=3.0",
             "/openapi.yaml");
    put_link(request, &text, "service-desc", "application/vnd.oai.openapi+json;version=3.0",
             "/openapi.json");
    put_link(request, &text, "service-doc", "text/html", "/docs");
    put_link(request, &text, "http://www.opengis.net/def/rel/ogc/1.0/processes", json,
             "/v1/processes");
    put_link(request, &text, "http://www.opengis.net/def/rel/ogc/1.0/job-list", json, "/v1/jobs");
    put_link(request, &text, "status", json, "/readyz");
    vor_json_end_array(&text);
    return vor_document_reply(request, &text);
}

enum vor_next vor_handle_livez(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    static const char alive[] = "{\"status\":\"alive\"}\n";

    vor_reply_header(request, "Cache-Control", "no-store");
    vor_reply_bytes(request, 200, "application/json", alive, strlen(alive));
    return VOR_NEXT_REPLY;
}

enum vor_next vor_handle_readyz(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    struct vor_app *app = request->app;
    struct vor_job_service_load load;
    struct vor_error err;
    struct vor_text text;

    if (atomic_load(&app->leaving) || atomic_load(&app->draining))
        return vor_problem_say(request, "draining", "the daemon is shutting down");
    if (vor_job_service_ready(app->service, &err) != VOR_OK) /* 503, also when the disk is full */
        return vor_problem_say(request, "store-unavailable", "%s", err.message);
    vor_job_service_load(app->service, &load);
    vor_document_begin(&text);
    vor_json_put_string(&text, "status", "ready");
    vor_json_put_u64(&text, "waiting", load.waiting);
    vor_json_put_u64(&text, "running", load.running);
    vor_json_put_string(&text, "sandbox", app->sandbox);
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_document_reply(request, &text);
}

enum vor_next vor_handle_version(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    struct vor_text text;

    vor_document_begin(&text);
    vor_json_put_string(&text, "name", "voronoid");
    vor_json_put_string(&text, "version", VOR_VERSION);
    return vor_document_reply(request, &text);
}
