/* Forms taken apart as they arrive: what comes out, what is refused and where, in pieces of any
 * size. */
#include "proto/multipart.h"
#include "tests/support/vt.h"

#include <stdio.h>
#include <string.h>

#define TYPE "multipart/form-data; boundary=XyZ"
#define FIELD "--XyZ\r\nContent-Disposition: form-data; name=\"points\"\r\n\r\n100\r\n"
#define FILE_HEAD                                                                                  \
    "--XyZ\r\nContent-Disposition: form-data; name=\"cloud\"; filename=\"a.ply\"\r\n"              \
    "Content-Type: application/octet-stream\r\n\r\n"
#define END "--XyZ--\r\n"

/* Everything that was told, as text: "part points text\ndata 100\nend\n". */
struct told {
    char text[8192];
    size_t size;
    int in_data;
};

static void say(struct told *told, const char *bytes, size_t size)
{
    ck_assert_uint_lt(told->size + size, sizeof told->text);
    memcpy(told->text + told->size, bytes, size);
    told->size += size;
    told->text[told->size] = '\0';
}

static vor_status on_part(void *ctx, const struct vor_multipart_part *part, struct vor_error *err)
{
    char line[256];
    int length = snprintf(line, sizeof line, "[%s %s %s]", part->name,
                          part->is_unnamed ? "unnamed"
                          : part->is_file  ? "file"
                                           : "text",
                          part->coding);

    (void)err;
    say(ctx, line, (size_t)length);
    return VOR_OK;
}

static vor_status on_data(void *ctx, const void *bytes, size_t size, struct vor_error *err)
{
    ck_assert_uint_gt(size, 0);
    if (memchr(bytes, '!', size) != NULL)
        return vor_fail(err, VOR_E_PARAM, "a mark that the reader does not like");
    say(ctx, bytes, size);
    return VOR_OK;
}

static vor_status on_end(void *ctx, struct vor_error *err)
{
    (void)err;
    say(ctx, "|", 1);
    return VOR_OK;
}

static vor_status scan(struct told *told, const char *type, const char *body, size_t size,
                       size_t piece)
{
    const struct vor_multipart_events events = {told, on_part, on_data, on_end};
    static struct vor_multipart scanner;
    vor_status status;

    told->size = 0;
    told->text[0] = '\0';
    memset(&vt_err, 0, sizeof vt_err);
    status = vor_multipart_begin(&scanner, type, &events, &vt_err);
    for (size_t at = 0; at < size && status == VOR_OK; at += piece)
        status =
            vor_multipart_feed(&scanner, body + at, size - at < piece ? size - at : piece, &vt_err);
    return status == VOR_OK ? vor_multipart_finish(&scanner, &vt_err) : status;
}

/* Vector: bodies as clients send them, and what they come to. */
static const struct {
    const char *type, *body, *want;
} sound[] = {
    {TYPE, FIELD END, "[points text ]100|"},
    {TYPE, FIELD FILE_HEAD "ply\r\n\r\n" END, "[points text ]100|[cloud file ]ply\r\n|"},
    {TYPE, FILE_HEAD "\r\n" FIELD END, "[cloud file ]|[points text ]100|"},
    {TYPE, FILE_HEAD END, "[cloud file ]|"}, /* not a byte, not even a line end */
    {TYPE, END, ""},
    {TYPE, "\r\n" FIELD END, "[points text ]100|"}, /* a line end before, as some send it */
    {TYPE, FIELD "--XyZ--", "[points text ]100|"},  /* none behind */
    {TYPE, FIELD "--XyZ-- \t\r\n", "[points text ]100|"},
    {TYPE, "--XyZ \t\r\n" /* padding */ "content-disposition:form-data;name=a\r\n\r\nb\r\n" END,
     "[a text ]b|"},
    {"Multipart/Form-Data;charset=utf-8; BOUNDARY=\"XyZ\"", FIELD END, "[points text ]100|"},
    {"multipart/form-data; boundary=a/b:c=d?e", "--a/b:c=d?e--", ""},
    {TYPE, "--XyZ\r\nContent-Disposition: form-data; filename=\"\"; name=reference\r\n\r\n\r\n" END,
     "[reference unnamed ]|"},
    {TYPE,
     "--XyZ\r\nContent-Disposition: form-data; name=\"a\\\"b\"; filename=\"C:\\x\\y.ply\"\r\n"
     "Content-Encoding: gzip \r\nContent-Transfer-Encoding: binary\r\n\r\nx\r\n" END,
     "[a\"b file gzip]x|"},
    {TYPE,
     "--XyZ\r\nContent-Disposition: form-data; name=a; "
     "filename*=UTF-8''x%20y.ply;\r\n\r\nx\r\n" END,
     "[a file ]x|"},
    /* What looks like a boundary for a while. */
    {TYPE, FILE_HEAD "\r\n--Xy\r\n--\r\r\r\n\n--XyZ\r\n-XyZ\r\n" END,
     "[cloud file ]\r\n--Xy\r\n--\r\r\r\n\n--XyZ\r\n-XyZ|"},
    {TYPE, FILE_HEAD "--Xy\r\n\r\n--Xy\r\r\n" END, "[cloud file ]--Xy\r\n\r\n--Xy\r|"},
};

VT_TEST_LOOP(a_form_comes_to_its_parts_in_pieces_of_any_size, sizeof sound / sizeof sound[0])
{
    static struct told told;
    size_t size = strlen(sound[_i].body);

    for (size_t piece = 1; piece <= size; piece++) {
        vt_assert_ok(scan(&told, sound[_i].type, sound[_i].body, size, piece));
        ck_assert_msg(strcmp(told.text, sound[_i].want) == 0, "case %d in pieces of %zu: %s", _i,
                      piece, told.text);
    }
}

#define DISPOSED(rest) "--XyZ\r\nContent-Disposition: " rest "\r\n\r\nx\r\n" END

/* Refusal: which words the message has, and where the fault is. */
static const struct {
    const char *type, *body, *words;
    int64_t offset; /* -1: any */
} bad[] = {
    {"multipart/form-data", "", "no boundary", -1},
    {"multipart/form-data; boundary=\"\"", "", "of 0 characters", -1},
    {"multipart/form-data; boundary=a; boundary=b", "", "more than one", -1},
    {"multipart/form-data; boundary=\"a", "", "cannot be read", -1},
    {"multipart/form-data boundary=a", "", "cannot be read", -1},
    {"multipart/form-data; boundary=\"a \"", "", "is invalid", -1},
    {"multipart/form-data; boundary=\"a@b\"", "", "is invalid", -1},
    {"multipart/form-data; boundary="
     "1234567890123456789012345678901234567890123456789012345678901234567890a",
     "", "of 71 characters", -1},
    {TYPE, "", "ends without a last boundary", 0},
    {TYPE, "ply\n", "does not begin", 0},
    {TYPE, "\n" FIELD END, "does not begin", 0},
    {TYPE, "\r\n\r\n" FIELD END, "does not begin", 2},
    {TYPE, "a preamble\r\n" FIELD END, "does not begin", 0},
    {TYPE, "--Xyz\r\n", "does not begin", 4},
    {TYPE, "--XyZ", "ends without a last boundary", 5},
    {TYPE, "--XyZ-", "ends without a last boundary", 6},
    {TYPE, "--XyZ--\r", "ends without a last boundary", 8},
    {TYPE, FIELD, "ends without a last boundary", -1},
    {TYPE, FIELD "--XyZ\r\n", "ends without a last boundary", -1},
    {TYPE, "--XyZx\r\n", "want a line end or --", 5},
    {TYPE, "--XyZ-x", "want a line end or --", 6},
    {TYPE, "--XyZ\n", "want a line end or --", 5},
    {TYPE, "--XyZ\rx", "want LF", 6},
    {TYPE, END "x", "nothing after", 9},
    {TYPE, "--XyZ--x", "nothing after", 7},
    {TYPE, END "\r\n", "nothing after", 9},
    {TYPE, "--XyZ\r\n\r\nx\r\n" END, "no Content-Disposition", 8},
    {TYPE, "--XyZ\r\nContent-Type: text/plain\r\n\r\nx\r\n" END, "no Content-Disposition", -1},
    {TYPE, DISPOSED("form-data"), "no Content-Disposition with a name", -1},
    {TYPE, DISPOSED("form-data; filename=a"), "no Content-Disposition with a name", -1},
    {TYPE, DISPOSED("attachment; name=a"), "not form-data", -1},
    {TYPE, DISPOSED("form-datax; name=a"), "not form-data", -1},
    {TYPE, DISPOSED("form-data; name=\"a"), "cannot be read", -1},
    {TYPE, DISPOSED("form-data; name"), "cannot be read", -1},
    {TYPE, DISPOSED("form-data; =a"), "cannot be read", -1},
    {TYPE, DISPOSED("form-data; name=\"a\"b"), "cannot be read", -1},
    {TYPE, DISPOSED("form-data; name=\"\""), "is empty", -1},
    {TYPE, DISPOSED("form-data; name=a; name=b"), "two names", -1},
    {TYPE,
     DISPOSED("form-data; "
              "name=12345678901234567890123456789012345678901234567890123456789012345"),
     "longer than 64", -1},
    {TYPE, DISPOSED("form-data; name=a\r\nContent-Disposition: form-data; name=b"), "two Content",
     -1},
    {TYPE, DISPOSED("form-data; name=a\r\nno colon"), "is not NAME: VALUE", -1},
    {TYPE, DISPOSED("form-data; name=a\r\n folded: b"), "is not NAME: VALUE", -1},
    {TYPE, DISPOSED("form-data; name=a\r\nA : b"), "is not NAME: VALUE", -1},
    {TYPE, DISPOSED("form-data; name=a\r\nX: a\001b"), "control character", -1},
    {TYPE, DISPOSED("form-data; name=a\nX: b"), "control character", -1},
    {TYPE, DISPOSED("form-data; name=a\rX: b"), "want LF", -1},
    {TYPE, DISPOSED("form-data; name=a\r\nContent-Encoding: "), "Content-Encoding", -1},
    {TYPE, DISPOSED("form-data; name=a\r\nContent-Encoding: gzip\r\nContent-Encoding: gzip"),
     "Content-Encoding", -1},
    {TYPE, DISPOSED("form-data; name=a\r\nContent-Transfer-Encoding: base64"), "Transfer-Encoding",
     -1},
};

VT_TEST_LOOP(what_is_no_form_is_refused_at_the_same_byte_in_pieces_of_any_size,
             sizeof bad / sizeof bad[0])
{
    static struct told told, whole;
    size_t size = strlen(bad[_i].body);
    struct vor_error first;

    vt_assert_fails(VOR_E_REQUEST, scan(&whole, bad[_i].type, bad[_i].body, size, size + 1));
    first = vt_err;
    ck_assert_msg(strstr(first.message, bad[_i].words) != NULL, "case %d: %s", _i, first.message);
    ck_assert_msg(bad[_i].offset < 0 || first.byte_offset == bad[_i].offset, "case %d: at %lld", _i,
                  (long long)first.byte_offset);
    for (size_t piece = 1; piece <= size; piece++) {
        vt_assert_fails(VOR_E_REQUEST, scan(&told, bad[_i].type, bad[_i].body, size, piece));
        ck_assert_str_eq(vt_err.message, first.message);
        ck_assert_int_eq(vt_err.byte_offset, first.byte_offset);
        ck_assert_str_eq(told.text, whole.text);
    }
}

/* Refusal: the limits, at the last that is allowed and one beyond. */
VT_TEST(parts_and_heads_are_bounded)
{
    static const char part[] = "--XyZ\r\nContent-Disposition: form-data; name=a\r\n\r\n\r\n";
    static struct told told;
    static char body[16384];

    for (int parts = 32; parts <= 33; parts++) {
        body[0] = '\0';
        for (int i = 0; i < parts; i++)
            strcat(body, part);
        strcat(body, END);
        ck_assert_int_eq(scan(&told, TYPE, body, strlen(body), 100),
                         parts == 32 ? VOR_OK : VOR_E_REQUEST);
    }
    ck_assert_ptr_nonnull(strstr(vt_err.message, "more than 32 parts"));
    for (int more = 0; more <= 1; more++) {
        int length = 4096 - (int)strlen("Content-Disposition: form-data; name=a\r\n\r\nX: \r\n");

        (void)snprintf(body, sizeof body,
                       "--XyZ\r\nContent-Disposition: form-data; name=a\r\nX: %0*d\r\n\r\n\r\n" END,
                       length + more, 0);
        ck_assert_int_eq(scan(&told, TYPE, body, strlen(body), 100), more ? VOR_E_REQUEST : VOR_OK);
    }
    ck_assert_ptr_nonnull(strstr(vt_err.message, "more than 4096 bytes"));
}

VT_TEST(a_failure_of_the_reader_ends_the_feed)
{
    static const char body[] = FILE_HEAD "abc!def\r\n" FIELD END;
    static struct told told;

    vt_assert_fails(VOR_E_PARAM, scan(&told, TYPE, body, strlen(body), strlen(body)));
    ck_assert_str_eq(told.text, "[cloud file ]");
    vt_assert_fails(VOR_E_PARAM, scan(&told, TYPE, body, strlen(body), 1));
    ck_assert_str_eq(told.text, "[cloud file ]abc");
}

/* The next number of a seed below a bound. */
static size_t draw(int seed, uint64_t bound)
{
    static uint64_t index;

    return (size_t)vor_rng_below((uint64_t)seed, 0, index++, bound);
}

/* A part with a file of random bits of boundaries, none of which is whole; and what it comes to. */
static void add_part(int seed, char *body, char *want)
{
    static const char *const bits[] = {"\r",     "\n",    "-",        "--",         "\r\n",
                                       "\r\n--", "Xy",    "\r\n--Xy", "X",          "a",
                                       "\r\r",   "\r\n-", "--Xy",     "\r\r\n--Xy", "\r\n\r"};

    strcat(body, FILE_HEAD);
    strcat(want, "[cloud file ]");
    for (size_t left = draw(seed, 200); left > 0; left--) {
        const char *bit = bits[draw(seed, sizeof bits / sizeof bits[0])];

        strcat(body, bit);
        strcat(want, bit);
    }
    strcat(body, "\r\n");
    strcat(want, "|");
}

VT_TEST_LOOP(random_parts_come_back_in_random_pieces, 200)
{
    static char body[8192], want[8192];
    static struct vor_multipart scanner;
    static struct told told;
    const struct vor_multipart_events events = {&told, on_part, on_data, on_end};
    size_t size, piece;

    body[0] = want[0] = '\0';
    for (int part = 0; part < 3; part++)
        add_part(_i, body, want);
    strcat(body, END);
    size = strlen(body);
    told.size = 0;
    vt_assert_ok(vor_multipart_begin(&scanner, TYPE, &events, &vt_err));
    for (size_t at = 0; at < size; at += piece) {
        piece = 1 + draw(_i, 40);
        piece = piece < size - at ? piece : size - at;
        vt_assert_ok(vor_multipart_feed(&scanner, body + at, piece, &vt_err));
    }
    vt_assert_ok(vor_multipart_finish(&scanner, &vt_err));
    ck_assert_str_eq(told.text, want);
}

VT_TEST(a_form_is_told_by_its_media_type)
{
    ck_assert(vor_multipart_is_form("multipart/form-data"));
    ck_assert(vor_multipart_is_form(" MULTIPART/form-data ;boundary=a"));
    ck_assert(!vor_multipart_is_form("multipart/form-data2"));
    ck_assert(!vor_multipart_is_form("multipart/mixed; boundary=a"));
    ck_assert(!vor_multipart_is_form("application/x-www-form-urlencoded"));
    ck_assert(!vor_multipart_is_form(""));
}
