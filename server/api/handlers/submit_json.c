#include "server/api/handlers/submission.h"

#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"

#include <string.h>

enum {
    FOUND_MAX = 8,      /* parameters that are named */
    POINTER_SIZE = 128, /* of the place of one, with the NUL; longer ones are cut */
    DETAIL_SIZE = 160   /* of the sentence of one */
};

/* --- what is in it ---------------------------------------------------------------------------- */

struct found {
    const struct vor_process_info *process;
    unsigned count;
    struct place {
        const char *name;
        char pointer[POINTER_SIZE], detail[DETAIL_SIZE];
    } place[FOUND_MAX];
    struct vor_problem_error errors[FOUND_MAX];
    struct vor_text query; /* "points=1000&seed=2" */
};

static void add(struct found *found, const char *pointer, const struct vor_json *member)
{
    const char *name = vor_json_name(member);
    struct place *place = &found->place[found->count];
    static const char plain[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~,:";
    const char *string;
    enum vor_json_kind kind;

    place->name = name;
    (void)snprintf(place->pointer, sizeof place->pointer, "%s/%s", pointer, name);
    (void)snprintf(place->detail, sizeof place->detail,
                   "%s is in a JSON body, want it in the query or in a field of a form", name);
    found->errors[found->count++] =
        (struct vor_problem_error){.pointer = place->pointer, .detail = place->detail};
    vor_text_printf(&found->query, "%s%s=", found->count > 1 ? "&" : "", name);
    /* A value as it stands in a query; "..." for one that is none, or needs escapes. */
    string = vor_json_get_string(member);
    kind = vor_json_kind(member);
    if (string != NULL && strlen(string) < 64 && strspn(string, plain) == strlen(string))
        vor_text_puts(&found->query, string);
    else if (kind == VOR_JSON_NUMBER || kind == VOR_JSON_BOOL)
        vor_json_copy(&found->query, member);
    else
        vor_text_puts(&found->query, "...");
}

/* Looks for parameters among the members of an object and of those below it: OGC has them under
 * "inputs", others put them at the top. A member that is one is not looked into; the value of an
 * input may be an object with members of any name, so none below `depth` counts. */
static void look_into(struct found *found, const struct vor_json *object, const char *pointer,
                      int depth)
{
    for (const struct vor_json *m = vor_json_first(object); m != NULL; m = vor_json_next(m)) {
        const char *name = vor_json_name(m);
        enum vor_parameter parameter = vor_parameter_find(name);
        char below[POINTER_SIZE];

        if (found->count == FOUND_MAX)
            return;
        if (parameter != VOR_PARAMETER_COUNT && vor_process_takes(found->process, parameter)) {
            add(found, pointer, m);
        } else if (depth > 0 && vor_json_kind(m) == VOR_JSON_OBJECT && strlen(name) < 32) {
            (void)snprintf(below, sizeof below, "%s/%s", pointer, name);
            look_into(found, m, below, depth - 1);
        }
    }
}

/* --- the answer ------------------------------------------------------------------------------- */

void vor_submit_json_refuse(struct vor_request *request, const struct vor_process_info *process,
                            const struct vor_text *body)
{
    struct found found = {.process = process};
    struct vor_json *json = NULL;
    struct vor_error err;
    char detail[1024];

    if (vor_text_status(body, &err) != VOR_OK ||
        vor_json_parse(&json, body->data != NULL ? body->data : "", body->size, &err) != VOR_OK) {
        vor_problem_error(request, &err, NULL);
        return;
    }
    vor_text_init(&found.query, 0);
    if (vor_json_kind(json) == VOR_JSON_OBJECT)
        look_into(&found, json, "", 1);
    if (found.count > 0) {
        (void)snprintf(detail, sizeof detail,
                       "%s is in a JSON body, at %s; parameters belong in the query, with the "
                       "cloud as the body: POST /v1/%s?%s; or in fields of a form "
                       "(multipart/form-data), with the cloud as its file",
                       found.place[0].name, found.place[0].pointer, process->id,
                       found.query.data != NULL ? found.query.data : "...");
        vor_problem_reply(request,
                          &VOR_PROBLEM("invalid-parameter", .detail = detail,
                                       .errors = found.errors, .error_count = found.count));
    } else {
        vor_problem_say(request, "unsupported-format",
                        "the body is JSON, want a cloud, or a form (multipart/form-data) with one; "
                        "parameters belong in the query, as in /v1/%s?seed=1",
                        process->id);
    }
    vor_text_free(&found.query);
    vor_json_free(json);
}
