/* A row is a line, as in the files of the format's author; a line with too few or too many values
 * is an error, not a shift of every row behind it. Lines end in LF, CRLF or CR; blank ones do not
 * count. */
#include "proto/ply/ply_body.h"

#include "core/base/quote.h"
#include "proto/ply/ply_number.h"

#include <math.h>
#include <string.h>

enum { SHOWN = 40 };

struct token {
    const uint8_t *at;
    size_t length; /* 0: the line has no more */
};

static int is_blank(uint8_t c)
{
    return c == ' ' || c == '\t';
}

static int is_end(uint8_t c)
{
    return c == '\n' || c == '\r';
}

static vor_status too_short(const struct vor_ply_body *body, uint64_t row, struct vor_error *err)
{
    return VOR_PLY_FAIL(err, body->size, "the file ends after %zu bytes, before row %llu",
                        body->size, (unsigned long long)row);
}

/* Moves to the first token of the next line that has one. */
static int next_row(struct vor_ply_body *body)
{
    while (body->at < body->size &&
           (is_blank(body->bytes[body->at]) || is_end(body->bytes[body->at])))
        body->at++;
    return body->at < body->size;
}

static struct token next_token(struct vor_ply_body *body)
{
    const uint8_t *at = body->bytes + body->at, *end = body->bytes + body->size, *begin;

    while (at < end && is_blank(*at))
        at++;
    for (begin = at; at < end && !is_blank(*at) && !is_end(*at);)
        at++;
    body->at = (size_t)(at - body->bytes);
    return (struct token){begin, (size_t)(at - begin)};
}

static size_t offset_of(const struct vor_ply_body *body, struct token token)
{
    return (size_t)(token.at - body->bytes);
}

static vor_status too_few(const struct vor_ply_body *body, const struct vor_ply_property *property,
                          size_t row, struct vor_error *err)
{
    return VOR_PLY_FAIL(err, body->at, "row %zu ends before its %s", row,
                        VOR_QUOTED(SHOWN, property->name, property->name_length));
}

static vor_status bad_number(const struct vor_ply_body *body, const struct vor_ply_column *column,
                             size_t row, struct token token, enum vor_ply_number reason,
                             struct vor_error *err)
{
    const struct vor_ply_property *property = column->property;
    const char *type = vor_type_name(property->list ? property->count_type : property->type);
    char name[SHOWN], shown[SHOWN];

    vor_quote(name, sizeof name, property->name, property->name_length);
    vor_quote(shown, sizeof shown, token.at, token.length);
    if (reason == VOR_PLY_NUMBER_RANGE)
        vor_fail(err, VOR_E_FORMAT, "%s of row %zu is %s, outside the range of %s", name, row,
                 shown, type);
    else
        vor_fail(err, VOR_E_FORMAT, "%s of row %zu is \"%s\", want a number of type %s%s", name,
                 row, shown, type,
                 memchr(token.at, ',', token.length) != NULL
                     ? ": separate numbers by blanks, and write decimals with a point"
                     : "");
    return vor_fail_at(err, VOR_E_FORMAT, offset_of(body, token));
}

static vor_status read_scalar(struct vor_ply_body *body, const struct vor_ply_column *column,
                              size_t row, struct vor_error *err)
{
    enum vor_type type = column->property->type;
    struct token token = next_token(body);
    uint8_t *to = column->to + row * column->to_stride;
    uint8_t value[8] = {0};
    enum vor_ply_number read;

    if (token.length == 0)
        return too_few(body, column->property, row, err);
    read = vor_ply_number_read(token.at, token.length, type, type == column->to_type ? to : value);
    if (read != VOR_PLY_NUMBER_OK && read != VOR_PLY_NUMBER_NONFINITE)
        return bad_number(body, column, row, token, read, err);
    if (read == VOR_PLY_NUMBER_NONFINITE && column->coordinate >= 0 && body->not_finite == 0)
        body->not_finite = offset_of(body, token);
    if (type != column->to_type)
        vor_ply_store(to, column->to_type, vor_ply_load(value, type, 0));
    return VOR_OK;
}

/* Reads how many items a list has. A count beyond what fits is beyond what the row holds, too. */
static vor_status read_count(uint64_t *out, struct vor_ply_body *body,
                             const struct vor_ply_column *column, size_t row, struct vor_error *err)
{
    const struct vor_ply_property *property = column->property;
    struct token token = next_token(body);
    uint8_t value[8] = {0};
    double count;
    enum vor_ply_number read;

    if (token.length == 0)
        return too_few(body, property, row, err);
    read = vor_ply_number_read(token.at, token.length, property->count_type, value);
    count = vor_ply_load(value, property->count_type, 0);
    if (read == VOR_PLY_NUMBER_OK && (count < 0 || count != floor(count)))
        read = VOR_PLY_NUMBER_RANGE;
    if (read != VOR_PLY_NUMBER_OK)
        return bad_number(body, column, row, token,
                          read == VOR_PLY_NUMBER_NONFINITE ? VOR_PLY_NUMBER_RANGE : read, err);
    *out = count < 0x1p63 ? (uint64_t)count : UINT64_MAX;
    return VOR_OK;
}

/* Every item is a token of this line, so a false length ends at the line's end. */
static vor_status skip_list(struct vor_ply_body *body, const struct vor_ply_column *column,
                            size_t row, struct vor_error *err)
{
    uint64_t left = 0;
    vor_status status = read_count(&left, body, column, row, err);

    if (status != VOR_OK)
        return status;
    for (; left > 0; left--)
        if (next_token(body).length == 0)
            return too_few(body, column->property, row, err);
    return VOR_OK;
}

static vor_status take_item(struct vor_ply_body *body, const struct vor_ply_column *column,
                            size_t row, uint64_t item, const struct vor_ply_items *items,
                            struct vor_error *err)
{
    struct token token = next_token(body);
    uint8_t value[8] = {0};
    enum vor_ply_number read;
    vor_status status;

    if (token.length == 0)
        return too_few(body, column->property, row, err);
    read = vor_ply_number_read(token.at, token.length, column->property->type, value);
    if (read != VOR_PLY_NUMBER_OK)
        return bad_number(body, column, row, token, read, err);
    status =
        items->take(items->ctx, row, item, vor_ply_load(value, column->property->type, 0), err);
    return status == VOR_OK ? VOR_OK : vor_fail_at(err, status, offset_of(body, token));
}

/* Refuses what a row of that many properties has behind them. */
static vor_status end_row(struct vor_ply_body *body, size_t row, unsigned properties,
                          struct vor_error *err)
{
    struct token extra = next_token(body);

    if (extra.length == 0)
        return VOR_OK;
    return VOR_PLY_FAIL(err, offset_of(body, extra),
                        "row %zu has more values than its %u properties: \"%s\"", row, properties,
                        VOR_QUOTED(SHOWN, extra.at, extra.length));
}

vor_status vor_ply_ascii_rows(struct vor_ply_body *body, const struct vor_ply_rows *rows,
                              struct vor_error *err)
{
    for (size_t i = 0; i < rows->n; i++) {
        vor_status status = next_row(body) ? VOR_OK : too_short(body, i, err);

        for (unsigned k = 0; status == VOR_OK && k < rows->column_count; k++) {
            const struct vor_ply_column *column = &rows->columns[k];

            status = column->property->list ? skip_list(body, column, i, err)
                                            : read_scalar(body, column, i, err);
        }
        VOR_THEN(status, end_row(body, i, rows->column_count, err));
        if (status != VOR_OK)
            return status;
    }
    return VOR_OK;
}

vor_status vor_ply_ascii_skip(struct vor_ply_body *body, const struct vor_ply_element *element,
                              struct vor_error *err)
{
    vor_status status = vor_ply_rows_fit(body, element, err);

    if (status != VOR_OK || element->property_count == 0)
        return status;
    for (uint64_t i = 0; i < element->count; i++) {
        if (!next_row(body))
            return too_short(body, i, err);
        while (body->at < body->size && !is_end(body->bytes[body->at]))
            body->at++;
    }
    return VOR_OK;
}

static vor_status take_row(struct vor_ply_body *body, const struct vor_ply_element *element,
                           size_t row, unsigned list, const struct vor_ply_items *items,
                           struct vor_error *err)
{
    vor_status status = VOR_OK;

    if (!next_row(body))
        return too_short(body, row, err);
    for (unsigned k = 0; status == VOR_OK && k < element->property_count; k++) {
        const struct vor_ply_column column = {.property = &element->properties[k]};

        if (k == list) {
            uint64_t count = 0;

            status = read_count(&count, body, &column, row, err);
            for (uint64_t i = 0; status == VOR_OK && i < count; i++)
                status = take_item(body, &column, row, i, items, err);
        } else if (column.property->list) {
            status = skip_list(body, &column, row, err);
        } else if (next_token(body).length == 0) { /* whatever it says */
            status = too_few(body, column.property, row, err);
        }
    }
    return status == VOR_OK ? end_row(body, row, element->property_count, err) : status;
}

vor_status vor_ply_ascii_items(struct vor_ply_body *body, const struct vor_ply_element *element,
                               unsigned list, const struct vor_ply_items *items,
                               struct vor_error *err)
{
    vor_status status = vor_ply_rows_fit(body, element, err);

    for (uint64_t i = 0; status == VOR_OK && i < element->count; i++)
        status = take_row(body, element, (size_t)i, list, items, err);
    return status;
}
