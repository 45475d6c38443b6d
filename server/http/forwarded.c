#include "server/http/forwarded.h"

#include <string.h>
#include <strings.h>

/* Bytes of a header that stay there. */
struct span {
    const char *at; /* NULL: not given */
    size_t length;
};

/* What one proxy said of the request that it got. Values of Forwarded may be quoted. */
struct hop {
    struct span node, scheme, host;
};

/* The last VOR_HOPS_MAX hops, the one of the nearest proxy last. */
struct hops {
    struct hop ring[VOR_HOPS_MAX];
    size_t count; /* of all that were added */
};

static void add_hop(struct hops *hops, const struct hop *hop)
{
    hops->ring[hops->count++ % VOR_HOPS_MAX] = *hop;
}

static const char *skip_blanks(const char *text)
{
    return text + strspn(text, " \t");
}

static struct span trim(const char *at, size_t length)
{
    while (length > 0 && strchr(" \t", at[length - 1]) != NULL)
        length--;
    while (length > 0 && strchr(" \t", *at) != NULL)
        at++, length--;
    return (struct span){at, length};
}

/* --- values ----------------------------------------------------------------------------------- */

/* The text of a value, without quotes and escapes; false when it is empty or does not fit. */
static bool take_text(const struct span *value, char *out, size_t size)
{
    const char *at = value->at, *end = at + value->length;
    size_t length = 0;
    bool quoted = value->length >= 2 && *at == '"';

    if (quoted)
        at++, end--;
    while (at < end) {
        if (quoted && *at == '\\')
            at++;
        if (length + 1 == size)
            return false;
        out[length++] = *at++;
    }
    out[length] = '\0';
    return length > 0;
}

/* A port, or a name that stands for one (RFC 7239, section 6). */
static bool is_port(const char *text)
{
    static const char in_names[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    size_t length = strlen(text);

    if (text[0] == '_')
        return length > 1 && strspn(text, in_names) == length;
    return length >= 1 && length <= 5 && strspn(text, "0123456789") == length;
}

/* ADDRESS of IPv4 or [ADDRESS] of IPv6, with :PORT behind it or not; a bare IPv6 address is what
 * X-Forwarded-For has. */
static bool take_node(struct vor_address *out, const char *text, bool may_be_bare)
{
    const char *colon = strchr(text, ':');
    size_t length = vor_host_name_length(text);
    bool sound;

    if (may_be_bare && text[0] != '[' && colon != NULL && strchr(colon + 1, ':') != NULL)
        return vor_address_parse(out, text, strlen(text));
    if (text[length] != '\0' && (text[length] != ':' || !is_port(text + length + 1)))
        return false;
    if (text[0] != '[')
        return vor_address_parse(out, text, length);
    sound = length > 2 && text[length - 1] == ']' && memchr(text, ':', length) != NULL;
    return sound && vor_address_parse(out, text + 1, length - 2);
}

static void take_scheme(struct vor_via *out, const char *text)
{
    if (strcasecmp(text, "https") == 0)
        out->scheme = "https";
    else if (strcasecmp(text, "http") == 0)
        out->scheme = "http";
}

static void take_host(struct vor_via *out, const char *text)
{
    if (vor_host_is_sound(text))
        memcpy(out->host, text, strlen(text) + 1);
}

static void take_prefix(struct vor_via *out, const char *text)
{
    size_t length = strlen(text);

    if (!vor_prefix_is_sound(text))
        return;
    while (length > 0 && text[length - 1] == '/')
        length--;
    memcpy(out->prefix, text, length);
    out->prefix[length] = '\0';
}

/* --- X-Forwarded-* ---------------------------------------------------------------------------- */

/* Calls add for every entry of a field that is a list, on however many lines. */
static void each_entry(const struct vor_head *head, const char *name,
                       void (*add)(void *ctx, const struct span *entry), void *ctx)
{
    for (size_t i = 0; i < head->field_count; i++) {
        const char *at = head->fields[i].value;

        if (strcasecmp(head->fields[i].name, name) != 0)
            continue;
        for (;;) {
            size_t length = strcspn(at, ",");
            struct span entry = trim(at, length);

            if (entry.length > 0)
                add(ctx, &entry);
            if (at[length] == '\0')
                break;
            at += length + 1;
        }
    }
}

static void add_node(void *ctx, const struct span *entry)
{
    add_hop(ctx, &(struct hop){.node = *entry});
}

static void keep_last(void *ctx, const struct span *entry)
{
    *(struct span *)ctx = *entry;
}

static void take_last(struct vor_via *out, const struct vor_head *head, const char *name,
                      void (*take)(struct vor_via *out, const char *text))
{
    struct span last = {NULL, 0};
    char text[VOR_HOST_MAX + 1];

    each_entry(head, name, keep_last, &last);
    if (last.at == NULL || last.length >= sizeof text)
        return;
    memcpy(text, last.at, last.length);
    text[last.length] = '\0';
    take(out, text);
}

/* --- Forwarded -------------------------------------------------------------------------------- */

/* Reads a token (RFC 9110, 5.6.2) at *at, which moves behind it; false when there is none. */
static bool read_token(struct span *out, const char **at)
{
    static const char allowed[] = "!#$%&'*+-.^_`|~0123456789"
                                  "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";

    *out = (struct span){*at, strspn(*at, allowed)};
    *at += out->length;
    return out->length > 0;
}

/* The same for a quoted string (RFC 9110, 5.6.4), quotes included. */
static bool read_quoted(struct span *out, const char **at)
{
    const char *end = *at + 1;

    while (*end != '"') {
        if (*end == '\\')
            end++;
        if (*end == '\0')
            return false;
        end++;
    }
    *out = (struct span){*at, (size_t)(end + 1 - *at)};
    *at = end + 1;
    return true;
}

static bool names(const struct span *name, const char *word)
{
    return name->length == strlen(word) && strncasecmp(name->at, word, name->length) == 0;
}

/* NAME=VALUE; false when it is malformed, or says again what the hop has said. */
static bool read_pair(struct hop *hop, const char **at)
{
    struct span name, value, *to = NULL;

    if (!read_token(&name, at) || *(*at)++ != '=')
        return false;
    if (!(**at == '"' ? read_quoted(&value, at) : read_token(&value, at)))
        return false;
    if (names(&name, "for"))
        to = &hop->node;
    else if (names(&name, "proto"))
        to = &hop->scheme;
    else if (names(&name, "host"))
        to = &hop->host;
    if (to == NULL)
        return true;
    if (to->at != NULL)
        return false;
    *to = value;
    return true;
}

/* The pairs of one hop, up to a comma or the end. */
static bool read_element(struct hop *hop, const char **at, bool *empty)
{
    *hop = (struct hop){{NULL, 0}, {NULL, 0}, {NULL, 0}};
    *empty = true;
    for (;;) {
        *at = skip_blanks(*at);
        if (**at != ';' && **at != ',' && **at != '\0') {
            if (!read_pair(hop, at))
                return false;
            *empty = false;
            *at = skip_blanks(*at);
        }
        if (**at != ';')
            return **at == ',' || **at == '\0';
        (*at)++;
    }
}

/* Adds the hops of one line; false when it is malformed somewhere. */
static bool read_line(struct hops *hops, const char *at)
{
    for (;;) {
        struct hop hop;
        bool empty;

        if (!read_element(&hop, &at, &empty))
            return false;
        if (!empty)
            add_hop(hops, &hop);
        if (*at == '\0')
            return true;
        at++;
    }
}

/* --- the walk --------------------------------------------------------------------------------- */

/* Goes back from hop to hop as long as the one before it was a trusted proxy. */
static struct vor_address walk(struct vor_via *out, const struct hops *hops,
                               const struct vor_address *peer, const struct vor_networks *trusted,
                               bool nodes_may_be_bare)
{
    struct vor_address client = *peer;
    const struct hop *hop;
    char text[VOR_HOST_MAX + 1];

    for (size_t i = 0; vor_networks_hold(trusted, &client); i++) {
        if (i >= hops->count || i >= VOR_HOPS_MAX)
            break;
        hop = &hops->ring[(hops->count - 1 - i) % VOR_HOPS_MAX];
        if (hop->scheme.at != NULL && take_text(&hop->scheme, text, sizeof text))
            take_scheme(out, text);
        if (hop->host.at != NULL && take_text(&hop->host, text, sizeof text))
            take_host(out, text);
        if (hop->node.at == NULL || !take_text(&hop->node, text, sizeof text) ||
            !take_node(&client, text, nodes_may_be_bare))
            break;
    }
    return client;
}

void vor_forwarded_read(struct vor_via *out, const struct vor_head *head,
                        const struct vor_address *peer, const struct vor_networks *trusted,
                        enum vor_proxy_headers family)
{
    struct vor_address client;
    struct hops hops = {.count = 0};

    memset(out, 0, sizeof *out);
    (void)vor_address_text(peer, out->client);
    if (!vor_networks_hold(trusted, peer))
        return;
    if (family == VOR_PROXY_FORWARDED) {
        for (size_t i = 0; i < head->field_count; i++)
            if (strcasecmp(head->fields[i].name, "Forwarded") == 0 &&
                !read_line(&hops, head->fields[i].value))
                hops.count = 0;
    } else {
        each_entry(head, "X-Forwarded-For", add_node, &hops);
        take_last(out, head, "X-Forwarded-Proto", take_scheme);
        take_last(out, head, "X-Forwarded-Host", take_host);
        take_last(out, head, "X-Forwarded-Prefix", take_prefix);
    }
    client = walk(out, &hops, peer, trusted, family != VOR_PROXY_FORWARDED);
    (void)vor_address_text(&client, out->client);
}
