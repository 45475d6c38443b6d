/* Refusals: the limits of a PLY header (RELIABILITY T4), each met and each passed by one. */
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ASCII "ply\nformat ascii 1.0\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define ONE "element vertex 1\n" XYZ
#define END "end_header\n"

static const struct vor_limits limits = {.points = 1000, .header_bytes = 65536};

/* A file that is put together piece by piece. */
static void add(struct vt_bytes *bytes, const char *text)
{
    ck_assert_int_eq(vt_bytes_write(bytes, text, strlen(text)), 0);
}

static void add_many(struct vt_bytes *bytes, char c, size_t count)
{
    for (size_t i = 0; i < count; i++)
        ck_assert_int_eq(vt_bytes_write(bytes, &c, 1), 0);
}

static vor_status read_bytes(struct vt_bytes *bytes, struct vor_cloud *cloud)
{
    vor_status status;

    vor_cloud_init(cloud, &vt_memory);
    status = vor_ply_read(cloud, bytes->data, bytes->size, &limits, &vt_err);
    free(bytes->data);
    memset(bytes, 0, sizeof *bytes);
    return status;
}

START_TEST(a_line_of_1024_bytes_is_read_and_one_more_is_not)
{
    static const char *const ends[] = {"\n", "\r\n"};

    for (size_t length = 1023; length <= 1027; length++)
        for (int e = 0; e < 2; e++) {
            struct vt_bytes bytes = {0};
            struct vor_cloud cloud;

            add(&bytes, ASCII "comment");
            add_many(&bytes, ' ', length - 7);
            add(&bytes, ends[e]);
            add(&bytes, ONE END "0 0 0\n");
            if (length <= 1024) {
                vt_assert_ok(read_bytes(&bytes, &cloud));
                vor_cloud_free(&cloud);
                continue;
            }
            vt_assert_fails(VOR_E_FORMAT, read_bytes(&bytes, &cloud));
            ck_assert_int_eq(vt_err.byte_offset, sizeof(ASCII) - 1);
        }
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_comment_line_of_a_megabyte_is_refused)
{
    struct vt_bytes bytes = {0};
    struct vor_cloud cloud;

    add(&bytes, ASCII "comment ");
    add_many(&bytes, 'c', 1 << 20);
    add(&bytes, "\n" ONE END "0 0 0\n");
    vt_assert_fails(VOR_E_FORMAT, read_bytes(&bytes, &cloud));
    ck_assert_int_eq(vt_err.byte_offset, sizeof(ASCII) - 1);
}
END_TEST

static size_t header_of_size(struct vt_bytes *bytes, size_t size)
{
    static const char tail[] = ONE END;

    add(bytes, ASCII);
    while (bytes->size + sizeof tail - 1 < size) {
        size_t left = size - bytes->size - (sizeof tail - 1);
        size_t line = left > 600 ? 500 : left;

        add(bytes, "comment ");
        add_many(bytes, 'c', line - 9);
        add(bytes, "\n");
    }
    add(bytes, tail);
    return bytes->size;
}

START_TEST(a_header_of_64_kib_is_read_and_one_more_byte_is_not)
{
    struct vt_bytes bytes = {0};
    struct vor_cloud cloud;

    ck_assert_uint_eq(header_of_size(&bytes, 65536), 65536);
    add(&bytes, "0 0 0\n");
    vt_assert_ok(read_bytes(&bytes, &cloud));
    vor_cloud_free(&cloud);
    ck_assert_uint_eq(header_of_size(&bytes, 65537), 65537);
    add(&bytes, "0 0 0\n");
    vt_assert_fails(VOR_E_FORMAT, read_bytes(&bytes, &cloud));
    ck_assert_int_eq(vt_err.byte_offset, 65536);
}
END_TEST

static void with_properties(struct vt_bytes *bytes, unsigned count)
{
    char line[64];

    add(bytes, ASCII ONE);
    for (unsigned i = 3; i < count; i++) {
        (void)snprintf(line, sizeof line, "property uchar a%u\n", i);
        add(bytes, line);
    }
    add(bytes, END);
    for (unsigned i = 0; i < count; i++)
        add(bytes, "1 ");
}

START_TEST(an_element_has_64_properties_and_not_65)
{
    struct vt_bytes bytes = {0};
    struct vor_cloud cloud;

    with_properties(&bytes, 64);
    vt_assert_ok(read_bytes(&bytes, &cloud));
    ck_assert_uint_eq(cloud.attribute_count, 61);
    vor_cloud_free(&cloud);
    with_properties(&bytes, 65);
    vt_assert_fails(VOR_E_FORMAT, read_bytes(&bytes, &cloud));
}
END_TEST

static void with_elements(struct vt_bytes *bytes, unsigned count)
{
    char line[64];

    add(bytes, ASCII);
    for (unsigned i = 1; i < count; i++) {
        (void)snprintf(line, sizeof line, "element e%u 0\nproperty int a\n", i);
        add(bytes, line);
    }
    add(bytes, ONE END "0 0 0");
}

START_TEST(a_file_has_16_elements_and_not_17)
{
    struct vt_bytes bytes = {0};
    struct vor_cloud cloud;

    with_elements(&bytes, 16);
    vt_assert_ok(read_bytes(&bytes, &cloud));
    vor_cloud_free(&cloud);
    with_elements(&bytes, 17);
    vt_assert_fails(VOR_E_FORMAT, read_bytes(&bytes, &cloud));
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("ply_limits");

    vt_add(suite, a_line_of_1024_bytes_is_read_and_one_more_is_not);
    vt_add(suite, a_comment_line_of_a_megabyte_is_refused);
    vt_add(suite, a_header_of_64_kib_is_read_and_one_more_byte_is_not);
    vt_add(suite, an_element_has_64_properties_and_not_65);
    vt_add(suite, a_file_has_16_elements_and_not_17);
    return vt_run(suite);
}
