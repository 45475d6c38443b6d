/* Any bytes as a tar archive: in one piece, byte by byte and in pieces that its own bytes choose,
 * it comes to the same files with the same data, or to the same refusal at the same byte. The seal
 * of a header is mended first where it says "fuzz", so that what lies behind it is reached. */
#include "proto/tar.h"
#include "tests/fuzz/fuzz.h"

struct told {
    uint64_t hash, data, size;
    unsigned files, in_file;
};

static vor_status on_file(void *ctx, const char *path, uint64_t size, struct vor_error *err)
{
    struct told *told = ctx;
    size_t length = strlen(path);

    (void)err;
    require(!told->in_file, "a file begins in a file");
    require(length >= 1 && length <= VOR_TAR_NAME_MAX, "a name is empty or too long");
    told->in_file = 1;
    told->files++;
    told->size = size;
    fuzz_mix(&told->hash, path, length + 1);
    return VOR_OK;
}

static vor_status on_data(void *ctx, const void *bytes, size_t size, struct vor_error *err)
{
    struct told *told = ctx;

    (void)err;
    require(told->in_file && size > 0 && size <= told->size, "data outside of a file, or none");
    told->data += size;
    told->size -= size;
    fuzz_mix(&told->hash, bytes, size);
    return VOR_OK;
}

static vor_status on_end(void *ctx, struct vor_error *err)
{
    struct told *told = ctx;

    (void)err;
    require(told->in_file && told->size == 0, "an end without a file, or too early");
    told->in_file = 0;
    return VOR_OK;
}

static vor_status scan(struct told *told, const uint8_t *bytes, size_t size, size_t piece,
                       struct vor_error *err)
{
    const struct vor_tar_events events = {told, on_file, on_data, on_end};
    struct vor_tar scanner;
    vor_status status = VOR_OK;

    *told = (struct told){.hash = FUZZ_HASH};
    memset(err, 0, sizeof *err);
    vor_tar_begin(&scanner, &events);
    for (size_t at = 0; at < size && status == VOR_OK;) {
        size_t next = piece;
        uint8_t *copy = fuzz_piece(bytes + at, size - at, 64, &next);

        status = vor_tar_feed(&scanner, copy, next, err);
        free(copy);
        at += next;
    }
    return status == VOR_OK ? vor_tar_finish(&scanner, err) : status;
}

static void seal(uint8_t *header)
{
    unsigned sum = 0;

    if (memcmp(header + 148, "fuzz", 4) != 0)
        return;
    memset(header + 148, ' ', 8);
    for (size_t i = 0; i < VOR_TAR_BLOCK; i++)
        sum += header[i];
    (void)snprintf((char *)header + 148, 8, "%06o", sum);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    uint8_t *copy = (uint8_t *)fuzz_text(bytes, size);
    const size_t pieces[] = {1, 0};
    struct told whole, told;
    struct vor_error first, err;
    vor_status status;

    for (size_t at = 0; at + VOR_TAR_BLOCK <= size; at += VOR_TAR_BLOCK)
        seal(copy + at);
    status = scan(&whole, copy, size, size + 1, &first);
    require(status == VOR_OK || status == VOR_E_REQUEST, "a status that a scanner does not have");
    require(status == VOR_OK || first.message[0] != '\0', "a refusal that says nothing");
    require(status != VOR_OK || !whole.in_file, "an archive is whole, a file of it is not");
    for (size_t i = 0; i < 2; i++) {
        require(scan(&told, copy, size, pieces[i], &err) == status, "another answer");
        require(err.byte_offset == first.byte_offset && strcmp(err.message, first.message) == 0,
                "another refusal");
        require(told.files == whole.files && told.in_file == whole.in_file, "other files");
        require(told.data == whole.data && told.hash == whole.hash, "other data");
    }
    free(copy);
    return 0;
}
