/* Any text for a parameter of any kind. What is taken has a form of the kind, and a text of its own
 * from which the same value is read; what is refused leaves the value as it was. The first byte
 * chooses the kind; the second one is not looked at. */
#include "core/spec/kinds.h"
#include "tests/fuzz/fuzz.h"

enum { TEXT_MAX = 300 };

static void check(const struct vor_parameter_info *row, const char *text)
{
    struct vor_value value = {42, NULL}, again;
    char written[TEXT_MAX + 64], twice[TEXT_MAX + 64];

    if (!vor_kind_read(row, text, &value)) {
        require(value.number == 42 && value.text == NULL, "a refusal changes the value");
        return;
    }
    require(vor_kind_form_of(row, value.number) != VOR_FORM_NONE, "a value without a form");
    vor_kind_write(row, value.number, value.text, written, sizeof written);
    require(vor_kind_read(row, written, &again), "our own text is refused");
    require(again.number == value.number, "a text stands for another value");
    vor_kind_write(row, again.number, again.text, twice, sizeof twice);
    require(strcmp(written, twice) == 0, "a text changes when it is read and written again");
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    struct vor_parameter_info row = {.name = "it",
                                     .unit = "",
                                     .min = 0,
                                     .max = 200,
                                     .choices = "mls outliers thin attribute:NAME",
                                     .allowed = ~0ull};
    char text[TEXT_MAX];

    if (size < 2 || size - 2 >= sizeof text)
        return 0;
    row.kind = (enum vor_kind)(bytes[0] % VOR_KINDS);
    memcpy(text, bytes + 2, size - 2);
    text[size - 2] = '\0';
    check(&row, text);
    return 0;
}
