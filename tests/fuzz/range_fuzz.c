/* Any bytes as a Range header, as an entity tag and as a list of them. A part lies within the
 * representation and, asked for again by its own first and last byte, is the same part; a tag is
 * found in a list that holds it. */
#include "server/api/handlers/range.h"
#include "server/http/request_check.h"
#include "tests/fuzz/fuzz.h"

#include <inttypes.h>

static void try_range(const char *text, uint64_t size)
{
    uint64_t offset = 1, length = 2, first, again;
    char own[80];

    if (vor_range_parse(text, size, &offset, &length) != VOR_RANGE_PART) {
        require(offset == 1 && length == 2, "a range that is none sets something");
        return;
    }
    require(size > 0 && length > 0 && offset < size && length <= size - offset,
            "a part lies outside");
    (void)snprintf(own, sizeof own, "bytes=%" PRIu64 "-%" PRIu64, offset, offset + length - 1);
    require(vor_range_parse(own, size, &first, &again) == VOR_RANGE_PART && first == offset &&
                again == length,
            "a part is another one when asked for by its own bytes");
}

static void try_tags(const char *list)
{
    static const char etag[] = "\"e3b0c44298fc1c149afbf4c8996fb924\"";
    size_t length = strlen(list);
    char *with = malloc(length + sizeof etag + 2);

    require(with != NULL, "no memory");
    memcpy(with, etag, sizeof etag - 1);
    memcpy(with + sizeof etag - 1, ", ", 2);
    memcpy(with + sizeof etag + 1, list, length + 1);
    require(vor_etag_listed(with, etag, false), "a tag is not found at the head of a list");
    (void)vor_etag_listed(list, etag, true);
    free(with);
}

/* The first eight bytes are the size of the representation, the rest is text. */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    uint64_t whole;
    char *text;

    if (size < sizeof whole)
        return 0;
    memcpy(&whole, bytes, sizeof whole);
    bytes += sizeof whole;
    size -= sizeof whole;
    text = fuzz_text(bytes, size);
    whole >>= 5; /* a file is no larger, and its last byte has at most 18 digits */
    try_range(text, whole);
    try_range(text, whole % 100);
    try_tags(text);
    free(text);
    return 0;
}
