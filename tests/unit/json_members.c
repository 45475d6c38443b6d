/* A struct that describes itself: its shape in JSON and CSV, its schema, and what is read back. */
#include "proto/csv.h"
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

enum flavour { SWEET, SOUR };
static const char *const flavours[] = {"sweet", "sour"};

#define FRUIT_TABLE(X)                                                                             \
    X(U32, seeds, "seeds", "", "Seeds in it")                                                      \
    X(REAL, weight, "weight", "g", "Its weight")

struct fruit {
    FRUIT_TABLE(VOR_FIELD)
};

static const struct vor_member fruit_rows[] = {
#define FRUIT_ROW(...) VOR_MEMBER(struct fruit, __VA_ARGS__)
    FRUIT_TABLE(FRUIT_ROW)
#undef FRUIT_ROW
};

static const struct vor_members fruit_members = VOR_MEMBERS(struct fruit, fruit_rows);

#define VOR_FIELD_FLAVOUR(field) enum flavour field;
#define VOR_KIND_OF_FLAVOUR(type, field) .kind = VOR_MEMBER_WORD, .words = flavours, .word_count = 2
#define VOR_FIELD_FRUIT(field) struct fruit field;
#define VOR_KIND_OF_FRUIT(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &fruit_members
#define VOR_FIELD_FRUITS(field)                                                                    \
    struct fruit field[3];                                                                         \
    unsigned field##_count;
#define VOR_KIND_OF_FRUITS(type, field)                                                            \
    .kind = VOR_MEMBER_LIST, .inner = &fruit_members, .count_offset = offsetof(type, field##_count)

#define BASKET_TABLE(X)                                                                            \
    X(U64, held, "held", "fruits", "How many it holds")                                            \
    X(VECTOR, size, "size", "m", "How large it is")                                                \
    X(U32, handles, "size.handles", "", "Handles")                                                 \
    X(FLAVOUR, flavour, "flavour", "", "What it tastes of")                                        \
    X(FRUIT, first, "first", "", "The one on top")                                                 \
    X(FRUITS, others, "others", "", "The ones below")                                              \
    X(OPTIONAL, is_sold, "sale", "", "Only once it is sold")                                       \
    X(REAL, price, "sale.price", "EUR", "What it brought")                                         \
    X(U32, day, "sale.day", "", "When")                                                            \
    X(U32, sales, "sales", "", "Begins like the object before it")

struct basket {
    BASKET_TABLE(VOR_FIELD)
};

static const struct vor_member basket_rows[] = {
#define BASKET_ROW(...) VOR_MEMBER(struct basket, __VA_ARGS__)
    BASKET_TABLE(BASKET_ROW)
#undef BASKET_ROW
};

static const struct vor_members basket_members = VOR_MEMBERS(struct basket, basket_rows);

static struct vor_text text;

static void expect(const char *wanted)
{
    vt_assert_ok(vor_text_status(&text, &vt_err));
    ck_assert_str_eq(text.data, wanted);
    vor_text_free(&text);
}

static struct basket basket_of(int is_sold)
{
    return (struct basket){.held = 10000000000000001u,
                           .size = {1, 0.5, (double)INFINITY},
                           .handles = 2,
                           .flavour = SOUR,
                           .first = {4, 0.25},
                           .others = {{5, 0.125}, {6, (double)NAN}, {7, 9}},
                           .others_count = 2,
                           .is_sold = is_sold,
                           .price = 3.5,
                           .day = 17,
                           .sales = 1};
}

#define BEFORE                                                                                     \
    "{\"held\":10000000000000001,\"size\":{\"x\":1,\"y\":0.5,\"z\":null,\"handles\":2},"           \
    "\"flavour\":\"sour\",\"first\":{\"seeds\":4,\"weight\":0.25},"                                \
    "\"others\":[{\"seeds\":5,\"weight\":0.125},{\"seeds\":6,\"weight\":null}],"

VT_TEST(a_document_follows_its_table)
{
    struct basket basket = basket_of(1);
    struct vor_document document = {"basket", &basket_members, &basket};

    vor_text_init(&text, 0);
    vor_json_document(&text, &document);
    expect(BEFORE "\"sale\":{\"price\":3.5,\"day\":17},\"sales\":1}");
}

VT_TEST(an_optional_object_is_left_out_and_what_follows_it_is_not)
{
    struct basket basket = basket_of(0);
    struct vor_document document = {"basket", &basket_members, &basket};

    vor_text_init(&text, 0);
    vor_json_document(&text, &document);
    expect(BEFORE "\"sales\":1}");
}

VT_TEST(a_word_past_the_last_is_null)
{
    struct basket basket = basket_of(0);
    struct vor_document document = {"basket", &basket_members, &basket};

    basket.flavour = (enum flavour)2;
    vor_text_init(&text, 0);
    vor_json_document(&text, &document);
    ck_assert_ptr_nonnull(strstr(text.data, "\"flavour\":null,"));
    vor_text_free(&text);
}

VT_TEST(the_schema_names_every_member_with_its_unit)
{
    vor_text_init(&text, 0);
    vor_json_begin_object(&text);
    vor_json_members_schema(&text, &basket_members);
    vor_json_end_object(&text);
    vt_assert_ok(vor_json_scan(text.data, text.size, &vt_err));
    expect("{\"type\":\"object\",\"required\":[\"held\",\"size\",\"flavour\",\"first\",\"others\","
           "\"sales\"],\"properties\":{"
           "\"held\":{\"type\":\"integer\",\"minimum\":0,\"description\":\"How many it holds\","
           "\"x-unit\":\"fruits\"},"
           "\"size\":{\"type\":\"object\",\"required\":[\"x\",\"y\",\"z\",\"handles\"],"
           "\"properties\":{"
           "\"x\":{\"type\":\"number\",\"nullable\":true,\"description\":\"How large it is\","
           "\"x-unit\":\"m\"},"
           "\"y\":{\"type\":\"number\",\"nullable\":true,\"description\":\"How large it is\","
           "\"x-unit\":\"m\"},"
           "\"z\":{\"type\":\"number\",\"nullable\":true,\"description\":\"How large it is\","
           "\"x-unit\":\"m\"},"
           "\"handles\":{\"type\":\"integer\",\"minimum\":0,\"description\":\"Handles\"}}},"
           "\"flavour\":{\"type\":\"string\",\"enum\":[\"sweet\",\"sour\"],"
           "\"description\":\"What it tastes of\"},"
           "\"first\":{\"type\":\"object\",\"required\":[\"seeds\",\"weight\"],\"properties\":{"
           "\"seeds\":{\"type\":\"integer\",\"minimum\":0,\"description\":\"Seeds in it\"},"
           "\"weight\":{\"type\":\"number\",\"nullable\":true,\"description\":\"Its weight\","
           "\"x-unit\":\"g\"}},\"description\":\"The one on top\"},"
           "\"others\":{\"type\":\"array\",\"items\":{\"type\":\"object\","
           "\"required\":[\"seeds\",\"weight\"],\"properties\":{"
           "\"seeds\":{\"type\":\"integer\",\"minimum\":0,\"description\":\"Seeds in it\"},"
           "\"weight\":{\"type\":\"number\",\"nullable\":true,\"description\":\"Its weight\","
           "\"x-unit\":\"g\"}}},\"description\":\"The ones below\"},"
           "\"sale\":{\"type\":\"object\",\"description\":\"Only once it is sold\","
           "\"required\":[\"price\",\"day\"],\"properties\":{"
           "\"price\":{\"type\":\"number\",\"nullable\":true,\"description\":\"What it brought\","
           "\"x-unit\":\"EUR\"},"
           "\"day\":{\"type\":\"integer\",\"minimum\":0,\"description\":\"When\"}}},"
           "\"sales\":{\"type\":\"integer\",\"minimum\":0,"
           "\"description\":\"Begins like the object before it\"}}}");
}

/* Numbers and words only: what is read back and what is a line of CSV. */
#define CRATE_TABLE(X)                                                                             \
    X(U32, rows, "rows", "", "Rows")                                                               \
    X(U64, bytes, "bytes", "", "Bytes")                                                            \
    X(REAL, height, "height", "m", "Height")                                                       \
    X(FLAVOUR, flavour, "flavour", "", "Flavour")

struct crate {
    CRATE_TABLE(VOR_FIELD)
};

static const struct vor_member crate_rows[] = {
#define CRATE_ROW(...) VOR_MEMBER(struct crate, __VA_ARGS__)
    CRATE_TABLE(CRATE_ROW)
#undef CRATE_ROW
};

static const struct vor_members crate_members = VOR_MEMBERS(struct crate, crate_rows);

static struct crate read_crate(const char *json)
{
    struct vor_json *parsed = vt_json(json);
    struct crate crate;

    memset(&crate, 0xff, sizeof crate);
    vor_json_members_read(&crate, &crate_members, parsed);
    vor_json_free(parsed);
    return crate;
}

VT_TEST(members_come_back)
{
    struct crate crate = read_crate("{\"flavour\":\"sour\",\"height\":-0.1,\"bytes\":"
                                    "9007199254740991,\"other\":[],\"rows\":4294967295}");

    ck_assert_uint_eq(crate.rows, 4294967295u);
    ck_assert_uint_eq(crate.bytes, 9007199254740991u);
    ck_assert_double_eq(crate.height, -0.1);
    ck_assert_int_eq(crate.flavour, SOUR);
}

VT_TEST(what_is_missing_or_wrong_is_nothing)
{
    static const char *const wrong[] = {"{}", "[]", "{\"rows\":-1,\"bytes\":1e16,\"height\":\"1\"}",
                                        "{\"rows\":4294967296,\"bytes\":null,\"height\":[]}"};

    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        struct crate crate = read_crate(wrong[i]);

        ck_assert(crate.rows == 0 && crate.bytes == 0 && crate.height == 0);
        ck_assert_int_eq(crate.flavour, SWEET);
    }
    ck_assert_int_eq(read_crate("{\"flavour\":\"salty\"}").flavour, 2);
    ck_assert_int_eq(read_crate("{\"flavour\":null}").flavour, 2);
    ck_assert_int_eq(read_crate("{\"flavour\":1}").flavour, 2);
}

VT_TEST(a_number_that_is_not_finite_stays_so)
{
    struct crate crate = {.height = (double)INFINITY};

    vor_text_init(&text, 0);
    vor_json_begin_object(&text);
    vor_json_members(&text, &crate_members, &crate);
    vor_json_end_object(&text);
    ck_assert(isnan(read_crate(text.data).height));
    vor_text_free(&text);
}

VT_TEST(a_line_of_the_table_has_a_column_for_each_member)
{
    struct crate crate = {3, 10000000000000001u, 0.1, SOUR};

    vor_text_init(&text, 0);
    vor_csv_head(&text, &crate_members);
    vor_csv_line(&text, &crate_members, &crate);
    crate.height = (double)NAN;
    crate.flavour = (enum flavour)7;
    vor_csv_line(&text, &crate_members, &crate);
    expect("rows,bytes,height,flavour\n3,10000000000000001,0.1,sour\n3,10000000000000001,,\n");
}
