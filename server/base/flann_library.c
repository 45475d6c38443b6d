#include "server/base/flann_library.h"

#include "server/base/library.h"

#include <flann/flann.h>

static struct {
    __typeof__(&flann_build_index_float) build;
    __typeof__(&flann_find_nearest_neighbors_index_float) search;
    __typeof__(&flann_free_index_float) release;
} functions;

vor_status vor_flann_load(struct vor_error *err)
{
    static const char *const names[] = {"flann_build_index_float",
                                        "flann_find_nearest_neighbors_index_float",
                                        "flann_free_index_float"};
    static struct vor_library library = {"libflann.so.1.9", "libflann1.9", names, 3,
                                         &functions,        false};

    return vor_library_load(&library, err);
}

flann_index_t flann_build_index_float(float *dataset, int rows, int cols, float *speedup,
                                      struct FLANNParameters *parameters)
{
    struct vor_error err;

    return vor_flann_load(&err) == VOR_OK
               ? functions.build(dataset, rows, cols, speedup, parameters)
               : NULL;
}

int flann_find_nearest_neighbors_index_float(flann_index_t index, float *queries, int rows,
                                             int *indices, float *distances, int k,
                                             struct FLANNParameters *parameters)
{
    return functions.search(index, queries, rows, indices, distances, k, parameters);
}

int flann_free_index_float(flann_index_t index, struct FLANNParameters *parameters)
{
    return functions.release(index, parameters);
}
