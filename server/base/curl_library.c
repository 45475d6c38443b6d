#include "server/base/curl_library.h"

#include "server/base/library.h"

#include <pthread.h>

static struct vor_curl functions;
static const char *const names[] = {
#define VOR_CURL_NAME(name) "curl_" #name,
    VOR_CURL_TABLE(VOR_CURL_NAME)
#undef VOR_CURL_NAME
};
static struct vor_library library = {"libcurl-gnutls.so.4",          "libcurl3-gnutls", names,
                                     sizeof names / sizeof names[0], &functions,        false};
static CURLcode started;

static void start(void)
{
    started = functions.global_init(CURL_GLOBAL_DEFAULT);
}

vor_status vor_curl_load(const struct vor_curl **out, struct vor_error *err)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    vor_status status = vor_library_load(&library, err);

    if (status != VOR_OK)
        return status;
    (void)pthread_once(&once, start);
    if (started != CURLE_OK)
        return vor_fail(err, VOR_E_IO, "%s cannot be started", library.file);
    *out = &functions;
    return VOR_OK;
}

void vor_curl_begin(CURL *handle, const char *url, char why[CURL_ERROR_SIZE])
{
    why[0] = '\0';
    functions.easy_reset(handle);
    functions.easy_setopt(handle, CURLOPT_URL, url);
    functions.easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
    functions.easy_setopt(handle, CURLOPT_USERAGENT, "voronoid/" VOR_VERSION);
    functions.easy_setopt(handle, CURLOPT_ERRORBUFFER, why);
    functions.easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
    functions.easy_setopt(handle, CURLOPT_CONNECTTIMEOUT, 10L);
    functions.easy_setopt(handle, CURLOPT_NOPROGRESS, 0L);
}

int vor_curl_add(struct curl_slist **list, const char *header)
{
    struct curl_slist *longer = functions.slist_append(*list, header);

    if (longer != NULL)
        *list = longer;
    return longer != NULL;
}

const char *vor_curl_header(CURL *handle, const char *name)
{
    struct curl_header *header;

    return functions.easy_header(handle, name, 0, CURLH_HEADER, -1, &header) == CURLHE_OK
               ? header->value
               : "";
}
