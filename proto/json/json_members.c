#include "proto/json/json.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define COUNT_MAX 9007199254740991.0 /* 2^53 - 1: a double holds every whole number up to it */

/* Room for the name of an object. */
enum { NAME_MAX_SIZE = 64 };

static const char *const axes[3] = {"x", "y", "z"};

/* Rows of the same object, which stand next to each other; or one row that is in none. */
struct rows {
    const struct vor_member *begin, *end;
    size_t object; /* length of the object's name; 0: none */
};

/* Length of the name of the object that a row is in; 0 when it is in none. */
static size_t object_length(const struct vor_member *row)
{
    const char *dot = strchr(row->name, '.');

    if (row->kind == VOR_MEMBER_VECTOR || row->kind == VOR_MEMBER_OPTIONAL)
        return strlen(row->name);
    return dot != NULL ? (size_t)(dot - row->name) : 0;
}

static const struct vor_member *end_of(const struct vor_members *members)
{
    return members->rows + members->count;
}

static struct rows rows_from(const struct vor_members *members, const struct vor_member *begin)
{
    struct rows rows = {begin, begin + 1, object_length(begin)};

    while (rows.object > 0 && rows.end < end_of(members) &&
           object_length(rows.end) == rows.object &&
           strncmp(rows.end->name, begin->name, rows.object) == 0)
        rows.end++;
    return rows;
}

/* The name of a row within its object. */
static const char *name_in(const struct rows *rows, const struct vor_member *row)
{
    return rows->object > 0 ? row->name + rows->object + 1 : row->name;
}

static void begin_object_of(struct vor_text *text, const struct rows *rows)
{
    char name[NAME_MAX_SIZE];

    assert(rows->object < sizeof name);
    (void)snprintf(name, sizeof name, "%.*s", (int)rows->object, rows->begin->name);
    vor_json_put_object(text, name);
}

static void put_object(struct vor_text *text, const struct vor_members *members, const void *values)
{
    vor_json_begin_object(text);
    vor_json_members(text, members, values);
    vor_json_end_object(text);
}

static void put_list(struct vor_text *text, const struct vor_member *row, const void *values)
{
    const unsigned char *element = vor_member_at(row, values);
    unsigned count =
        *(const unsigned *)(const void *)((const unsigned char *)values + row->count_offset);

    vor_json_begin_array(text);
    for (unsigned i = 0; i < count; i++)
        put_object(text, row->inner, element + i * row->inner->size);
    vor_json_end_array(text);
}

static void put_member(struct vor_text *text, const char *name, const struct vor_member *row,
                       const void *values)
{
    const void *value = vor_member_at(row, values);
    unsigned word;

    switch (row->kind) {
    case VOR_MEMBER_U32:
        vor_json_put_u64(text, name, *(const uint32_t *)value);
        return;
    case VOR_MEMBER_U64:
        vor_json_put_u64(text, name, *(const uint64_t *)value);
        return;
    case VOR_MEMBER_REAL:
        vor_json_put_double(text, name, *(const double *)value);
        return;
    case VOR_MEMBER_VECTOR:
        for (int c = 0; c < 3; c++)
            vor_json_put_double(text, axes[c], ((const double *)value)[c]);
        return;
    case VOR_MEMBER_NUMBERS:
        vor_json_put_array(text, name);
        for (unsigned i = 0; i < row->word_count; i++)
            vor_json_double(text, ((const double *)value)[i]);
        vor_json_end_array(text);
        return;
    case VOR_MEMBER_TEXT:
        vor_json_put_string(text, name, value);
        return;
    case VOR_MEMBER_WORD:
        word = *(const unsigned *)value;
        vor_json_put_string(text, name, word < row->word_count ? row->words[word] : NULL);
        return;
    case VOR_MEMBER_OBJECT:
        vor_json_key(text, name);
        put_object(text, row->inner, value);
        return;
    case VOR_MEMBER_LIST:
        vor_json_key(text, name);
        put_list(text, row, values);
        return;
    case VOR_MEMBER_REQUEST:
        vor_json_key(text, name);
        vor_json_spec(text, value);
        return;
    case VOR_MEMBER_OPTIONAL:
        return;
    }
}

void vor_json_members(struct vor_text *text, const struct vor_members *members, const void *values)
{
    struct rows rows;

    for (const struct vor_member *at = members->rows; at < end_of(members); at = rows.end) {
        rows = rows_from(members, at);
        if (at->kind == VOR_MEMBER_OPTIONAL && *(const int *)vor_member_at(at, values) == 0)
            continue;
        if (rows.object > 0)
            begin_object_of(text, &rows);
        for (const struct vor_member *row = at; row < rows.end; row++)
            put_member(text, name_in(&rows, row), row, values);
        if (rows.object > 0)
            vor_json_end_object(text);
    }
}

void vor_json_document(struct vor_text *text, const struct vor_document *document)
{
    put_object(text, document->members, document->values);
}

static double number_of(const struct vor_json *value)
{
    double number = 0;

    (void)vor_json_get_number(value, &number);
    return number;
}

/* A whole number of 0 .. max; anything else is 0. */
static uint64_t count_of(const struct vor_json *value, double max)
{
    double number = number_of(value);

    return number >= 0 && number <= max ? (uint64_t)number : 0;
}

/* The value of a row in an object, or in the object of the row's name within that one; NULL when it
 * is missing. */
static const struct vor_json *value_at(const struct vor_json *object, const struct vor_member *row)
{
    size_t length = object_length(row);
    char name[NAME_MAX_SIZE];

    if (length == 0)
        return vor_json_get(object, row->name);
    assert(length < sizeof name);
    (void)snprintf(name, sizeof name, "%.*s", (int)length, row->name);
    return vor_json_get(vor_json_get(object, name), row->name + length + 1);
}

void vor_json_members_read(void *values, const struct vor_members *members,
                           const struct vor_json *object)
{
    const char *word;
    unsigned i;
    memset(values, 0, members->size);
    for (const struct vor_member *row = members->rows; row < end_of(members); row++) {
        const struct vor_json *value = value_at(object, row);
        void *member = (unsigned char *)values + row->offset;

        switch (row->kind) {
        case VOR_MEMBER_U32:
            *(uint32_t *)member = (uint32_t)count_of(value, UINT32_MAX);
            break;
        case VOR_MEMBER_U64:
            *(uint64_t *)member = count_of(value, COUNT_MAX);
            break;
        case VOR_MEMBER_REAL:
            *(double *)member = value != NULL && vor_json_kind(value) == VOR_JSON_NULL
                                    ? (double)NAN /* one that is not finite */
                                    : number_of(value);
            break;
        case VOR_MEMBER_WORD:
            word = vor_json_get_string(value);
            i = 0;
            while (value != NULL && i < row->word_count &&
                   (word == NULL || strcmp(word, row->words[i]) != 0))
                i++;
            *(unsigned *)member = i;
            break;
        default:
            assert(!"a description with numbers and words only");
        }
    }
}

/* --- the schema ------------------------------------------------------------------------------- */

/* What a member is, into its open schema. */
static void put_type(struct vor_text *text, const struct vor_member *row)
{
    switch (row->kind) {
    case VOR_MEMBER_U32:
    case VOR_MEMBER_U64:
        vor_json_put_string(text, "type", "integer");
        vor_json_put_u64(text, "minimum", 0);
        return;
    case VOR_MEMBER_REAL:
    case VOR_MEMBER_VECTOR:
        vor_json_put_string(text, "type", "number");
        vor_json_put_bool(text, "nullable", 1);
        return;
    case VOR_MEMBER_NUMBERS:
        vor_json_put_string(text, "type", "array");
        vor_json_put_object(text, "items");
        vor_json_put_string(text, "type", "number");
        vor_json_end_object(text);
        return;
    case VOR_MEMBER_TEXT:
        vor_json_put_string(text, "type", "string");
        return;
    case VOR_MEMBER_WORD:
        vor_json_put_string(text, "type", "string");
        vor_json_put_array(text, "enum");
        for (unsigned i = 0; i < row->word_count; i++)
            vor_json_string(text, row->words[i]);
        vor_json_end_array(text);
        return;
    case VOR_MEMBER_LIST:
        vor_json_put_string(text, "type", "array");
        vor_json_put_object(text, "items");
        vor_json_members_schema(text, row->inner);
        vor_json_end_object(text);
        return;
    case VOR_MEMBER_OBJECT:
        vor_json_members_schema(text, row->inner);
        return;
    case VOR_MEMBER_REQUEST:
    case VOR_MEMBER_OPTIONAL:
        vor_json_put_string(text, "type", "object");
        return;
    }
}

static void put_property(struct vor_text *text, const char *name, const struct vor_member *row)
{
    vor_json_put_object(text, name);
    put_type(text, row);
    vor_json_put_string(text, "description", row->sentence);
    if (row->unit[0] != '\0')
        vor_json_put_string(text, "x-unit", row->unit);
    vor_json_end_object(text);
}

static void put_properties(struct vor_text *text, const struct rows *rows)
{
    for (const struct vor_member *row = rows->begin; row < rows->end; row++) {
        for (int c = 0; row->kind == VOR_MEMBER_VECTOR && c < 3; c++)
            put_property(text, axes[c], row);
        if (row->kind != VOR_MEMBER_VECTOR && row->kind != VOR_MEMBER_OPTIONAL)
            put_property(text, name_in(rows, row), row);
    }
}

/* The names of what stands at the top: objects, but optional ones, and members in none. */
static void put_top_names(struct vor_text *text, const struct vor_members *members)
{
    struct rows rows;

    for (const struct vor_member *at = members->rows; at < end_of(members); at = rows.end) {
        rows = rows_from(members, at);
        if (at->kind != VOR_MEMBER_OPTIONAL)
            vor_json_bytes(text, at->name, rows.object > 0 ? rows.object : strlen(at->name));
    }
}

void vor_json_members_schema(struct vor_text *text, const struct vor_members *members)
{
    struct rows rows;

    vor_json_put_string(text, "type", "object");
    vor_json_put_array(text, "required");
    put_top_names(text, members);
    vor_json_end_array(text);
    vor_json_put_object(text, "properties");
    for (const struct vor_member *at = members->rows; at < end_of(members); at = rows.end) {
        rows = rows_from(members, at);
        if (rows.object > 0) {
            begin_object_of(text, &rows);
            vor_json_put_string(text, "type", "object");
            if (rows.begin->kind == VOR_MEMBER_OPTIONAL)
                vor_json_put_string(text, "description", rows.begin->sentence);
            vor_json_put_array(text, "required");
            /* The names of the rows within their object, a vector's three for it. */
            for (const struct vor_member *row = rows.begin; row < rows.end; row++) {
                for (int c = 0; row->kind == VOR_MEMBER_VECTOR && c < 3; c++)
                    vor_json_string(text, axes[c]);
                if (row->kind != VOR_MEMBER_VECTOR && row->kind != VOR_MEMBER_OPTIONAL)
                    vor_json_string(text, name_in(&rows, row));
            }
            vor_json_end_array(text);
            vor_json_put_object(text, "properties");
            put_properties(text, &rows);
            vor_json_end_object(text);
            vor_json_end_object(text);
        } else {
            put_properties(text, &rows);
        }
    }
    vor_json_end_object(text);
}
