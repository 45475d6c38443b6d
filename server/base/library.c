#include "server/base/library.h"

#include <dlfcn.h>
#include <pthread.h>
#include <string.h>

static vor_status load(struct vor_library *library, struct vor_error *err)
{
    void *handle = dlopen(library->file, RTLD_NOW | RTLD_LOCAL), *function;
    char *out = library->functions;

    if (handle == NULL)
        return vor_fail(err, VOR_E_IO, "%.160s; it is in Debian's package %s", dlerror(),
                        library->package);
    for (size_t i = 0; i < library->count; i++) {
        function = dlsym(handle, library->names[i]);
        if (function == NULL)
            return vor_fail(err, VOR_E_IO, "the library %s has no function %s", library->file,
                            library->names[i]);
        /* A function cannot be had from a pointer to an object but by copying its bytes. */
        memcpy(out + i * sizeof function, &function, sizeof function);
    }
    library->loaded = true;
    return VOR_OK;
}

vor_status vor_library_load(struct vor_library *library, struct vor_error *err)
{
    static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    vor_status status;

    pthread_mutex_lock(&mutex);
    status = library->loaded ? VOR_OK : load(library, err);
    pthread_mutex_unlock(&mutex);
    return status;
}
