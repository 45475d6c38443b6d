/* Vectors and refusals: what the tables of small files in tests/data say
 * (tests/support/vt_files.h). A file that is refused has its status, what the message says, and the
 * place that the error points at. */
#include "proto/codec.h"
#include "proto/dump.h"
#include "tests/support/vt_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct vt_file *files;
static int file_count;

/* A process for each file would take longer than what it does. */
enum { PARTS = 16 };

static void each(void (*check)(const struct vt_file *file), int part)
{
    for (int i = part; i < file_count; i += PARTS)
        check(&files[i]);
}

/* Reads the first bytes of a file from a block of just their size, so that a sanitizer sees a read
 * behind it. The format is asked by what the file should be, not by what it begins with: a format
 * refuses what is not its own. */
static vor_status read_first(struct vor_cloud *out, const struct vt_file *file, size_t size,
                             struct vor_memory *memory, struct vor_error *err)
{
    const struct vor_format *format = vor_format(file->format);
    uint8_t *copy = malloc(size > 0 ? size : 1);
    vor_status status;

    ck_assert_ptr_nonnull(copy);
    memcpy(copy, file->bytes.data, size);
    vor_cloud_init(out, memory);
    status = file->limits.keep_faces ? vor_codec_read(out, NULL, copy, size, &file->limits, err)
                                     : format->read(out, copy, size, &file->limits, err);
    free(copy);
    return status;
}

static void assert_untouched(const struct vor_cloud *cloud)
{
    ck_assert_uint_eq(cloud->n, 0);
    ck_assert_uint_eq(cloud->attribute_count, 0);
    ck_assert_ptr_null(cloud->xyz);
    ck_assert_ptr_null(cloud->triangles);
    ck_assert_uint_eq(atomic_load(&cloud->memory->used), 0);
}

static int is_read(const struct vt_file *file)
{
    return strncmp(file->want, "float", 5) == 0;
}

static void check_refusal(const struct vt_file *file, vor_status status, struct vor_cloud *cloud)
{
    enum { PEAK_MAX = 128 * 1024 }; /* whatever a header of 80 bytes promises */
    char got[sizeof vt_err.message + 32];
    struct vor_memory memory;

    (void)snprintf(got, sizeof got, "%s: %s", vor_status_slug(status), vt_err.message);
    ck_assert_msg(strcmp(got, file->want) == 0, "%s | %s | is not | %s", file->name, got,
                  file->want);
    ck_assert_msg(vt_err.byte_offset == file->mark, "%s points at %lld, want %lld (%s)", file->name,
                  (long long)vt_err.byte_offset, (long long)file->mark, got);
    ck_assert_msg(strlen(vt_err.message) > 8, "%s: says nothing", file->name);
    for (const char *c = vt_err.message; *c != '\0'; c++)
        ck_assert_msg(*c >= 0x20 && *c < 0x7f, "%s: raw byte in the message", file->name);
    ck_assert_int_eq(vt_err.status, status);
    ck_assert_msg(status != VOR_E_LIMIT || vt_err.got > vt_err.limit, "%s: limit %llu, got %llu",
                  file->name, (unsigned long long)vt_err.limit, (unsigned long long)vt_err.got);
    ck_assert(status != VOR_E_FACES || strcmp(vt_err.parameter, "sample") == 0);
    assert_untouched(cloud);
    vor_memory_init(&memory, SIZE_MAX);
    ck_assert_int_eq(read_first(cloud, file, file->bytes.size, &memory, NULL), status);
    assert_untouched(cloud);
    ck_assert_msg(atomic_load(&memory.peak) <= PEAK_MAX, "%s takes %zu bytes", file->name,
                  atomic_load(&memory.peak));
}

VT_TEST_LOOP(a_file_is_read_as_it_says_or_refused_where_it_lies, file_count)
{
    const struct vt_file *file = &files[_i];
    struct vor_cloud cloud;
    vor_status status = read_first(&cloud, file, file->bytes.size, &vt_memory, &vt_err);

    if (!is_read(file)) {
        check_refusal(file, status, &cloud);
        return;
    }
    ck_assert_msg(status == VOR_OK, "%s: %s", file->name, vt_err.message);
    ck_assert_msg(strcmp(vt_cloud_words(&cloud), file->want) == 0, "%s | %s | is not | %s",
                  file->name, vt_cloud_words(&cloud), file->want);
    vor_cloud_free(&cloud);
}

/* Property: a file that ends early is refused; nothing past the end is read. Ascii may lose the end
 * of its last number, and what lies behind the vertices may go if it is not wanted. */
static void cut_everywhere(const struct vt_file *file)
{
    struct vor_cloud cloud;
    int ascii;

    if (!is_read(file) || file->bytes.size > 2000)
        return;
    ascii = strstr((const char *)file->bytes.data, " ascii") != NULL;
    for (size_t size = file->limits.keep_faces ? 4 : 0; size < file->bytes.size; size++) {
        vor_status status = read_first(&cloud, file, size, &vt_memory, &vt_err);

        if (status == VOR_OK) {
            size_t first = cloud.n > 1 ? strcspn(file->want, ",;") : 0;
            size_t same = ascii ? first : strlen(file->want);

            ck_assert_msg(cloud.n > 1 || !ascii || size + 20 > file->bytes.size, "%s", file->name);
            ck_assert_msg(strncmp(vt_cloud_words(&cloud), file->want, same) == 0,
                          "%zu bytes of %s: %s", size, file->name, vt_cloud_words(&cloud));
            vor_cloud_free(&cloud);
        } else {
            ck_assert_msg(status == VOR_E_FORMAT, "%zu bytes of %s: %s", size, file->name,
                          vt_err.message);
            ck_assert_int_le(vt_err.byte_offset, (int64_t)size);
            assert_untouched(&cloud);
        }
        vt_assert_no_leak();
    }
}

VT_TEST_LOOP(every_prefix_is_refused_or_means_the_same, PARTS)
{
    each(cut_everywhere, _i);
}

/* Property: any byte of any file may be anything; what comes is a cloud or a refusal. */
static void change_bytes(const struct vt_file *whole)
{
    struct vt_file file = *whole;
    uint64_t seed = (uint64_t)(whole - files);

    if (file.bytes.size == 0 || file.bytes.size > 2000)
        return;
    file.bytes.data = malloc(file.bytes.size);
    ck_assert_ptr_nonnull(file.bytes.data);
    for (size_t k = 0; k < 100; k++) {
        size_t at = (size_t)(vt_unit(seed, 4 * k) * (double)file.bytes.size);
        struct vor_cloud cloud;
        vor_status status;

        memcpy(file.bytes.data, whole->bytes.data, file.bytes.size);
        file.bytes.data[at] = (uint8_t)(256 * vt_unit(seed, 4 * k + 1));
        at = (size_t)(vt_unit(seed, 4 * k + 2) * (double)file.bytes.size);
        file.bytes.data[at] ^= (uint8_t)(1 << (k % 8));
        status = read_first(&cloud, &file, file.bytes.size, &vt_memory, &vt_err);
        ck_assert_msg(status == VOR_OK ? cloud.n > 0 : cloud.n == 0 && vt_err.message[0] != 0,
                      "%s, change %zu: %s", file.name, k, vor_status_slug(status));
        vor_cloud_free(&cloud);
    }
    free(file.bytes.data);
}

VT_TEST_LOOP(any_changed_byte_ends_in_a_cloud_or_a_refusal, PARTS)
{
    each(change_bytes, _i);
}

/* What a job keeps of its upload is the same, and is refused where it is cut or wrong. */
static void dump(const struct vt_file *file)
{
    struct vt_bytes dump = {0};
    const struct vor_sink sink = {&dump, vt_bytes_write};
    struct vor_cloud cloud;

    if (!is_read(file))
        return;
    vt_assert_ok(read_first(&cloud, file, file->bytes.size, &vt_memory, &vt_err));
    vt_assert_ok(vor_dump_write(&sink, &cloud, &vt_err));
    vor_cloud_free(&cloud);
    for (size_t size = 0; size < dump.size; size++)
        vt_assert_fails(VOR_E_FORMAT, vor_dump_read(&cloud, dump.data, size, &vt_err));
    vt_assert_ok(vor_dump_read(&cloud, dump.data, dump.size, &vt_err));
    ck_assert_str_eq(vt_cloud_words(&cloud), file->want);
    if (cloud.triangle_count > 0) { /* its last corner */
        dump.data[dump.size - 4] = (uint8_t)cloud.n;
        vor_cloud_free(&cloud);
        vt_assert_fails(VOR_E_FORMAT, vor_dump_read(&cloud, dump.data, dump.size, &vt_err));
    }
    vor_cloud_free(&cloud);
    free(dump.data);
}

VT_TEST_LOOP(a_dump_is_the_same, PARTS)
{
    each(dump, _i);
}

/* "Fail the N-th allocation" until none is left to fail; then the same with a cap, met anywhere. */
static void fail_allocations(const struct vt_file *file)
{
    vor_status status = VOR_E_NOMEM;
    struct vor_memory memory;
    struct vor_cloud cloud;

    if (!is_read(file))
        return;
    for (size_t k = 1; status == VOR_E_NOMEM; k++) {
        vor_memory_init(&memory, SIZE_MAX);
        memory.fail_at = k;
        status = read_first(&cloud, file, file->bytes.size, &memory, &vt_err);
        if (status == VOR_E_NOMEM)
            assert_untouched(&cloud);
        else
            ck_assert_uint_lt(atomic_load(&memory.calls), k);
        ck_assert_msg(k > 1 || status == VOR_E_NOMEM, "%s: %s", file->name, vt_err.message);
        vor_cloud_free(&cloud);
    }
    ck_assert_msg(status == VOR_OK, "%s: %s", file->name, vt_err.message);
    status = VOR_E_NOMEM;
    for (size_t cap = 0; status == VOR_E_NOMEM; cap += 509) {
        vor_memory_init(&memory, cap);
        status = read_first(&cloud, file, file->bytes.size, &memory, &vt_err);
        ck_assert_uint_le(atomic_load(&memory.peak), cap);
        vor_cloud_free(&cloud);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
    ck_assert_msg(status == VOR_OK, "%s: %s", file->name, vt_err.message);
}

VT_TEST_LOOP(any_allocation_may_fail, PARTS)
{
    each(fail_allocations, _i);
}

void vt_suite(Suite *suite VOR_UNUSED)
{
    static const char *const tables[] = {"tests/data/ply.txt", "tests/data/draco.txt"};

    files = vt_files(tables, 2, &file_count);
}
