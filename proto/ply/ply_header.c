#include "proto/ply/ply_header.h"

#include "core/base/quote.h"

#include <string.h>
#include <strings.h>

enum { WORDS_MAX = 6, SHOWN = 48 };

struct word {
    const char *at;
    size_t length;
};

/* One line of the header without its end, cut into words. */
struct line {
    const char *at;
    size_t length, offset;
    unsigned words; /* WORDS_MAX when there are that many or more */
    struct word word[WORDS_MAX];
};

struct scan {
    const uint8_t *bytes;
    size_t size;  /* of the part of the file a header may take */
    size_t at;    /* where the next line begins */
    int cut;      /* size is the limit, not the end of the file */
    uint8_t stop; /* what ends a line: '\n', or '\r' in files of the old Macintosh */
    int has_format;
};

static int is_blank(char c)
{
    return c == ' ' || c == '\t';
}

/* Where the word "ply" begins: behind a byte order mark, if there is one. */
static size_t find_begin(const uint8_t *bytes, size_t size)
{
    return size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
}

/* Where the first line ends: size where it is not "ply". */
static size_t magic_end(const uint8_t *bytes, size_t size)
{
    size_t at = find_begin(bytes, size);

    if (size - at < 3 || memcmp(bytes + at, "ply", 3) != 0)
        return size;
    for (at += 3; at < size && is_blank((char)bytes[at]);)
        at++;
    return at < size && (bytes[at] == '\n' || bytes[at] == '\r') ? at : size;
}

int vor_ply_is(const uint8_t *bytes, size_t size)
{
    return magic_end(bytes, size) < size;
}

uint8_t vor_ply_line_stop(const uint8_t *bytes, size_t size)
{
    size_t at = magic_end(bytes, size);

    return at < size && bytes[at] == '\r' && (at + 1 == size || bytes[at + 1] != '\n') ? '\r'
                                                                                       : '\n';
}

int vor_ply_named(const char *name, size_t length, const char *want)
{
    return strlen(want) == length && memcmp(name, want, length) == 0;
}

int vor_ply_alike(const char *name, size_t length, const char *want)
{
    return strlen(want) == length && strncasecmp(name, want, length) == 0;
}

unsigned vor_ply_find(const struct vor_ply_element *element, const char *name, int is_scalar)
{
    unsigned alike = VOR_PLY_PROPERTIES_MAX;

    for (unsigned i = element->property_count; i-- > 0;) {
        const struct vor_ply_property *property = &element->properties[i];

        if ((is_scalar && property->list) ||
            !vor_ply_alike(property->name, property->name_length, name))
            continue;
        if (memcmp(property->name, name, property->name_length) == 0)
            return i;
        alike = i;
    }
    return alike;
}

static int is(struct word word, const char *want)
{
    return vor_ply_named(word.at, word.length, want);
}

static const char *show(char out[SHOWN], struct word word)
{
    return vor_quote(out, SHOWN, word.at, word.length);
}

/* False when a byte is neither printable nor a blank. */
static int cut_words(struct line *line)
{
    size_t i = 0;

    line->words = 0;
    for (;;) {
        size_t begin;

        while (i < line->length && is_blank(line->at[i]))
            i++;
        if (i == line->length)
            return 1;
        for (begin = i; i < line->length && !is_blank(line->at[i]); i++)
            if ((uint8_t)line->at[i] < 0x20 || line->at[i] == 0x7f)
                return 0;
        if (line->words < WORDS_MAX)
            line->word[line->words++] = (struct word){line->at + begin, i - begin};
    }
}

static vor_status next_line(struct scan *scan, struct line *line, struct vor_error *err)
{
    const uint8_t *begin = scan->bytes + scan->at;
    size_t left = scan->size - scan->at;
    size_t window = left < VOR_PLY_LINE_MAX + 2 ? left : VOR_PLY_LINE_MAX + 2;
    const uint8_t *end = memchr(begin, scan->stop, window);

    if (end == NULL && window == left) {
        if (scan->cut)
            vor_fail(err, VOR_E_FORMAT, "no end_header within the first %zu bytes", scan->size);
        else
            vor_fail(err, VOR_E_FORMAT, "the file ends after %zu bytes, before end_header",
                     scan->size);
        (void)vor_fail_at(err, VOR_E_FORMAT, scan->size);
        return VOR_E_FORMAT;
    }
    line->at = (const char *)begin;
    line->offset = scan->at;
    line->length = end != NULL ? (size_t)(end - begin) : window;
    scan->at += line->length + 1;
    if (end != NULL && scan->stop == '\n' && line->length > 0 && end[-1] == '\r')
        line->length--;
    if (line->length > VOR_PLY_LINE_MAX)
        return VOR_PLY_FAIL(err, line->offset, "a header line has more than %d bytes",
                            VOR_PLY_LINE_MAX);
    return VOR_OK;
}

static vor_status bad_line(const struct line *line, const char *want, struct vor_error *err)
{
    return VOR_PLY_FAIL(err, line->offset, "header line \"%s\", want %s",
                        VOR_QUOTED(80, line->at, line->length), want);
}

/* Digits only; what does not fit is UINT64_MAX, which no limit lets pass. */
static int parse_count(struct word word, uint64_t *out)
{
    uint64_t count = 0;

    for (size_t i = 0; i < word.length; i++) {
        if (word.at[i] < '0' || word.at[i] > '9')
            return 0;
        if (__builtin_mul_overflow(count, 10, &count) ||
            __builtin_add_overflow(count, (uint64_t)(word.at[i] - '0'), &count))
            count = UINT64_MAX;
    }
    *out = count;
    return 1;
}

static vor_status read_element(struct scan *scan, struct vor_ply_header *header,
                               const struct line *line, struct vor_error *err)
{
    struct vor_ply_element *element = &header->elements[header->element_count];
    char shown[SHOWN];
    uint64_t count;

    if (!scan->has_format)
        return bad_line(line, "the format line before any element", err);
    if (line->words != 3 || !parse_count(line->word[2], &count))
        return bad_line(line, "element NAME COUNT with a whole number", err);
    if (header->element_count == VOR_PLY_ELEMENTS_MAX)
        return VOR_PLY_FAIL(err, line->offset, "the header has more than %d elements",
                            VOR_PLY_ELEMENTS_MAX);
    for (unsigned i = 0; i < header->element_count; i++)
        if (header->elements[i].name_length == line->word[1].length &&
            memcmp(header->elements[i].name, line->word[1].at, line->word[1].length) == 0)
            return VOR_PLY_FAIL(err, line->offset, "element %s is declared twice",
                                show(shown, line->word[1]));
    element->name = line->word[1].at;
    element->name_length = line->word[1].length;
    element->offset = line->offset;
    element->count = count;
    element->property_count = 0;
    header->element_count++;
    return VOR_OK;
}

static int parse_type(struct word word, enum vor_type *out)
{
    return vor_type_parse(out, word.at, word.length);
}

static vor_status parse_property(struct vor_ply_property *out, const struct line *line,
                                 struct vor_error *err)
{
    struct word name;

    out->list = line->words > 1 && is(line->word[1], "list");
    if (line->words != (out->list ? 5 : 3))
        return bad_line(line, "property TYPE NAME or property list TYPE TYPE NAME", err);
    out->count_type = VOR_UINT8;
    if ((out->list && !parse_type(line->word[2], &out->count_type)) ||
        !parse_type(line->word[out->list ? 3 : 1], &out->type))
        return bad_line(line, "a type of char, uchar, short, ushort, int, uint, float, double",
                        err);
    name = line->word[line->words - 1];
    out->name = name.at;
    out->name_length = name.length;
    return VOR_OK;
}

static vor_status add_property(struct vor_ply_element *element,
                               const struct vor_ply_property *property, size_t offset,
                               struct vor_error *err)
{
    struct word name = {property->name, property->name_length};
    char shown[SHOWN], of[SHOWN];

    vor_quote(of, sizeof of, element->name, element->name_length);
    if (element->property_count == VOR_PLY_PROPERTIES_MAX)
        return VOR_PLY_FAIL(err, offset, "element %s has more than %d properties", of,
                            VOR_PLY_PROPERTIES_MAX);
    for (unsigned i = 0; i < element->property_count; i++)
        if (element->properties[i].name_length == name.length &&
            memcmp(element->properties[i].name, name.at, name.length) == 0)
            return VOR_PLY_FAIL(err, offset, "property %s of %s is declared twice",
                                show(shown, name), of);
    element->properties[element->property_count++] = *property;
    return VOR_OK;
}

int vor_ply_is_remark(const char *at, size_t size)
{
    static const char *const words[] = {"comment", "obj_info"};

    for (unsigned i = 0; i < 2; i++) {
        size_t length = strlen(words[i]);

        if (size >= length && memcmp(at, words[i], length) == 0 &&
            (size == length || is_blank(at[length])))
            return 1;
    }
    return 0;
}

/* *end becomes true at end_header. */
static vor_status read_line(struct scan *scan, struct vor_ply_header *header, struct line *line,
                            int *end, struct vor_error *err)
{
    if (vor_ply_is_remark(line->at, line->length)) /* in any character set */
        return VOR_OK;
    if (!cut_words(line))
        return bad_line(line, "no control characters", err);
    if (line->words == 0)
        return VOR_OK;
    if (is(line->word[0], "format")) {
        static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
        unsigned i = 0;

        if (scan->has_format)
            return bad_line(line, "only one format line", err);
        while (line->words > 1 && i < 3 && !is(line->word[1], names[i]))
            i++;
        if (line->words != 3 || i == 3 || !is(line->word[2], "1.0"))
            return bad_line(line, "format ascii, binary_little_endian or binary_big_endian 1.0",
                            err);
        header->encoding = (enum vor_ply_encoding)i;
        scan->has_format = 1;
        return VOR_OK;
    }
    if (is(line->word[0], "element"))
        return read_element(scan, header, line, err);
    if (is(line->word[0], "property")) {
        struct vor_ply_property property;
        vor_status status;

        if (header->element_count == 0)
            return bad_line(line, "an element line before any property", err);
        status = parse_property(&property, line, err);
        if (status != VOR_OK)
            return status;
        return add_property(&header->elements[header->element_count - 1], &property, line->offset,
                            err);
    }
    if (!is(line->word[0], "end_header") || line->words != 1)
        return bad_line(line, "format, comment, obj_info, element, property or end_header", err);
    *end = 1;
    return VOR_OK;
}

vor_status vor_ply_header_read(struct vor_ply_header *out, const uint8_t *bytes, size_t size,
                               size_t limit, struct vor_error *err)
{
    struct scan scan = {bytes, size < limit ? size : limit, 0, size > limit, '\n', 0};
    struct line line;
    vor_status status = VOR_OK;
    int end = 0;

    out->element_count = 0;
    scan.stop = vor_ply_line_stop(bytes, size);
    scan.at = find_begin(bytes, scan.size);
    if (scan.size - scan.at < 3 || memcmp(bytes + scan.at, "ply", 3) != 0)
        return VOR_PLY_FAIL(err, 0, "the file does not begin with ply");
    status = next_line(&scan, &line, err);
    if (status == VOR_OK && (!cut_words(&line) || line.words != 1 || !is(line.word[0], "ply")))
        return bad_line(&line, "ply", err);
    while (status == VOR_OK && !end) {
        status = next_line(&scan, &line, err);
        VOR_THEN(status, read_line(&scan, out, &line, &end, err));
    }
    if (status != VOR_OK)
        return status;
    if (!scan.has_format)
        return VOR_PLY_FAIL(err, line.offset, "the header has no format line");
    out->body = scan.at;
    return VOR_OK;
}
