#include "server/http/request_check.h"

#include "proto/text.h"
#include "server/base/uuid.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

const char *vor_head_find(const struct vor_head *head, const char *name)
{
    for (size_t i = 0; i < head->field_count && i < VOR_FIELDS_MAX; i++)
        if (strcasecmp(head->fields[i].name, name) == 0)
            return head->fields[i].value;
    return NULL;
}

static int count_fields(const struct vor_head *head, const char *name)
{
    int count = 0;

    for (size_t i = 0; i < head->field_count; i++)
        count += strcasecmp(head->fields[i].name, name) == 0;
    return count;
}

static bool is_token(const char *text)
{
    static const char marks[] = "!#$%&'*+-.^_`|~";

    if (*text == '\0')
        return false;
    for (; *text != '\0'; text++) {
        char c = *text;
        bool alnum = (c >= '0' && c <= '9') || ((c | 32) >= 'a' && (c | 32) <= 'z');

        if (!alnum && strchr(marks, c) == NULL)
            return false;
    }
    return true;
}

/* An escape that would change how the path is cut into segments, or end it early. */
static bool has_hidden_separator(const char *path, size_t length)
{
    static const char *const hidden[] = {"00", "2f", "5c", "2e"};

    for (size_t i = 0; i + 2 < length; i++) {
        if (path[i] != '%')
            continue;
        for (size_t k = 0; k < sizeof hidden / sizeof hidden[0]; k++)
            if (strncasecmp(path + i + 1, hidden[k], 2) == 0)
                return true;
    }
    return false;
}

static const char *check_framing(const struct vor_head *head)
{
    const char *coding = vor_head_find(head, "Transfer-Encoding");
    const char *length = vor_head_find(head, "Content-Length");
    const char *before;

    if (count_fields(head, "Content-Length") > 1)
        return "more than one Content-Length";
    if (count_fields(head, "Transfer-Encoding") > 1)
        return "more than one Transfer-Encoding";
    if (coding != NULL && length != NULL)
        return "both Content-Length and Transfer-Encoding";
    if (coding != NULL && strcasecmp(coding, "chunked") != 0)
        return "a Transfer-Encoding other than chunked";
    if (coding != NULL && strcmp(head->version, "HTTP/1.1") != 0)
        return "Transfer-Encoding in HTTP/1.0";
    if (length != NULL &&
        (length[0] == '\0' || strlen(length) > 18 || length[strspn(length, "0123456789")] != '\0'))
        return "Content-Length is not a whole number";
    if (count_fields(head, "Host") > 1)
        return "more than one Host";
    /* Of a block whose strings are still in place: two bytes, CR and LF, stand between two lines.
     */
    before = head->version;
    for (size_t i = 0; i < head->field_count && head->block != NULL; i++) {
        /* Bytes from the end of one string to the beginning of another. Theirs is one block, but
         * nothing tells the compiler so. */
        uintptr_t between = (uintptr_t)head->fields[i].name - ((uintptr_t)before + strlen(before));

        if (between == 1)
            return "a line ends with a line feed alone";
        if (between != 2)
            return "a header value holds NUL or continues on the next line";
        before = head->fields[i].value;
    }
    return NULL;
}

/* What the request line and the whole block must be. */
static const char *check_form(const struct vor_head *head)
{
    const char *target = head->target;
    size_t length = strlen(target) + strlen("OPTIONS  HTTP/1.1\r\n\r\n");

    if (strcmp(head->version, "HTTP/1.1") != 0 && strcmp(head->version, "HTTP/1.0") != 0)
        return "the version is neither HTTP/1.1 nor HTTP/1.0";
    if (head->block != NULL &&
        (uintptr_t)head->version - (uintptr_t)head->block != strlen(head->target) + 1)
        return "the request target holds NUL";
    if (strcmp(head->version, "HTTP/1.1") == 0 && vor_head_find(head, "Host") == NULL)
        return "HTTP/1.1 without Host";
    if (strlen(target) > VOR_TARGET_MAX)
        return "the request target is longer than 8192 bytes";
    if (target[0] != '/')
        return "the request target does not begin with /";
    for (size_t i = 0; target[i] != '\0'; i++)
        if (target[i] <= ' ' || target[i] >= 0x7f || target[i] == '\\' || target[i] == '#')
            return "the request target holds a byte that must be escaped";
    if (has_hidden_separator(target, strcspn(target, "?")))
        return "the path holds one of %00 %2f %5c %2e";
    /* Bytes of the block as it came, but for blanks around values. */
    for (size_t i = 0; i < head->field_count; i++)
        length += strlen(head->fields[i].name) + strlen(head->fields[i].value) + strlen(": \r\n");
    if (length > VOR_HEADER_MAX)
        return "the header block is longer than 32768 bytes";
    return NULL;
}

const char *vor_head_check(const struct vor_head *head, const char **detail)
{
    if (head->field_count > VOR_FIELDS_MAX) {
        *detail = "more than 100 header fields";
        return "malformed-request";
    }
    *detail = NULL;
    for (size_t i = 0; i < head->field_count && *detail == NULL; i++) {
        if (!is_token(head->fields[i].name))
            *detail = "a header name holds a byte that is not allowed in names";
        else if (strpbrk(head->fields[i].value, VOR_CONTROLS) != NULL)
            *detail = "a header value holds a control byte";
    }
    if (*detail != NULL || (*detail = check_framing(head)) != NULL)
        return "smuggled-framing";
    return (*detail = check_form(head)) != NULL ? "malformed-request" : NULL;
}

int64_t vor_head_length(const struct vor_head *head)
{
    const char *length = vor_head_find(head, "Content-Length");

    if (vor_head_find(head, "Transfer-Encoding") != NULL)
        return -1;
    return length != NULL ? strtoll(length, NULL, 10) : 0;
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    c |= 32;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* Decodes %XX in place; false when an escape is malformed or hides a control byte. */
static bool unescape(char *text)
{
    char *to = text;

    for (; *text != '\0'; text++) {
        int high, low;

        if (*text != '%') {
            *to++ = *text;
            continue;
        }
        high = hex_digit(text[1]);
        low = high < 0 ? -1 : hex_digit(text[2]);
        if (low < 0 || high * 16 + low < 0x20 || high * 16 + low == 0x7f)
            return false;
        *to++ = (char)(high * 16 + low);
        text += 2;
    }
    *to = '\0';
    return true;
}

int vor_query_split(char *text, struct vor_field *pairs, int max)
{
    int count = 0;

    while (text != NULL && *text != '\0') {
        char *next = strchr(text, '&');
        char *equals;

        if (next != NULL)
            *next++ = '\0';
        if (*text != '\0') {
            if (count == max)
                return -1;
            equals = strchr(text, '=');
            if (equals != NULL)
                *equals++ = '\0';
            if (!unescape(text) || (equals != NULL && !unescape(equals)))
                return -1;
            pairs[count++] = (struct vor_field){text, equals != NULL ? equals : ""};
        }
        text = next;
    }
    return count;
}

void vor_request_id_make(char out[72], const char *sane)
{
    static const char allowed[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    size_t length = sane != NULL ? strlen(sane) : 0;
    uint8_t bits[16];
    struct vor_uuid id;

    if (length >= 1 && length <= 64 && strspn(sane, allowed) == length) {
        memcpy(out, sane, length + 1);
        return;
    }
    /* A name for the log, not a secret: zeros after a failure are still a name. */
    if (vor_random_fill(bits, sizeof bits, NULL) != VOR_OK)
        memset(bits, 0, sizeof bits);
    vor_uuid_write(&id, bits, 4);
    memcpy(out, id.text, sizeof id.text);
}

bool vor_etag_listed(const char *list, const char *etag, bool takes_weak)
{
    size_t want = strlen(etag);

    while (list != NULL && *list != '\0') {
        bool is_weak;

        list += strspn(list, ", \t");
        if (*list == '*')
            return true;
        is_weak = strncmp(list, "W/", 2) == 0;
        if (is_weak)
            list += 2;
        if ((takes_weak || !is_weak) && strncmp(list, etag, want) == 0)
            return true;
        list += strcspn(list, ",");
    }
    return false;
}
