/** A cloud read from a file, for programs that run without the harness of the tests. */
#ifndef VOR_TESTS_READ_CLOUD_H
#define VOR_TESTS_READ_CLOUD_H

#include "proto/codec.h"

#include <stdint.h>
#include <stdio.h>

/** Reads a whole file into an initialised cloud.
 *
 *  @retval VOR_E_IO  it cannot be read; else as vor_codec_read */
static inline vor_status read_cloud(struct vor_cloud *cloud, const char *path,
                                    struct vor_error *err)
{
    struct vor_limits limits = VOR_LIMITS_DEFAULT;
    FILE *in = fopen(path, "rb");
    uint8_t *bytes = NULL;
    long size = -1;
    vor_status status;

    if (in != NULL && fseek(in, 0, SEEK_END) == 0 && (size = ftell(in)) > 0)
        bytes = vor_malloc(cloud->memory, (size_t)size, 1);
    if (bytes == NULL || fseek(in, 0, SEEK_SET) != 0 ||
        fread(bytes, 1, (size_t)size, in) != (size_t)size)
        status = vor_fail(err, VOR_E_IO, "%s cannot be read", path);
    else
        status = vor_codec_read(cloud, NULL, bytes, (size_t)size, &limits, err);
    vor_free(cloud->memory, bytes);
    if (in != NULL)
        (void)fclose(in);
    return status;
}

#endif
