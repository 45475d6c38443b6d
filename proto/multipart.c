#include "proto/multipart.h"

#include "core/base/quote.h"

#include <assert.h>
#include <string.h>
#include <strings.h>

enum { SHOWN_SIZE = 40 }; /* of bytes from outside in a message */

static vor_status refuse(struct vor_error *err, uint64_t offset, const char *what)
{
    (void)vor_fail(err, VOR_E_REQUEST, "the form is malformed: %s", what);
    return vor_fail_at(err, VOR_E_REQUEST, offset);
}

static vor_status refuse_byte(const struct vor_multipart *scanner, struct vor_error *err,
                              const char *what, char byte)
{
    (void)vor_fail(err, VOR_E_REQUEST, "the form is malformed: %s, got \"%s\"", what,
                   VOR_QUOTED(8, &byte, 1));
    return vor_fail_at(err, VOR_E_REQUEST, scanner->offset);
}

/* --- parameters of a header value: ; NAME=VALUE ; NAME="VALUE" -------------------------------- */

struct parameter {
    char name[16]; /* "" when it is longer than any that counts */
    char value[VOR_MULTIPART_NAME_MAX * 2];
    size_t length; /* of the value, also when it was cut to fit */
};

static int is_token_byte(char c)
{
    return c > ' ' && c < 0x7f && strchr("()<>@,;:\\\"/[]?=", c) == NULL;
}

static const char *skip_blanks(const char *at)
{
    return at + strspn(at, " \t");
}

static void put_byte(struct parameter *out, char c)
{
    if (out->length < sizeof out->value - 1)
        out->value[out->length] = c;
    out->length++;
}

/* Behind a quoted value, NULL when its quote never ends. Browsers write a quote within as %22,
 * others as \"; a backslash before anything else is one, as in the paths of old browsers. */
static const char *read_quoted(const char *at, struct parameter *out)
{
    for (at++; *at != '"'; at++) {
        if (*at == '\\' && (at[1] == '"' || at[1] == '\\'))
            at++;
        if (*at == '\0')
            return NULL;
        put_byte(out, *at);
    }
    return at + 1;
}

/* Reads the parameter at *at, which then stands behind it; 0 when there is none left, -1 when what
 * stands there is no parameter. A value without quotes goes to the next ';' or blank: it should be
 * a token, but clients write boundaries with '/', ':', '=' and '?' that way. */
static int next_parameter(const char **at, struct parameter *out)
{
    const char *name, *p = skip_blanks(*at);
    size_t length;

    memset(out, 0, sizeof *out);
    if (*p == '\0')
        return 0;
    if (*p != ';')
        return -1;
    p = name = skip_blanks(p + 1);
    if (*p == '\0')
        return 0; /* some end with a semicolon */
    while (is_token_byte(*p))
        p++;
    length = (size_t)(p - name);
    if (length == 0 || *p != '=')
        return -1;
    if (length < sizeof out->name)
        memcpy(out->name, name, length);
    p++;
    if (*p == '"')
        p = read_quoted(p, out);
    else
        while (strchr("; \t\"", *p) == NULL) /* strchr finds the NUL as well */
            put_byte(out, *p++);
    if (p == NULL)
        return -1;
    *at = p;
    return 1;
}

/* Behind a word, in any case, that ends there; NULL when it is another one. */
static const char *behind_word(const char *text, const char *word)
{
    size_t length = strlen(word);

    text = skip_blanks(text);
    if (strncasecmp(text, word, length) != 0 || strchr("; \t", text[length]) == NULL)
        return NULL; /* strchr finds the NUL as well */
    return text + length;
}

/* --- beginning -------------------------------------------------------------------------------- */

int vor_multipart_is_form(const char *content_type)
{
    return behind_word(content_type, "multipart/form-data") != NULL;
}

/* How many boundaries the parameters of a Content-Type have, -1 when they cannot be read; *out is
 * the last one. */
static int find_boundary(const char *at, struct parameter *out)
{
    struct parameter next;
    int read, found = 0;

    while ((read = next_parameter(&at, &next)) > 0)
        if (strcasecmp(next.name, "boundary") == 0) {
            *out = next;
            found++;
        }
    return read < 0 ? -1 : found;
}

vor_status vor_multipart_begin(struct vor_multipart *scanner, const char *content_type,
                               const struct vor_multipart_events *events, struct vor_error *err)
{
    static const char allowed[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789'()+_,-./:=? ";
    const char *at = behind_word(content_type, "multipart/form-data");
    struct parameter boundary = {.length = 0};
    int found;

    assert(at != NULL);
    found = find_boundary(at, &boundary);
    if (found != 1)
        return vor_fail(err, VOR_E_REQUEST,
                        "Content-Type has %s, want a boundary of 1 to %d characters",
                        found < 0    ? "parameters that cannot be read"
                        : found == 0 ? "no boundary"
                                     : "more than one boundary",
                        VOR_MULTIPART_BOUNDARY_MAX);
    if (boundary.length < 1 || boundary.length > VOR_MULTIPART_BOUNDARY_MAX ||
        strspn(boundary.value, allowed) != boundary.length ||
        boundary.value[boundary.length - 1] == ' ')
        return vor_fail(
            err, VOR_E_REQUEST,
            "the boundary \"%s\" of %zu characters is invalid, want 1 to %d characters: letters, "
            "digits, '()+_,-./:=? and blanks, but no blank at the end",
            VOR_QUOTED(SHOWN_SIZE, boundary.value, strlen(boundary.value)), boundary.length,
            VOR_MULTIPART_BOUNDARY_MAX);
    memset(scanner, 0, sizeof *scanner);
    scanner->events = *events;
    memcpy(scanner->delimiter, "\r\n--", 4);
    memcpy(scanner->delimiter + 4, boundary.value, boundary.length);
    scanner->delimiter_size = 4 + boundary.length;
    scanner->matched = 2; /* the body begins as if behind a line end */
    return VOR_OK;
}

/* --- heads ------------------------------------------------------------------------------------ */

static const char *take_coding(struct vor_multipart *scanner, const char *value)
{
    size_t length;

    value = skip_blanks(value);
    length = strlen(value);
    while (length > 0 && strchr(" \t", value[length - 1]) != NULL)
        length--;
    if (scanner->coding[0] != '\0' || length == 0 || length > VOR_MULTIPART_NAME_MAX)
        return "a part's Content-Encoding is empty, too long, or not the only one";
    memcpy(scanner->coding, value, length);
    scanner->coding[length] = '\0';
    return NULL;
}

/* What is wrong with a header line; NULL for nothing. */
static const char *take_line(struct vor_multipart *scanner)
{
    char *line = scanner->line, *p = line;

    line[scanner->line_size] = '\0';
    while (is_token_byte(*p))
        p++;
    if (p == line || *p != ':')
        return "a header line of a part is not NAME: VALUE";
    *p++ = '\0';
    if (strcasecmp(line, "Content-Disposition") == 0) {
        const char *at = behind_word(p, "form-data"), *wrong = NULL;
        struct parameter parameter;
        int read = 0;

        /* What is wrong with a Content-Disposition; NULL for nothing. */
        if (scanner->has_disposition++)
            return "a part has two Content-Dispositions";
        if (at == NULL)
            return "a part's Content-Disposition is not form-data";
        while (wrong == NULL && (read = next_parameter(&at, &parameter)) > 0) {
            int is_plain = strcasecmp(parameter.name, "filename") == 0;

            if (strcasecmp(parameter.name, "name") == 0) {
                if (scanner->name[0] != '\0')
                    wrong = "a part has two names";
                else if (parameter.length == 0 || parameter.length > VOR_MULTIPART_NAME_MAX)
                    wrong = "a part's name is empty or longer than 64 characters";
                else
                    memcpy(scanner->name, parameter.value, parameter.length + 1);
            }
            if (is_plain || strcasecmp(parameter.name, "filename*") == 0)
                scanner->is_file = 1;
            if (is_plain)
                scanner->is_unnamed = parameter.length == 0;
        }
        return read < 0 ? "a part's Content-Disposition cannot be read" : wrong;
    }
    if (strcasecmp(line, "Content-Encoding") == 0)
        return take_coding(scanner, p);
    if (strcasecmp(line, "Content-Transfer-Encoding") == 0) {
        /* Base64 and quoted-printable are for mail; RFC 7578, 4.7 has none of them. */
        if (behind_word(p, "binary") != NULL || behind_word(p, "8bit") != NULL ||
            behind_word(p, "7bit") != NULL)
            return NULL;
        return "a part's Content-Transfer-Encoding is none of binary, 8bit and 7bit";
    }
    return NULL;
}

/* --- a byte in each state, but for those of data -----------------------------------------------
 */

static vor_status at_start(struct vor_multipart *scanner, char c, struct vor_error *err)
{
    if (scanner->offset == 0 && c == '\r')
        scanner->matched = 0;
    if (c != scanner->delimiter[scanner->matched])
        return refuse_byte(scanner, err, "it does not begin with -- and the boundary", c);
    if (++scanner->matched == scanner->delimiter_size)
        scanner->state = VOR_MULTIPART_MARK;
    return VOR_OK;
}

static vor_status at_mark(struct vor_multipart *scanner, char c, struct vor_error *err)
{
    switch (c) {
    case ' ':
    case '\t': /* padding that gateways may add */
        return VOR_OK;
    case '-':
        scanner->state = VOR_MULTIPART_DASH;
        return VOR_OK;
    case '\r':
        scanner->state = VOR_MULTIPART_BREAK;
        return VOR_OK;
    default:
        return refuse_byte(scanner, err, "want a line end or -- after a boundary", c);
    }
}

static vor_status at_dash(struct vor_multipart *scanner, char c, struct vor_error *err)
{
    if (c != '-')
        return refuse_byte(scanner, err, "want a line end or -- after a boundary", c);
    scanner->state = VOR_MULTIPART_CLOSED;
    scanner->matched = 0;
    return VOR_OK;
}

static vor_status at_break(struct vor_multipart *scanner, char c, struct vor_error *err)
{
    if (c != '\n')
        return refuse_byte(scanner, err, "want LF after CR", c);
    scanner->state = VOR_MULTIPART_LINE;
    scanner->head_size = scanner->line_size = 0;
    scanner->has_disposition = scanner->is_file = scanner->is_unnamed = 0;
    scanner->name[0] = scanner->coding[0] = '\0';
    return VOR_OK;
}

static vor_status refuse_head(const struct vor_multipart *scanner, struct vor_error *err)
{
    return refuse(err, scanner->offset, "the header lines of a part have more than 4096 bytes");
}

static vor_status at_line(struct vor_multipart *scanner, char c, struct vor_error *err)
{
    if (++scanner->head_size > VOR_MULTIPART_HEAD_MAX)
        return refuse_head(scanner, err);
    if (c == '\r') {
        scanner->state = VOR_MULTIPART_LINE_CR;
        return VOR_OK;
    }
    if (((unsigned char)c < 0x20 && c != '\t') || c == 0x7f)
        return refuse_byte(scanner, err, "a header line of a part has a control character", c);
    scanner->line[scanner->line_size++] = c;
    return VOR_OK;
}

static vor_status at_line_cr(struct vor_multipart *scanner, char c, struct vor_error *err)
{
    const char *wrong;

    if (c != '\n')
        return refuse_byte(scanner, err, "want LF after CR", c);
    if (++scanner->head_size > VOR_MULTIPART_HEAD_MAX)
        return refuse_head(scanner, err);
    if (scanner->line_size == 0) {
        const struct vor_multipart_part part = {.name = scanner->name,
                                                .is_file = scanner->is_file,
                                                .is_unnamed = scanner->is_unnamed,
                                                .coding = scanner->coding};

        if (scanner->name[0] == '\0')
            return refuse(err, scanner->offset, "a part has no Content-Disposition with a name");
        if (++scanner->parts > VOR_MULTIPART_PARTS_MAX)
            return refuse(err, scanner->offset, "it has more than 32 parts");
        scanner->state = VOR_MULTIPART_DATA;
        scanner->matched = scanner->implied = 2; /* a boundary may follow at once */
        return scanner->events.part(scanner->events.ctx, &part, err);
    }
    wrong = take_line(scanner);
    if (wrong != NULL)
        return refuse(err, scanner->offset, wrong);
    scanner->line_size = 0;
    scanner->state = VOR_MULTIPART_LINE;
    return VOR_OK;
}

/* One line end may follow the last boundary, and blanks before it. */
static vor_status at_closed(struct vor_multipart *scanner, char c, struct vor_error *err)
{
    if (scanner->matched == 0 && (c == ' ' || c == '\t'))
        return VOR_OK;
    if (scanner->matched < 2 && c == scanner->delimiter[scanner->matched]) {
        scanner->matched++;
        return VOR_OK;
    }
    return refuse_byte(scanner, err, "want nothing after the last boundary", c);
}

/* --- data ------------------------------------------------------------------------------------- */

static vor_status tell_data(struct vor_multipart *scanner, const char *bytes, size_t size,
                            struct vor_error *err)
{
    return size > 0 ? scanner->events.data(scanner->events.ctx, bytes, size, err) : VOR_OK;
}

/* Takes data up to a boundary or to the end of the piece; *used says how much that was. A boundary
 * has one CR, its first byte, so after a mismatch nothing but the byte at hand can begin another.
 * Data is told in at most two calls, however many CRs there are in it. */
static vor_status take_data(struct vor_multipart *scanner, const char *at, size_t left,
                            size_t *used, struct vor_error *err)
{
    size_t before = scanner->matched, i = 0; /* before: of the boundary, in pieces before this */
    vor_status status = VOR_OK;

    while (i < left && scanner->matched < scanner->delimiter_size && status == VOR_OK) {
        const char *cr;

        if (at[i] == scanner->delimiter[scanner->matched]) {
            scanner->matched++;
            i++;
        } else if (scanner->matched > 0) {
            size_t implied = scanner->implied;

            /* The bytes of a boundary that did not come to its end are data. They lay in pieces
             * before, so they are told from the boundary itself; but not the line end of the head,
             * which was none. */
            scanner->implied = 0;
            status = before > implied
                         ? tell_data(scanner, scanner->delimiter + implied, before - implied, err)
                         : VOR_OK;
            before = scanner->matched = 0;
        } else {
            cr = memchr(at + i, '\r', left - i);
            i = cr != NULL ? (size_t)(cr - at) : left;
        }
    }
    *used = i;
    VOR_THEN(status, tell_data(scanner, at, i - (scanner->matched - before), err));
    if (status != VOR_OK || scanner->matched < scanner->delimiter_size)
        return status;
    scanner->state = VOR_MULTIPART_MARK;
    return scanner->events.end(scanner->events.ctx, err);
}

vor_status vor_multipart_feed(struct vor_multipart *scanner, const void *bytes, size_t size,
                              struct vor_error *err)
{
    static vor_status (*const steps[])(struct vor_multipart *, char, struct vor_error *) = {
        [VOR_MULTIPART_START] = at_start,   [VOR_MULTIPART_MARK] = at_mark,
        [VOR_MULTIPART_DASH] = at_dash,     [VOR_MULTIPART_BREAK] = at_break,
        [VOR_MULTIPART_LINE] = at_line,     [VOR_MULTIPART_LINE_CR] = at_line_cr,
        [VOR_MULTIPART_CLOSED] = at_closed,
    };
    const char *at = bytes, *end = at + size;
    vor_status status = VOR_OK;

    while (at < end && status == VOR_OK) {
        size_t used = 1;

        status = scanner->state == VOR_MULTIPART_DATA
                     ? take_data(scanner, at, (size_t)(end - at), &used, err)
                     : steps[scanner->state](scanner, *at, err);
        at += used;
        scanner->offset += used;
    }
    return status;
}

vor_status vor_multipart_finish(const struct vor_multipart *scanner, struct vor_error *err)
{
    /* A CR behind the last boundary whose LF did not come is a body cut short as well. */
    if (scanner->state == VOR_MULTIPART_CLOSED && scanner->matched != 1)
        return VOR_OK;
    return refuse(err, scanner->offset, "it ends without a last boundary");
}
