#include "tests/support/vt_data.h"

#include "proto/codec.h"
#include "tests/support/vt.h"

#include <stdlib.h>

int vt_cloud_open(struct vor_cloud *cloud, const char *name)
{
    static const struct vor_limits limits = VOR_LIMITS_DEFAULT;
    const char *path = vt_data_or_skip(name);
    uint8_t *bytes;
    size_t size;

    if (path == NULL)
        return 0;
    bytes = vt_slurp(path, &size);
    ck_assert_ptr_nonnull(bytes);
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_codec_read(cloud, NULL, bytes, size, &limits, &vt_err));
    free(bytes);
    return 1;
}
