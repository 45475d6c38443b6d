#include "proto/csv.h"

#include "proto/json/json.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>

void vor_csv_head(struct vor_text *text, const struct vor_members *members)
{
    for (unsigned i = 0; i < members->count; i++)
        vor_text_printf(text, "%s%s", i > 0 ? "," : "", members->rows[i].name);
    vor_text_puts(text, "\n");
}

static void put_value(struct vor_text *text, const struct vor_member *row, const void *value)
{
    char number[VOR_JSON_NUMBER_MAX];
    unsigned word;

    switch (row->kind) {
    case VOR_MEMBER_U32:
        vor_text_printf(text, "%" PRIu32, *(const uint32_t *)value);
        return;
    case VOR_MEMBER_U64:
        vor_text_printf(text, "%" PRIu64, *(const uint64_t *)value);
        return;
    case VOR_MEMBER_REAL:
        if (isfinite(*(const double *)value)) {
            (void)vor_json_format_double(number, *(const double *)value);
            vor_text_puts(text, number);
        }
        return;
    case VOR_MEMBER_WORD:
        word = *(const unsigned *)value;
        vor_text_puts(text, word < row->word_count ? row->words[word] : "");
        return;
    default:
        assert(!"a description with numbers and words only");
    }
}

void vor_csv_line(struct vor_text *text, const struct vor_members *members, const void *values)
{
    for (unsigned i = 0; i < members->count; i++) {
        if (i > 0)
            vor_text_puts(text, ",");
        put_value(text, &members->rows[i], vor_member_at(&members->rows[i], values));
    }
    vor_text_puts(text, "\n");
}
