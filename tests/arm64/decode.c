/* usage: decode FILE: what this machine reads from a cloud, as hexadecimal floats, which lose no
 * bit. The first line is the origin; then a line a point: its three coordinates from there, and
 * every value of its attributes. */
#include "tests/support/read_cloud.h"

#include <stdint.h>
#include <stdio.h>

static void print_point(const struct vor_cloud *cloud, size_t i)
{
    const float *x = &cloud->xyz[3 * i];

    (void)printf("%a %a %a", (double)x[0], (double)x[1], (double)x[2]);
    for (size_t a = 0; a < cloud->attribute_count; a++) {
        const struct vor_attribute *attribute = &cloud->attributes[a];

        for (unsigned c = 0; c < attribute->components; c++)
            (void)printf(" %a", vor_attribute_scalar(attribute, i * attribute->components + c));
    }
    (void)putchar('\n');
}

int main(int argc, char **argv)
{
    struct vor_memory memory;
    struct vor_cloud cloud;
    struct vor_error err;
    vor_status status;

    if (argc != 2)
        return 2;
    vor_memory_init(&memory, SIZE_MAX);
    vor_cloud_init(&cloud, &memory);
    status = read_cloud(&cloud, argv[1], &err);
    if (status == VOR_OK) {
        (void)printf("%a %a %a\n", cloud.origin[0], cloud.origin[1], cloud.origin[2]);
        for (size_t i = 0; i < cloud.n; i++)
            print_point(&cloud, i);
    } else {
        (void)fprintf(stderr, "%s\n", err.message);
    }
    vor_cloud_free(&cloud);
    return status != VOR_OK;
}
