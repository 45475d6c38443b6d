/* What stops a Draco file that the gate has let pass, or a writer that meets its cap. What the gate
 * refuses stands in tests/data/draco.txt (unit/codec_files). */
#include "proto/draco/draco_meter.h"
#include "proto/draco/draco_precheck.h"
#include "tests/support/vt_files.h"
#include "tests/unit/draco_files.h"

static struct vt_file *files;
static int file_count;

static struct vt_bytes *find(const char *name)
{
    for (int i = 0; i < file_count; i++)
        if (strcmp(files[i].name, name) == 0)
            return &files[i].bytes;
    ck_abort_msg("no file %s", name);
}

/* Regression: 43 bytes that declare 200 points made the library ask for 3 GB. The gate refuses
 * them; this goes round the gate. */
VT_TEST(the_meter_alone_stops_what_the_gate_would_have_stopped)
{
    static const struct {
        const char *name;
        size_t at;
        int is_mesh;
    } bombs[] = {{"old kd-tree without data", 24, 0},
                 {"old integers without data", 24, 0},
                 {"lossless", 11, 0},
                 {"a mesh where it is strict", 12, 1},
                 {"a mesh where it is strict", 13, 1}};

    for (size_t k = 0; k < sizeof bombs / sizeof *bombs; k++) {
        const struct vt_bytes *base = find(bombs[k].name);
        struct vor_memory memory;
        struct vor_alloc_budget budget = {.memory = &memory, .most = (size_t)64 << 20};
        struct vor_draco_meter meter = vor_alloc_budget_meter(&budget);
        struct vor_draco_decoded *decoded;
        enum vor_draco_result result;
        size_t size = base->size;
        char message[96];

        vor_memory_init(&memory, SIZE_MAX);
        memcpy(base->data + bombs[k].at, "\377\377\377\377\17", bombs[k].is_mesh ? 5 : 4);
        base->data[bombs[k].at + 3] &= bombs[k].is_mesh ? 0xff : 0x0f;
        result = vor_draco_decode(&decoded, &meter, base->data, &size, message);
        ck_assert_msg(result == VOR_DRACO_NO_MEMORY || result == VOR_DRACO_REFUSED, "bomb %zu", k);
        ck_assert_msg(bombs[k].is_mesh || result == VOR_DRACO_NO_MEMORY, "bomb %zu was no bomb: %s",
                      k, message);
        ck_assert_ptr_null(decoded);
        ck_assert_uint_le(atomic_load(&memory.peak), budget.most);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
}

/* 63 attributes of 16 equal integers: 800 MB out of a few kilobytes, all of it declared honestly.
 */
VT_TEST(a_small_file_that_unpacks_to_a_large_cloud_meets_its_budget)
{
    struct vor_cloud cloud, back;
    struct vor_memory memory;
    struct vt_bytes bytes;

    vt_cloud_cube(&cloud, 1, 20000);
    for (int i = 0; i < 63; i++)
        (void)draco_add(&cloud, "zero", VOR_GENERIC, VOR_INT32, 16);
    vt_assert_ok(draco_encode(&bytes, &cloud, 1, 1));
    vor_cloud_free(&cloud);
    ck_assert_uint_lt(bytes.size, 20000);
    vor_memory_init(&memory, (size_t)1 << 40);
    vor_cloud_init(&back, &memory);
    vt_assert_fails(VOR_E_NOMEM,
                    vor_draco_read(&back, bytes.data, bytes.size, &draco_limits, &vt_err));
    ck_assert_uint_le(atomic_load(&memory.peak), (64 << 20) + 40 * (100000 + 64 * bytes.size));
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    free(bytes.data);
}

/* Property: wherever the cap lies, the writer succeeds or says so, nothing stays booked, and it
 * hands nothing to the sink unless all is well. */
VT_TEST(any_cap_on_the_writer_ends_cleanly)
{
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 200);
    for (int k = 0; k < 2; k++) {
        size_t before = atomic_load(&vt_memory.used), failures = 0;
        vor_status status = VOR_E_NOMEM;

        for (size_t more = 0; status == VOR_E_NOMEM && more < 1 << 20; more += 211) {
            struct vt_bytes bytes;

            vt_memory.cap = before + more;
            status = draco_encode(&bytes, &cloud, -1, k);
            ck_assert(status == VOR_OK ? bytes.size > 0 : bytes.data == NULL);
            ck_assert_uint_eq(atomic_load(&vt_memory.used), before);
            failures += status == VOR_E_NOMEM;
            free(bytes.data);
        }
        vt_memory.cap = SIZE_MAX;
        ck_assert_int_eq(status, VOR_OK);
        ck_assert_uint_gt(failures, 20);
    }
    vor_cloud_free(&cloud);
}

struct writing {
    const struct vor_cloud *cloud;
    int keep_order;
};

static vor_status write_once(void *ctx)
{
    const struct writing *writing = ctx;
    struct vt_bytes bytes;
    vor_status status = draco_encode(&bytes, writing->cloud, -1, writing->keep_order);

    ck_assert(status == VOR_OK ? bytes.size > 0 : bytes.data == NULL);
    free(bytes.data);
    return status;
}

VT_TEST_LOOP(any_allocation_of_the_writer_may_fail, 2)
{
    struct vor_cloud cloud;
    struct writing writing = {&cloud, _i};

    vt_cloud_cube(&cloud, 1, 100);
    (void)draco_add(&cloud, "color", VOR_COLOR, VOR_UINT8, 3);
    ((int32_t *)draco_add(&cloud, "wide", VOR_GENERIC, VOR_INT32, 1))[3] = INT32_MIN;
    vt_fail_each(write_once, &writing);
    vor_cloud_free(&cloud);
}

void vt_suite(Suite *suite VOR_UNUSED)
{
    static const char *const table = "tests/data/draco.txt";

    files = vt_files(&table, 1, &file_count);
}
