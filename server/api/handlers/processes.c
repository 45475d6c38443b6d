#include "core/base/quote.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"

#include <stdio.h>
#include <string.h>

enum { PROCESS_LINKS = 3, PROCESS_PATH_MAX = 128 };

/* Room for the links of one process. */
struct process_links {
    char urls[PROCESS_LINKS][VOR_URL_MAX];
    struct vor_link links[PROCESS_LINKS];
};

static void make_links(struct vor_request *request, const char *id, struct process_links *out)
{
    static const char *const rels[PROCESS_LINKS] = {
        "self", "http://www.opengis.net/def/rel/ogc/1.0/execute", "up"};
    char paths[PROCESS_LINKS][PROCESS_PATH_MAX];

    (void)snprintf(paths[0], PROCESS_PATH_MAX, "/v1/processes/%s", id);
    (void)snprintf(paths[1], PROCESS_PATH_MAX, "/v1/processes/%s/execution", id);
    (void)snprintf(paths[2], PROCESS_PATH_MAX, "/v1/processes");
    for (int i = 0; i < PROCESS_LINKS; i++)
        out->links[i] = (struct vor_link){rels[i], "application/json", NULL,
                                          vor_app_url(request, paths[i], out->urls[i]), -1};
}

enum vor_next vor_handle_processes(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    char url[VOR_URL_MAX];
    struct vor_link self = {"self", "application/json", NULL,
                            vor_app_url(request, "/v1/processes", url), -1};
    const struct vor_process_info *process;
    struct process_links links = {0};
    struct vor_text text;

    vor_document_begin(&text);
    vor_json_put_array(&text, "processes");
    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++) {
        if (!process->on_http)
            continue;
        make_links(request, process->id, &links);
        vor_json_process_summary(&text, process, links.links, PROCESS_LINKS);
    }
    vor_json_end_array(&text);
    vor_json_key(&text, "links");
    vor_json_links(&text, &self, 1);
    return vor_document_reply(request, &text);
}

/* The process that segment `index` of the path names; NULL after a problem has been replied. */
static const struct vor_process_info *find_process(struct vor_request *request, unsigned index)
{
    const struct vor_process_info *process;
    const char *segment;
    size_t length = vor_path_segment(request->path, index, &segment);

    for (unsigned i = 0; (process = vor_process_info(i)) != NULL; i++)
        if (process->on_http && strlen(process->id) == length &&
            memcmp(process->id, segment, length) == 0)
            return process;
    vor_problem_say(request, "no-such-process", "there is no process %s; /v1/processes lists them",
                    VOR_QUOTED(64, segment, length));
    return NULL;
}

const struct vor_process_info *vor_process_of_submit(struct vor_request *request)
{
    const char *segment;
    size_t length = vor_path_segment(request->path, 1, &segment);
    bool is_long = length == strlen("processes") && strncmp(segment, "processes", length) == 0;

    return find_process(request, is_long ? 2 : 1);
}

enum vor_next vor_handle_process(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    const struct vor_process_info *process = find_process(request, 2);
    struct process_links links = {0};
    struct vor_text text;

    if (process == NULL)
        return VOR_NEXT_REPLY;
    make_links(request, process->id, &links);
    vor_text_init(&text, 0);
    vor_json_process(&text, process, links.links, PROCESS_LINKS);
    return vor_reply_json(request, 200, &text);
}
