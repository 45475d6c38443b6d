/** libcurl, loaded when somebody is to be asked over HTTP: the client commands, and blobs in S3. It
 *  and what it needs are half of the libraries that a program would start with. The only door to
 * the library. Thread-safe. */
#ifndef VOR_SERVER_BASE_CURL_LIBRARY_H
#define VOR_SERVER_BASE_CURL_LIBRARY_H

#include "core/base/status.h"

#include <curl/curl.h>

#define VOR_CURL_TABLE(X)                                                                          \
    X(easy_cleanup)                                                                                \
    X(easy_escape)                                                                                 \
    X(easy_getinfo)                                                                                \
    X(easy_header)                                                                                 \
    X(easy_init)                                                                                   \
    X(easy_perform)                                                                                \
    X(easy_reset)                                                                                  \
    X(easy_setopt)                                                                                 \
    X(easy_strerror)                                                                               \
    X(free)                                                                                        \
    X(global_init)                                                                                 \
    X(mime_addpart)                                                                                \
    X(mime_data_cb)                                                                                \
    X(mime_filename)                                                                               \
    X(mime_free)                                                                                   \
    X(mime_init)                                                                                   \
    X(mime_name)                                                                                   \
    X(slist_append)                                                                                \
    X(slist_free_all)                                                                              \
    X(url)                                                                                         \
    X(url_cleanup)                                                                                 \
    X(url_get)                                                                                     \
    X(url_set)

/** Its functions without their prefix, as in curl->easy_init(). */
struct vor_curl {
#define VOR_CURL_MEMBER(name) __typeof__(&curl_##name) name;
    VOR_CURL_TABLE(VOR_CURL_MEMBER)
#undef VOR_CURL_MEMBER
};

/** Loads the library and prepares it, once; *out is never freed.
 *
 *  @retval VOR_E_IO it is not installed, or lacks a function */
VOR_NODISCARD vor_status vor_curl_load(const struct vor_curl **out, struct vor_error *err);

/** Begins a request over HTTP on a handle that may have had others before; why is where the reason
 *  of a failure goes. A connection is waited for up to 10 s. */
void vor_curl_begin(CURL *handle, const char *url, char why[CURL_ERROR_SIZE]);

/** Adds a header to a list; false when memory is out. */
int vor_curl_add(struct curl_slist **list, const char *header);

/** The header of that name of the answer, "" for none. */
const char *vor_curl_header(CURL *handle, const char *name);

#endif
