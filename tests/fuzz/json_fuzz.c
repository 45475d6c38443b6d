/* Any bytes through the reader's door. What the scan lets pass, cJSON reads; what was read, written
 * out by our own writer, is read again as the same; a request read from it comes back. */
#include "proto/json/json.h"
#include "tests/fuzz/fuzz.h"

static void read_request(const struct vor_json *json)
{
    struct vor_json *again = NULL;
    struct vor_spec spec, back;
    struct vor_text text;

    vor_spec_init(&spec);
    vor_spec_init(&back);
    if (vor_json_spec_read(&spec, json, NULL) != VOR_OK)
        return;
    vor_text_init(&text, 0);
    vor_json_spec(&text, &spec);
    require(vor_json_parse(&again, text.data, text.size, NULL) == VOR_OK, "a request is no JSON");
    require(vor_json_spec_read(&back, again, NULL) == VOR_OK, "a request is refused");
    require(memcmp(&spec, &back, sizeof spec) == 0, "a request came back as another one");
    vor_json_free(again);
    vor_text_free(&text);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    vor_status scanned = vor_json_scan((const char *)bytes, size, NULL), status;
    struct vor_json *json = NULL, *again = NULL;
    struct vor_text first, second;
    struct vor_error err;

    vor_text_init(&first, 0);
    vor_text_init(&second, 0);
    status = vor_json_parse(&json, (const char *)bytes, size, &err);
    require(scanned == VOR_OK || status == scanned, "the door is wider than the scan");
    require(status == VOR_OK || (json == NULL && err.byte_offset >= 0 &&
                                 err.byte_offset <= (int64_t)size && err.message[0] != '\0'),
            "a refusal says nothing");
    require(scanned != VOR_OK || status == VOR_OK, "cJSON refuses what the scan lets pass");
    if (status == VOR_OK) {
        read_request(json);
        vor_json_copy(&first, json);
        require(vor_json_parse(&again, first.data, first.size, &err) == VOR_OK,
                "our own text is refused");
        vor_json_copy(&second, again);
        require(first.size == second.size && memcmp(first.data, second.data, first.size) == 0,
                "a text changes when it is read and written again");
    }
    vor_json_free(json);
    vor_json_free(again);
    vor_text_free(&first);
    vor_text_free(&second);
    return 0;
}
