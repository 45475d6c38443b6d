/* What every driver of blobs does, of a folder whose small blobs stand in the store; and where they
 * stand. */
#include "tests/support/vt_dir.h"
#define vt_dir_blobs vt_dir_small_blobs
#include "tests/unit/blob_any.c"

VT_TEST(what_takes_the_place_of_a_small_blob_is_found_wherever_it_stands)
{
    static const size_t sizes[] = {10, VOR_SMALL_FILE_MAX + 1, VOR_SMALL_FILE_MAX, PIECE, 0};
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_uuid id = vt_row(1).id;

    fill_bytes();
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        struct vor_blob_list list = {.entry = NULL};
        struct vor_blob_writer *writer = vt_upload(blobs, bytes, sizes[i] / 2);
        uint64_t size;
        int fd, found;

        vt_assert_ok(
            vor_blob_append(writer, bytes + sizes[i] / 2, sizes[i] - sizes[i] / 2, &vt_err));
        vt_assert_ok(vor_blob_commit(writer, &id, "cloud", &vt_err));
        ck_assert_int_eq(vt_dir_count(dir, "blobs/keep"), sizes[i] > VOR_SMALL_FILE_MAX);
        ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
        if (i % 2 == 1) { /* and after a restart */
            vor_blobs_close(blobs);
            blobs = vt_dir_blobs(dir);
        }
        ck_assert_uint_eq(vor_blobs_bytes(blobs), sizes[i]);
        vt_assert_ok(vor_blob_get(blobs, &id, "cloud", &fd, &size, &found, &vt_err));
        ck_assert(found && size == sizes[i]);
        ck_assert_int_eq(pread(fd, back, sizeof back, 0), (ssize_t)size);
        ck_assert_mem_eq(back, bytes, size);
        close(fd);
        vt_assert_ok(vor_blobs_list(blobs, &list, &vt_err));
        ck_assert_uint_eq(list.count, 1);
        free(list.entry);
    }
    vt_assert_ok(vor_blob_drop(blobs, &id, "cloud", &vt_err));
    ck_assert_str_eq(vt_blob_text(blobs, &id, "cloud"), "");
    ck_assert_uint_eq(vor_blobs_bytes(blobs), 0);
    vor_blobs_close(blobs);
}

VT_TEST(a_store_with_small_files_is_refused_where_blobs_are_elsewhere)
{
    const char *dir = vt_dir_make();
    struct vor_blobs elsewhere = {.driver = &vor_blob_s3};
    struct vor_uuid id = vt_row(1).id;
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    const struct vor_small_files *small = blobs->small;

    vt_blob_put(blobs, &id, "cloud", "bytes");
    vt_assert_fails(VOR_E_IO, vor_blobs_keep_small(&elsewhere, small, &vt_err));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "voronoid migrate"));
    vt_assert_ok(vor_blob_drop(blobs, &id, "cloud", &vt_err));
    vt_assert_ok(vor_blobs_keep_small(&elsewhere, small, &vt_err));
    ck_assert_ptr_null(elsewhere.small);
    vor_blobs_close(blobs);
}
