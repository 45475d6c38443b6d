/* Whatever the bytes, vor_draco_read ends with a checked cloud or a clean error, inside its cap and
 * with nothing left behind; the corners of its faces are points; and what it reads, vor_draco_write
 * can write.
 *
 * Build with -fsanitize=fuzzer,address,undefined; the Draco library itself is not instrumented. */
#include "proto/draco/draco.h"

#include <assert.h>

static int swallow(void *ctx, const void *bytes, size_t size)
{
    (void)ctx;
    return bytes == NULL || size == 0 ? -1 : 0;
}

/* Large clouds take the encoder long and teach nothing new. */
static void write_back(const struct vor_cloud *cloud, const struct vor_mesh *mesh, unsigned salt)
{
    struct vor_write_options options = {.quantization_bits = (int)(salt % 32) - 1,
                                        .compression = (int)(salt % 11),
                                        .keep_order = (int)(salt & 1),
                                        .mesh = mesh};
    struct vor_sink sink = {.ctx = NULL, .write = swallow};
    struct vor_error err;
    vor_status status;

    if (cloud->n > 2000 || mesh->count > 4000)
        return;
    status = vor_draco_write(&sink, cloud, &options, &err);
    assert(status == VOR_OK || status == VOR_E_NOMEM);
}

static void try(const uint8_t *bytes, size_t size, int keep_faces)
{
    unsigned salt = size > 0 ? bytes[size - 1] : 0;
    struct vor_limits limits = VOR_LIMITS_DEFAULT;
    struct vor_memory memory;
    struct vor_cloud cloud;
    struct vor_mesh mesh;
    struct vor_error err;
    vor_status status;

    limits.keep_faces = keep_faces && (salt & 2) != 0 ? VOR_FACES_KEPT : keep_faces;
    limits.keep_doubles = keep_faces;
    vor_memory_init(&memory, (size_t)256 << 20);
    vor_cloud_init(&cloud, &memory);
    status = vor_draco_read(&cloud, bytes, size, &limits, &err);
    if (status == VOR_OK) {
        assert(cloud.n > 0 && vor_cloud_check(&cloud, &err) == VOR_OK);
        assert(keep_faces || cloud.triangles == NULL);
        for (size_t i = 0; i < 3 * cloud.triangle_count; i++)
            assert(cloud.triangles[i] < cloud.n);
        mesh = (struct vor_mesh){NULL, cloud.triangles, cloud.triangle_count, cloud.polygons};
        write_back(&cloud, &mesh, salt);
    } else {
        assert(err.status == status && cloud.n == 0 && cloud.attribute_count == 0);
        assert(cloud.triangles == NULL);
        assert(status == VOR_E_FORMAT || status == VOR_E_EMPTY || status == VOR_E_LIMIT ||
               status == VOR_E_NOMEM || status == VOR_E_NONFINITE);
    }
    vor_cloud_free(&cloud);
    assert(atomic_load(&memory.used) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    try(bytes, size, 0);
    try(bytes, size, 1);
    return 0;
}
