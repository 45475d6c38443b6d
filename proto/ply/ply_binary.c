/* Rows without lists have a constant size. They are read in blocks that stay in the cache, one
 * strided copy a column, with the type's size decided outside the loop. Rows with lists are walked
 * scalar by scalar. */
#include "proto/ply/ply_body.h"

#include "core/base/quote.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { BLOCK_BYTES = 65536 };

int vor_ply_swaps(enum vor_ply_encoding encoding)
{
    return (encoding == VOR_PLY_BIG) == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
}

static void reverse(uint8_t *to, const uint8_t *from, size_t size)
{
    for (size_t i = 0; i < size; i++)
        to[i] = from[size - 1 - i];
}

/* A memcpy of constant size is a move or two. */
#define COPY_CASE(bytes)                                                                           \
    case bytes:                                                                                    \
        for (size_t i = 0; i < n; i++)                                                             \
            memcpy(to.base + i * to.stride, from.base + i * from.stride, bytes);                   \
        break;

void vor_ply_copy(struct vor_ply_strided to, struct vor_ply_source from, size_t n, size_t size,
                  size_t run, int swap)
{
    size_t all = size * run;

    if (swap && size > 1) {
        for (size_t i = 0; i < n; i++)
            for (size_t k = 0; k < run; k++)
                reverse(to.base + i * to.stride + k * size, from.base + i * from.stride + k * size,
                        size);
        return;
    }
    if (to.stride == all && from.stride == all) {
        memcpy(to.base, from.base, n * all);
        return;
    }
    switch (all) {
        COPY_CASE(1)
        COPY_CASE(2)
        COPY_CASE(3)
        COPY_CASE(4)
        COPY_CASE(8)
        COPY_CASE(12)
        COPY_CASE(24)
    default:
        for (size_t i = 0; i < n; i++)
            memcpy(to.base + i * to.stride, from.base + i * from.stride, all);
        break;
    }
}

double vor_ply_load(const uint8_t *from, enum vor_type type, int swap)
{
    union {
        uint8_t bytes[8];
#define LOAD_MEMBER(name, ctype, ply, sized) ctype as_##name;
        VOR_TYPE_TABLE(LOAD_MEMBER)
#undef LOAD_MEMBER
    } value;
    size_t size = vor_type_size(type);

    if (swap)
        reverse(value.bytes, from, size);
    else
        memcpy(value.bytes, from, size);
    switch (type) {
#define LOAD_CASE(name, ctype, ply, sized)                                                         \
    case VOR_##name:                                                                               \
        return (double)value.as_##name;
        VOR_TYPE_TABLE(LOAD_CASE)
#undef LOAD_CASE
    default:
        assert(0);
        return 0;
    }
}

void vor_ply_store(uint8_t *to, enum vor_type type, double value)
{
    float single = (float)value;

    if (type == VOR_FLOAT32)
        memcpy(to, &single, sizeof single);
    else
        memcpy(to, &value, sizeof value);
}

/* Bytes of a row without the items of its lists. */
static size_t row_bytes(const struct vor_ply_property *properties, unsigned count, int *has_list)
{
    size_t bytes = 0;

    *has_list = 0;
    for (unsigned i = 0; i < count; i++) {
        const struct vor_ply_property *property = &properties[i];

        *has_list |= property->list;
        bytes += vor_type_size(property->list ? property->count_type : property->type);
    }
    return bytes;
}

/* Ascii: a character and a separator for each scalar or list, no separator at the file's end. */
vor_status vor_ply_rows_fit(const struct vor_ply_body *body, const struct vor_ply_element *element,
                            struct vor_error *err)
{
    int ascii = body->encoding == VOR_PLY_ASCII, has_list;
    size_t row = ascii ? 2 * (size_t)element->property_count
                       : row_bytes(element->properties, element->property_count, &has_list);
    size_t left = body->size - body->at + (ascii ? 1 : 0), need;

    if (!__builtin_mul_overflow(element->count, row, &need) && need <= left)
        return VOR_OK;
    return VOR_PLY_FAIL(
        err, body->size,
        "%llu rows of %s need at least %zu bytes each, but the file has only %zu bytes "
        "left: the file is cut short, or its number of rows is wrong",
        (unsigned long long)element->count, VOR_QUOTED(48, element->name, element->name_length),
        row, body->size - body->at);
}

static vor_status truncated(const struct vor_ply_body *body, uint64_t row, struct vor_error *err)
{
    return VOR_PLY_FAIL(err, body->size, "the file ends after %zu bytes, inside row %llu",
                        body->size, (unsigned long long)row);
}

/* Moves past a list. Its length is whatever the file says, so it is compared with what is left. */
static vor_status skip_list(struct vor_ply_body *body, const struct vor_ply_property *property,
                            uint64_t row, struct vor_error *err)
{
    size_t count_size = vor_type_size(property->count_type);
    size_t left = body->size - body->at;
    double count;

    if (left < count_size)
        return truncated(body, row, err);
    count =
        vor_ply_load(body->bytes + body->at, property->count_type, vor_ply_swaps(body->encoding));
    if (!(count >= 0) || count != floor(count))
        return VOR_PLY_FAIL(err, body->at, "a list in row %llu has %g items, want a whole number",
                            (unsigned long long)row, count);
    left -= count_size;
    if (count * (double)vor_type_size(property->type) > (double)left)
        return VOR_PLY_FAIL(err, body->at,
                            "a list in row %llu has %.0f items, but %zu bytes are left",
                            (unsigned long long)row, count, left);
    body->at += count_size + (size_t)count * vor_type_size(property->type);
    return VOR_OK;
}

static vor_status skip_property(struct vor_ply_body *body, const struct vor_ply_property *property,
                                uint64_t row, struct vor_error *err)
{
    size_t size = vor_type_size(property->type);

    if (property->list)
        return skip_list(body, property, row, err);
    if (body->size - body->at < size)
        return truncated(body, row, err);
    body->at += size;
    return VOR_OK;
}

vor_status vor_ply_binary_skip(struct vor_ply_body *body, const struct vor_ply_element *element,
                               struct vor_error *err)
{
    int has_list;
    size_t row = row_bytes(element->properties, element->property_count, &has_list);
    vor_status status = vor_ply_rows_fit(body, element, err);

    if (status != VOR_OK)
        return status;
    if (!has_list) {
        body->at += row * (size_t)element->count;
        return VOR_OK;
    }
    for (uint64_t i = 0; i < element->count; i++)
        for (unsigned k = 0; k < element->property_count; k++) {
            status = skip_property(body, &element->properties[k], i, err);
            if (status != VOR_OK)
                return status;
        }
    return VOR_OK;
}

/* Moves past the list in a row and hands over its items. */
static vor_status take_list(struct vor_ply_body *body, const struct vor_ply_property *list,
                            uint64_t row, const struct vor_ply_items *items, struct vor_error *err)
{
    size_t at = body->at + vor_type_size(list->count_type), size = vor_type_size(list->type);
    int swap = vor_ply_swaps(body->encoding);
    vor_status status = skip_list(body, list, row, err);

    for (uint64_t i = 0; status == VOR_OK && at < body->at; i++, at += size) {
        status =
            items->take(items->ctx, row, i, vor_ply_load(body->bytes + at, list->type, swap), err);
        if (status != VOR_OK)
            return vor_fail_at(err, status, at);
    }
    return status;
}

vor_status vor_ply_binary_items(struct vor_ply_body *body, const struct vor_ply_element *element,
                                unsigned list, const struct vor_ply_items *items,
                                struct vor_error *err)
{
    vor_status status = vor_ply_rows_fit(body, element, err);

    for (uint64_t i = 0; status == VOR_OK && i < element->count; i++)
        for (unsigned k = 0; status == VOR_OK && k < element->property_count; k++)
            status = k == list ? take_list(body, &element->properties[k], i, items, err)
                               : skip_property(body, &element->properties[k], i, err);
    return status;
}

static void check_coordinate(struct vor_ply_body *body, double value, size_t offset)
{
    if (!isfinite(value) && body->not_finite == 0)
        body->not_finite = offset;
}

static vor_status read_walked(struct vor_ply_body *body, const struct vor_ply_column *column,
                              size_t row, struct vor_error *err)
{
    enum vor_type type = column->property->type;
    int swap = vor_ply_swaps(body->encoding);
    size_t begin = body->at;
    uint8_t *to = column->to == NULL ? NULL : column->to + row * column->to_stride;
    double value;
    vor_status status = skip_property(body, column->property, row, err);

    if (status != VOR_OK || to == NULL)
        return status;
    if (column->coordinate < 0) {
        vor_ply_copy((struct vor_ply_strided){to, 0},
                     (struct vor_ply_source){body->bytes + begin, 0}, 1, vor_type_size(type), 1,
                     swap);
        return VOR_OK;
    }
    value = vor_ply_load(body->bytes + begin, type, swap);
    vor_ply_store(to, column->to_type, value);
    check_coordinate(body, value, begin);
    return VOR_OK;
}

/* How many columns from k on can be copied as one: the same type, adjacent in the row and in
 * memory. */
static unsigned run_length(const struct vor_ply_rows *rows, unsigned k)
{
    const struct vor_ply_column *first = &rows->columns[k];
    size_t size = vor_type_size(first->to_type);
    unsigned run = 1;

    while (k + run < rows->column_count) {
        const struct vor_ply_column *next = &rows->columns[k + run];

        if (next->property->type != first->property->type || next->to != first->to + run * size ||
            next->to_type != first->to_type || next->to_stride != first->to_stride)
            break;
        run++;
    }
    return run;
}

/* Rows first .. first + n - 1, which begin at `from`. */
static void read_block(const struct vor_ply_rows *rows, size_t first, size_t n, const uint8_t *from,
                       size_t row, int swap)
{
    unsigned run;

    for (unsigned k = 0; k < rows->column_count; k += run) {
        const struct vor_ply_column *column = &rows->columns[k];
        size_t size = vor_type_size(column->property->type);
        struct vor_ply_strided to = {column->to + first * column->to_stride, column->to_stride};

        run = 1;
        if (column->property->type != column->to_type) {
            for (size_t i = 0; i < n; i++)
                vor_ply_store(column->to + (first + i) * column->to_stride, column->to_type,
                              vor_ply_load(from + i * row, column->property->type, swap));
        } else {
            run = run_length(rows, k);
            vor_ply_copy(to, (struct vor_ply_source){from, row}, n, size, run, swap);
        }
        from += run * size;
    }
}

static int is_finite(const uint8_t *at, enum vor_type type)
{
    uint32_t single;
    uint64_t wide;

    if (type == VOR_FLOAT32) {
        memcpy(&single, at, sizeof single);
        return (single & UINT32_C(0x7f800000)) != UINT32_C(0x7f800000);
    }
    memcpy(&wide, at, sizeof wide);
    return (wide & UINT64_C(0x7ff0000000000000)) != UINT64_C(0x7ff0000000000000);
}

static int all_finite(const struct vor_ply_column *column, size_t first, size_t n)
{
    const uint8_t *at = column->to + first * column->to_stride;
    int finite = 1;

    if (column->coordinate < 0)
        return 1;
    for (size_t i = 0; i < n; i++)
        finite &= is_finite(at + i * column->to_stride, column->to_type);
    return finite;
}

/* Checks row i, which begins at offset. */
static void check_row(struct vor_ply_body *body, const struct vor_ply_rows *rows, size_t i,
                      size_t offset)
{
    for (unsigned k = 0; k < rows->column_count; k++) {
        const struct vor_ply_column *column = &rows->columns[k];

        if (column->coordinate >= 0)
            check_coordinate(
                body, vor_ply_load(column->to + i * column->to_stride, column->to_type, 0), offset);
        offset += vor_type_size(column->property->type);
    }
}

vor_status vor_ply_binary_rows(struct vor_ply_body *body, const struct vor_ply_rows *rows,
                               struct vor_error *err)
{
    int has_list = 0, finite;
    size_t row = 0, block, n;

    for (unsigned k = 0; k < rows->column_count; k++) {
        has_list |= rows->columns[k].property->list;
        row += vor_type_size(rows->columns[k].property->type);
    }
    if (has_list) {
        for (size_t i = 0; i < rows->n; i++)
            for (unsigned k = 0; k < rows->column_count; k++) {
                vor_status status = read_walked(body, &rows->columns[k], i, err);

                if (status != VOR_OK)
                    return status;
            }
        return VOR_OK;
    }
    assert(row > 0); /* x, y and z are columns */
    block = BLOCK_BYTES / row;
    for (size_t first = 0; first < rows->n; first += n) {
        n = rows->n - first < block ? rows->n - first : block;
        assert(n * row <= body->size - body->at);
        read_block(rows, first, n, body->bytes + body->at, row, vor_ply_swaps(body->encoding));
        finite = 1;
        for (unsigned k = 0; k < rows->column_count; k++)
            finite &= all_finite(&rows->columns[k], first, n);
        for (size_t i = 0; !finite && i < n && body->not_finite == 0; i++)
            check_row(body, rows, first + i, body->at + i * row);
        body->at += n * row;
    }
    return VOR_OK;
}
