#define _GNU_SOURCE /* memfd_create */
#include "server/work/encode.h"

#include "proto/dump.h"
#include "server/base/disk.h"

#include <errno.h>
#include <sys/mman.h>
#include <unistd.h>

/* A sink of codecs that writes to a descriptor. */
static int put(void *ctx, const void *bytes, size_t size)
{
    const char *at = bytes;

    while (size > 0) {
        ssize_t wrote = write(*(int *)ctx, at, size);

        if (wrote < 0 && errno != EINTR)
            return -1;
        at += wrote > 0 ? wrote : 0;
        size -= wrote > 0 ? (size_t)wrote : 0;
    }
    return 0;
}

static size_t triangle_bytes(const struct vor_mesh *mesh)
{
    return mesh != NULL ? mesh->count * 3 * sizeof *mesh->triangle : 0;
}

/* A file in memory with triangles and cloud, as VOR_CODEC_ENCODE reads it. */
static vor_status make_file(int *out, const struct vor_cloud *cloud, const struct vor_mesh *mesh,
                            struct vor_error *err)
{
    int fd = memfd_create("result", MFD_CLOEXEC);
    const struct vor_sink sink = {.ctx = &fd, .write = put};

    if (fd < 0)
        return vor_fail_errno(err, errno, "memory to share with a child process");
    if ((triangle_bytes(mesh) > 0 && put(&fd, mesh->triangle, triangle_bytes(mesh)) != 0) ||
        vor_dump_write(&sink, cloud, NULL) != VOR_OK) {
        (void)close(fd);
        return vor_fail(err, VOR_E_NOMEM, "a copy of the result's %zu points", cloud->n);
    }
    *out = fd;
    return VOR_OK;
}

/* Has a child write what is in the file, with what memory is left. */
static vor_status write_file(const struct vor_sink *sink, const struct vor_codec_place *place,
                             struct vor_codec_order *order, int fd, struct vor_memory *memory,
                             struct vor_error *err)
{
    static const size_t MEMORY_MOST = (size_t)1 << 46; /* of an address space */
    size_t left = memory->cap - atomic_load(&memory->used);
    struct vor_codec_facts facts;
    vor_status status;

    order->memory = left < MEMORY_MOST ? left : MEMORY_MOST;
    order->most = order->memory;
    status = vor_codec_run(&facts, place, order, fd, sink, err);
    /* The peak of the memory tells what the child took besides. */
    if (status == VOR_OK && vor_memory_charge(memory, facts.memory))
        vor_memory_release(memory, facts.memory);
    return status;
}

vor_status vor_encode(const struct vor_sink *sink, const struct vor_codec_place *place,
                      const struct vor_cloud *cloud, unsigned format,
                      const struct vor_write_options *options, struct vor_error *err)
{
    const struct vor_mesh *mesh = options->mesh;
    size_t size = triangle_bytes(mesh);
    struct vor_codec_order order = {.op = VOR_CODEC_ENCODE, .format = format, .options = *options};
    vor_status status;
    int fd = -1;

    if (place->zygote == NULL || !vor_format(format)->is_fragile)
        return vor_format(format)->write(sink, cloud, options, err);
    order.triangles = mesh != NULL ? mesh->count : 0;
    order.polygons = mesh != NULL && mesh->polygons;
    order.options.mesh = NULL;
    size += (size_t)vor_dump_size(cloud);
    order.size = size;
    if (!vor_memory_charge(cloud->memory, size))
        return vor_fail(err, VOR_E_NOMEM, "a copy of the result's %zu points", cloud->n);
    status = make_file(&fd, cloud, mesh, err);
    if (status == VOR_OK) {
        status = write_file(sink, place, &order, fd, cloud->memory, err);
        (void)close(fd);
    }
    vor_memory_release(cloud->memory, size);
    return status;
}
