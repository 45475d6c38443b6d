#include "server/store/postgres_library.h"

#include <dlfcn.h>
#include <pthread.h>
#include <string.h>

#define LIBRARY "libpq.so.5"

static struct vor_pg functions;
static const char *missing; /* NULL: it is loaded */

static void load(void)
{
    void *library = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL), *function;

    missing = library == NULL ? LIBRARY : NULL;
    if (library == NULL)
        return;
        /* A function cannot be had from a pointer to an object but by copying its bytes. */
#define VOR_PG_FIND(name, result, parameters)                                                      \
    function = dlsym(library, "PQ" #name);                                                         \
    if (function == NULL)                                                                          \
        missing = "PQ" #name;                                                                      \
    memcpy(&functions.name, &function, sizeof function);
    VOR_PG_TABLE(VOR_PG_FIND)
#undef VOR_PG_FIND
}

vor_status vor_pg_load(const struct vor_pg **out, struct vor_error *err)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;

    (void)pthread_once(&once, load);
    if (missing != NULL)
        return vor_fail(err, VOR_E_IO,
                        "a store in PostgreSQL needs libpq (Debian: libpq5), but %s cannot be "
                        "loaded",
                        missing);
    *out = &functions;
    return VOR_OK;
}
