#include "server/base/curl_library.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#define LIBRARY "libcurl-gnutls.so.4"

static struct vor_curl functions;
static char missing[256]; /* "": it is loaded */

static void load(void)
{
    void *library = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL), *function;

    if (library == NULL) {
        (void)snprintf(missing, sizeof missing, "%.160s; it is in Debian's package libcurl3-gnutls",
                       dlerror());
        return;
    }
    /* A function cannot be had from a pointer to an object but by copying its bytes. */
#define VOR_CURL_FIND(name)                                                                        \
    function = dlsym(library, "curl_" #name);                                                      \
    if (function == NULL)                                                                          \
        (void)snprintf(missing, sizeof missing, "the library %s has no function curl_%s", LIBRARY, \
                       #name);                                                                     \
    memcpy(&functions.name, &function, sizeof function);
    VOR_CURL_TABLE(VOR_CURL_FIND)
#undef VOR_CURL_FIND
    if (missing[0] == '\0' && functions.global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK)
        (void)snprintf(missing, sizeof missing, "%s cannot be started", LIBRARY);
}

vor_status vor_curl_load(const struct vor_curl **out, struct vor_error *err)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;

    (void)pthread_once(&once, load);
    if (missing[0] != '\0')
        return vor_fail(err, VOR_E_IO, "%s", missing);
    *out = &functions;
    return VOR_OK;
}
