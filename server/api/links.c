#include "server/api/links.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

bool vor_host_is_sound(const char *host)
{
    size_t length = strlen(host);

    return length > 0 && length <= 255 &&
           strspn(host, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._:[]") ==
               length;
}

/* Length of the name in "name:port" or "[address]:port". */
static size_t host_length(const char *host)
{
    return host[0] == '[' ? strcspn(host, "]") + (strchr(host, ']') != NULL) : strcspn(host, ":");
}

static bool names_equal(const char *a, size_t length, const char *b)
{
    return strlen(b) == length && strncasecmp(a, b, length) == 0;
}

bool vor_host_is_ours(const struct vor_app *app, const char *host)
{
    size_t length = host_length(host);
    const char *public_url = app->config->text[VOR_SET_PUBLIC_URL];
    const char *authority = strstr(public_url, "://");

    if (!app->config->loopback)
        return true;
    if (names_equal(host, length, "localhost") || names_equal(host, length, "127.0.0.1") ||
        names_equal(host, length, "[::1]") || names_equal(host, length, app->config->host))
        return true;
    if (authority == NULL)
        return false;
    authority += 3;
    return length == strcspn(authority, ":/") && strncasecmp(authority, host, length) == 0;
}

const char *vor_app_url(const struct vor_app *app, const struct vor_request *request,
                        const char *path, char out[VOR_URL_MAX])
{
    const char *base = app->config->text[VOR_SET_PUBLIC_URL];
    const char *host = vor_request_header(request, "Host");
    bool usable = host != NULL && vor_host_is_sound(host) && vor_host_is_ours(app, host);
    size_t length = strlen(base);

    while (length > 0 && base[length - 1] == '/')
        length--;
    if (length > 0)
        (void)snprintf(out, VOR_URL_MAX, "%.*s%s", (int)length, base, path);
    else
        (void)snprintf(out, VOR_URL_MAX, "http://%s%s", usable ? host : vor_http_address(app->http),
                       path);
    return out;
}

const char *vor_app_job_url(const struct vor_app *app, const struct vor_request *request,
                            const struct vor_uuid *id, const char *suffix, char out[VOR_URL_MAX])
{
    char path[128];

    (void)snprintf(path, sizeof path, "/v1/jobs/%s%s", id->text, suffix);
    return vor_app_url(app, request, path, out);
}

const char *vor_app_result_url(const struct vor_app *app, const struct vor_request *request,
                               const struct vor_uuid *id, const char *output, char out[VOR_URL_MAX])
{
    char suffix[64];

    (void)snprintf(suffix, sizeof suffix, "/results/%s", output);
    return vor_app_job_url(app, request, id, suffix, out);
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
