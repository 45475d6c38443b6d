#include "server/api/links.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

static bool names_equal(const char *a, size_t length, const char *b)
{
    return strlen(b) == length && strncasecmp(a, b, length) == 0;
}

/* True when a host is this machine's, that of --public-url or one of --allowed-hosts. */
static bool host_is_ours(const struct vor_config *config, const char *host)
{
    size_t length = vor_host_name_length(host);
    const char *authority = strstr(config->text[VOR_SET_PUBLIC_URL], "://");

    if (names_equal(host, length, "localhost") || names_equal(host, length, "127.0.0.1") ||
        names_equal(host, length, "[::1]") || names_equal(host, length, config->endpoint.host) ||
        vor_config_list_has(config->text[VOR_SET_ALLOWED_HOSTS], host, length, strncasecmp))
        return true;
    if (authority == NULL)
        return false;
    authority += 3;
    if (authority[0] == '[')
        return length == vor_host_name_length(authority) &&
               strncasecmp(authority, host, length) == 0;
    return length == strcspn(authority, ":/") && strncasecmp(authority, host, length) == 0;
}

const char *vor_host_refused(const struct vor_request *request)
{
    const struct vor_config *config = request->app->config;
    const struct vor_via *via = &request->via;
    const char *host = vor_request_header(request, "Host");
    bool listed = config->text[VOR_SET_ALLOWED_HOSTS][0] != '\0';

    if (!config->endpoint.loopback && !listed)
        return NULL;
    if (via->host[0] != '\0') {
        if (!listed && config->text[VOR_SET_PUBLIC_URL][0] == '\0')
            return NULL;
        if (!host_is_ours(config, via->host))
            return via->host;
    }
    return host != NULL && !host_is_ours(config, host) ? host : NULL;
}

const char *vor_app_origin(const struct vor_request *request, char out[VOR_URL_MAX])
{
    const struct vor_via *via = &request->via;
    const char *host = vor_request_header(request, "Host");

    if (via->host[0] != '\0')
        host = via->host;
    if (host == NULL || !vor_host_is_sound(host) || vor_host_refused(request) != NULL)
        host = vor_http_address(request->app->http);
    if (strncmp(host, "unix:", 5) == 0)
        host = "localhost";
    (void)snprintf(out, VOR_URL_MAX, "%s://%s", via->scheme != NULL ? via->scheme : "http", host);
    return out;
}

const char *vor_app_url(const struct vor_request *request, const char *path, char out[VOR_URL_MAX])
{
    const char *base = request->app->config->text[VOR_SET_PUBLIC_URL];
    size_t length = strlen(base);

    while (length > 0 && base[length - 1] == '/')
        length--;
    if (length > 0) {
        (void)snprintf(out, VOR_URL_MAX, "%.*s%s", (int)length, base, path);
        return out;
    }
    length = strlen(vor_app_origin(request, out));
    (void)snprintf(out + length, VOR_URL_MAX - length, "%s%s", request->via.prefix, path);
    return out;
}

const char *vor_app_job_url(const struct vor_request *request, const struct vor_uuid *id,
                            const char *suffix, char out[VOR_URL_MAX])
{
    char path[128];

    (void)snprintf(path, sizeof path, "/v1/jobs/%s%s", id->text, suffix);
    return vor_app_url(request, path, out);
}

const char *vor_app_result_url(const struct vor_request *request, const struct vor_uuid *id,
                               const char *output, char out[VOR_URL_MAX])
{
    char suffix[64];

    (void)snprintf(suffix, sizeof suffix, "/results/%s", output);
    return vor_app_job_url(request, id, suffix, out);
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
