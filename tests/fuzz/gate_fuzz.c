/* Any bytes as a request's head, cut into lines by the target itself as the library would. What
 * passes the gate has no byte, no framing and no target that a handler must be afraid of, and its
 * query, when it can be split, holds neither escapes nor control bytes. */
#include "server/http/request_check.h"
#include "tests/fuzz/fuzz.h"

#include <strings.h>

/* The line at *at, which moves behind it. */
static char *take_line(char **at)
{
    char *line = *at, *end = strchr(line, '\n');

    if (end != NULL)
        *end++ = '\0';
    *at = end != NULL ? end : line + strlen(line);
    return line;
}

/* Target, version, then a field a line. */
static void read_head(struct vor_head *head, char *text)
{
    memset(head, 0, sizeof *head);
    head->target = take_line(&text);
    head->version = take_line(&text);
    while (*text != '\0' && head->field_count <= VOR_FIELDS_MAX) {
        char *name = take_line(&text), *colon = strchr(name, ':');

        if (colon != NULL)
            *colon++ = '\0';
        if (head->field_count < VOR_FIELDS_MAX)
            head->fields[head->field_count] = (struct vor_field){name, colon != NULL ? colon : ""};
        head->field_count++;
    }
}

static int count(const struct vor_head *head, const char *name)
{
    int found = 0;

    for (size_t i = 0; i < head->field_count; i++)
        found += strcasecmp(head->fields[i].name, name) == 0;
    return found;
}

static void check_passed(const struct vor_head *head)
{
    int coded = count(head, "Transfer-Encoding"), sized = count(head, "Content-Length");
    int64_t length = vor_head_length(head);

    require(coded + sized <= 1 && count(head, "Host") <= 1, "a head says two things");
    require(coded == 1 ? length == -1 : length >= 0, "a length is not what the head says");
    require(head->target[0] == '/' && strlen(head->target) <= VOR_TARGET_MAX,
            "a target is no path, or too long");
    for (const char *c = head->target; *c != '\0'; c++)
        require(*c > ' ' && *c < 0x7f && *c != '\\' && *c != '#', "a target has a raw byte");
    for (size_t i = 0; i < head->field_count; i++) {
        require(head->fields[i].name[0] != '\0' && strpbrk(head->fields[i].name, " \t\r:") == NULL,
                "a name has a blank");
        for (const char *c = head->fields[i].value; *c != '\0'; c++)
            require((*c >= 0 && *c < ' ' && *c != '\t') == 0 && *c != 0x7f,
                    "a value has a control byte");
    }
}

/* What a target that passed the gate holds no longer, its query does not bring back. */
static void split(const char *target, int passed)
{
    struct vor_field pairs[VOR_QUERY_MAX];
    const char *query = strchr(target, '?');
    char *text = strdup(query != NULL ? query + 1 : "");
    size_t length;
    int n;

    require(text != NULL, "no memory");
    length = strlen(text);
    n = vor_query_split(text, pairs, VOR_QUERY_MAX);
    require(n >= -1 && n <= VOR_QUERY_MAX, "a query has more pairs than there is room for");
    for (int i = 0; i < n; i++) {
        require(strlen(pairs[i].name) + strlen(pairs[i].value) <= length, "a query grows");
        for (const char *c = pairs[i].name; *c != '\0'; c++)
            require(!passed || ((unsigned char)*c >= ' ' && *c != 0x7f),
                    "a name hides a control byte");
        for (const char *c = pairs[i].value; *c != '\0'; c++)
            require(!passed || ((unsigned char)*c >= ' ' && *c != 0x7f),
                    "a value hides a control byte");
    }
    free(text);
}

static void make_id(const char *sane)
{
    char id[72];

    vor_request_id_make(id, sane);
    require(strlen(id) >= 1 && strlen(id) <= 64, "a request has no name");
    for (const char *c = id; *c != '\0'; c++)
        require(strchr(" \"\\<>\r\n\t", *c) == NULL && *c > ' ' && *c < 0x7f,
                "a request's name has a byte that must not be repeated");
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    struct vor_head head;
    const char *slug, *detail = NULL;
    char *text = fuzz_text(bytes, size);

    read_head(&head, text);
    slug = vor_head_check(&head, &detail);
    require((slug == NULL) == (detail == NULL), "a refusal without a reason, or the reverse");
    make_id(vor_head_find(&head, "X-Request-Id"));
    split(head.target, slug == NULL);
    if (slug == NULL)
        check_passed(&head);
    free(text);
    return 0;
}
