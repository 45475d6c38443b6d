/* Any bytes as a form: the first line is its Content-Type, the rest the body. In one piece, byte by
 * byte and in pieces that its own bytes choose, it comes to the same parts with the same data, or
 * to the same refusal at the same byte; events come in their order, and limits hold. */
#include "proto/multipart.h"
#include "tests/fuzz/fuzz.h"

struct told {
    uint64_t hash, data;
    unsigned parts, in_part;
};

static vor_status on_part(void *ctx, const struct vor_multipart_part *part, struct vor_error *err)
{
    struct told *told = ctx;
    size_t length = strlen(part->name);

    (void)err;
    require(!told->in_part, "a part begins in a part");
    require(length >= 1 && length <= VOR_MULTIPART_NAME_MAX, "a name is empty or too long");
    for (size_t i = 0; i < length; i++)
        require((unsigned char)part->name[i] >= 0x20 || part->name[i] == '\t',
                "a name has a control character");
    require(part->is_file || !part->is_unnamed, "no file, and that without a name");
    told->in_part = 1;
    require(++told->parts <= VOR_MULTIPART_PARTS_MAX, "too many parts");
    fuzz_mix(&told->hash, part->name, length + 1);
    fuzz_mix(&told->hash, part->coding, strlen(part->coding) + 1);
    fuzz_mix(&told->hash, &part->is_file, sizeof part->is_file);
    return VOR_OK;
}

static vor_status on_data(void *ctx, const void *bytes, size_t size, struct vor_error *err)
{
    struct told *told = ctx;

    (void)err;
    require(told->in_part && size > 0, "data outside of a part, or none");
    told->data += size;
    fuzz_mix(&told->hash, bytes, size);
    return VOR_OK;
}

static vor_status on_end(void *ctx, struct vor_error *err)
{
    struct told *told = ctx;

    (void)err;
    require(told->in_part, "an end without a part");
    told->in_part = 0;
    fuzz_mix(&told->hash, "|", 1);
    return VOR_OK;
}

/* Scans in pieces of `piece` bytes; 0: of as many as the body's own bytes say. */
static vor_status scan(struct told *told, const char *type, const uint8_t *body, size_t size,
                       size_t piece, struct vor_error *err)
{
    const struct vor_multipart_events events = {told, on_part, on_data, on_end};
    struct vor_multipart scanner;
    vor_status status;

    *told = (struct told){.hash = FUZZ_HASH};
    memset(err, 0, sizeof *err);
    status = vor_multipart_begin(&scanner, type, &events, err);
    for (size_t at = 0; at < size && status == VOR_OK;) {
        size_t next = piece;
        uint8_t *copy = fuzz_piece(body + at, size - at, 16, &next);

        status = vor_multipart_feed(&scanner, copy, next, err);
        free(copy);
        at += next;
    }
    return status == VOR_OK ? vor_multipart_finish(&scanner, err) : status;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const uint8_t *line = size > 0 ? memchr(bytes, '\n', size) : NULL;
    size_t length = line != NULL ? (size_t)(line - bytes) : 0;
    const uint8_t *body = line != NULL ? line + 1 : bytes;
    size_t left = size - (size_t)(line != NULL ? length + 1 : 0);
    const size_t pieces[] = {1, 0};
    struct told whole, told;
    struct vor_error first, err;
    vor_status status;
    char type[512];

    (void)snprintf(type, sizeof type, "%.*s", (int)(length < 500 ? length : 500),
                   (const char *)bytes);
    if (!vor_multipart_is_form(type))
        (void)snprintf(type, sizeof type, "multipart/form-data; boundary=b");
    status = scan(&whole, type, body, left, left + 1, &first);
    require(status == VOR_OK || status == VOR_E_REQUEST, "a status that a scanner does not have");
    require(status == VOR_OK || first.message[0] != '\0', "a refusal that says nothing");
    require(status != VOR_OK || !whole.in_part, "a form is whole, a part of it is not");
    require(whole.data <= left, "more data than body");
    for (size_t i = 0; i < 2; i++) {
        require(scan(&told, type, body, left, pieces[i], &err) == status, "another answer");
        require(err.byte_offset == first.byte_offset && strcmp(err.message, first.message) == 0,
                "another refusal");
        require(told.parts == whole.parts && told.in_part == whole.in_part, "other parts");
        require(told.data == whole.data && told.hash == whole.hash, "other data");
    }
    return 0;
}
