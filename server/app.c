#include "server/app.h"

#include "server/problem.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

const char *vor_app_url(const struct vor_app *app, const struct vor_request *request,
                        const char *path, char out[VOR_URL_MAX])
{
    const char *base = app->config->text[VOR_SET_PUBLIC_URL];
    const char *host = vor_request_header(request, "Host");
    size_t length = strlen(base);

    while (length > 0 && base[length - 1] == '/')
        length--;
    if (length > 0)
        (void)snprintf(out, VOR_URL_MAX, "%.*s%s", (int)length, base, path);
    else
        (void)snprintf(out, VOR_URL_MAX, "http://%s%s",
                       host != NULL ? host : vor_http_address(app->http), path);
    return out;
}

const char *vor_app_job_url(const struct vor_app *app, const struct vor_request *request,
                            const struct vor_uuid *id, const char *suffix, char out[VOR_URL_MAX])
{
    char path[128];

    (void)snprintf(path, sizeof path, "/v1/jobs/%s%s", id->text, suffix);
    return vor_app_url(app, request, path, out);
}

size_t vor_path_segment(const char *path, unsigned index, const char **out)
{
    for (;;) {
        size_t length;

        if (*path != '/')
            break;
        path++;
        length = strcspn(path, "/");
        if (index-- == 0) {
            *out = path;
            return length;
        }
        path += length;
    }
    *out = "";
    return 0;
}

enum vor_next vor_app_reply(struct vor_app *app, struct vor_request *request, int http,
                            const char *media_type, struct vor_text *text)
{
    struct vor_error err;

    if (vor_text_status(text, &err) != VOR_OK)
        vor_problem_error(app, request, &err, NULL);
    else
        vor_reply_bytes(request, http, media_type, text->data, text->size);
    vor_text_free(text);
    return VOR_NEXT_REPLY;
}

bool vor_accepts(const struct vor_request *request, const char *media_type, bool absent)
{
    unsigned index = 0;
    const char *value = vor_request_header_next(request, "Accept", &index);
    size_t want = strlen(media_type);

    if (value == NULL)
        return absent;
    for (; value != NULL; value = vor_request_header_next(request, "Accept", &index)) {
        while (*value != '\0') {
            value += strspn(value, ", \t");
            if (strncasecmp(value, media_type, want) == 0 && strchr(",; \t", value[want]) != NULL)
                return true;
            value += strcspn(value, ",");
        }
    }
    return false;
}
