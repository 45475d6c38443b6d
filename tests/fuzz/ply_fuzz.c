/* Any bytes as a PLY file, or else as a dump, under a capped allocator: a checked cloud or a clean
 * error, nothing left behind; what was read is written and read again as the same.
 *
 * Build with -fsanitize=fuzzer,address,undefined; -dict=tests/fuzz/ply.dict helps. */
#include "proto/codec.h"
#include "proto/dump.h"
#include "tests/fuzz/fuzz.h"

enum { CAP = 64 << 20 };

struct collected {
    uint8_t *data;
    size_t size, capacity;
};

static int collect(void *ctx, const void *bytes, size_t size)
{
    struct collected *to = ctx;

    if (size > to->capacity - to->size) {
        to->capacity = 2 * (to->size + size);
        to->data = realloc(to->data, to->capacity);
        if (to->data == NULL)
            abort();
    }
    memcpy(to->data + to->size, bytes, size);
    to->size += size;
    return 0;
}

static int is_ply(const uint8_t *bytes, size_t size)
{
    return vor_format_sniff(bytes, size) == vor_format(VOR_FORMAT_PLY);
}

static vor_status read_any(struct vor_cloud *cloud, const uint8_t *bytes, size_t size,
                           size_t header_bytes, int keep_faces, struct vor_error *err)
{
    const struct vor_limits limits = {.points = 1000000,
                                      .header_bytes = header_bytes,
                                      .keep_faces = keep_faces,
                                      .keep_doubles = keep_faces};

    return is_ply(bytes, size) ? vor_codec_read(cloud, NULL, bytes, size, &limits, err)
                               : vor_dump_read(cloud, bytes, size, err);
}

static void check_refusal(const struct vor_cloud *cloud, vor_status status,
                          const struct vor_error *err, size_t size)
{
    require(status == VOR_E_FORMAT || status == VOR_E_EMPTY || status == VOR_E_NONFINITE ||
                status == VOR_E_LIMIT || status == VOR_E_NOMEM || status == VOR_E_FACES,
            "a status that a reader does not have");
    require(err->status == status && err->message[0] != '\0', "a failure without a message");
    require(err->byte_offset <= (int64_t)size, "an offset behind the file");
    require(cloud->n == 0 && cloud->xyz == NULL && cloud->attribute_count == 0 &&
                cloud->triangles == NULL,
            "a cloud from a failure");
}

static void require_same(const struct vor_cloud *a, const struct vor_cloud *b, int positions,
                         int long_integers)
{
    require(a->n == b->n && a->attribute_count == b->attribute_count, "another number of things");
    require(!positions || memcmp(a->xyz, b->xyz, 12 * a->n) == 0, "other positions");
    require(!positions || (a->exact == NULL) == (b->exact == NULL), "doubles of one");
    require(!positions || a->exact == NULL || memcmp(a->exact, b->exact, 24 * a->n) == 0,
            "other doubles");
    require(a->notes.remarks_size == b->notes.remarks_size &&
                (a->notes.remarks_size == 0 ||
                 memcmp(a->notes.remarks, b->notes.remarks, a->notes.remarks_size) == 0),
            "other remarks");
    for (size_t i = 0; i < a->attribute_count; i++) {
        const struct vor_attribute *p = &a->attributes[i], *q = &b->attributes[i];

        if (!long_integers && (p->type == VOR_INT64 || p->type == VOR_UINT64))
            continue;
        require(p->type == q->type && p->components == q->components && p->semantic == q->semantic,
                "another attribute");
        require(memcmp(p->data, q->data, a->n * p->components * vor_type_size(p->type)) == 0,
                "other values");
    }
}

static void require_same_faces(const struct vor_cloud *a, const struct vor_cloud *b)
{
    require(a->notes.faces == b->notes.faces && a->triangle_count == b->triangle_count &&
                (a->triangle_count == 0 ||
                 memcmp(a->triangles, b->triangles, 12 * a->triangle_count) == 0),
            "other faces");
    for (size_t i = 0; i < 3 * a->triangle_count; i++)
        require(a->triangles[i] < a->n, "a corner that is no point");
}

static void dump_again(const struct vor_cloud *cloud, struct vor_memory *memory)
{
    struct collected dump = {NULL, 0, 0};
    const struct vor_sink sink = {&dump, collect};
    struct vor_cloud back;
    struct vor_error err;

    vor_cloud_init(&back, memory);
    require(vor_dump_write(&sink, cloud, &err) == VOR_OK, "no dump");
    if (vor_dump_read(&back, dump.data, dump.size, &err) == VOR_OK) {
        require_same(cloud, &back, 1, 1);
        require_same_faces(cloud, &back);
    } else {
        require(err.status == VOR_E_NOMEM, "the dump is refused");
    }
    vor_cloud_free(&back);
    free(dump.data);
}

/* Doubles may lie where the grid of the second reading is coarser: see vor_cloud_set_double. A
 * cloud from a dump may hold what PLY cannot, so it only has to end cleanly. */
static void ply_again(const struct vor_cloud *cloud, struct vor_memory *memory, int from_ply)
{
    struct collected ply = {NULL, 0, 0};
    const struct vor_sink sink = {&ply, collect};
    struct vor_cloud back;
    struct vor_error err;
    vor_status status = vor_format(VOR_FORMAT_PLY)->write(&sink, cloud, NULL, &err);

    vor_cloud_init(&back, memory);
    if (status == VOR_OK)
        status = read_any(&back, ply.data, ply.size, 1 << 20, 0, &err);
    if (status == VOR_OK && from_ply)
        require_same(cloud, &back, cloud->position_type == VOR_FLOAT32, 0);
    require(status == VOR_OK || status == VOR_E_NOMEM || !from_ply, "what we write is refused");
    vor_cloud_free(&back);
    free(ply.data);
}

static void try(const uint8_t *bytes, size_t size, int keep_faces)
{
    struct vor_memory memory;
    struct vor_cloud cloud;
    struct vor_error err;
    vor_status status;

    vor_memory_init(&memory, CAP);
    vor_cloud_init(&cloud, &memory);
    status = read_any(&cloud, bytes, size, 65536, keep_faces, &err);
    if (status == VOR_OK) {
        dump_again(&cloud, &memory);
        ply_again(&cloud, &memory, is_ply(bytes, size));
    } else {
        check_refusal(&cloud, status, &err, size);
    }
    vor_cloud_free(&cloud);
    require(atomic_load(&memory.used) == 0, "memory is left");
    require(atomic_load(&memory.peak) <= CAP, "more memory than the cap");
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    try(bytes, size, 0);
    if (is_ply(bytes, size))
        try(bytes, size, 1);
    return 0;
}
