#include "server/base/address.h"

#include "server/base/option.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>

enum { MAPPED_BITS = 96 /* of ::ffff:0:0/96, which holds the addresses of IPv4 */ };

static const uint8_t mapped[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};

static bool is_ipv4(const struct vor_address *address)
{
    return memcmp(address->bytes, mapped, sizeof mapped) == 0;
}

static struct vor_address map_ipv4(const void *four_bytes)
{
    struct vor_address address;

    memcpy(address.bytes, mapped, sizeof mapped);
    memcpy(address.bytes + sizeof mapped, four_bytes, 4);
    return address;
}

bool vor_address_parse(struct vor_address *out, const char *text, size_t length)
{
    char copy[VOR_ADDRESS_TEXT];
    struct in6_addr six;
    struct in_addr four;

    if (length >= sizeof copy || memchr(text, '\0', length) != NULL)
        return false;
    memcpy(copy, text, length);
    copy[length] = '\0';
    if (inet_pton(AF_INET, copy, &four) == 1) {
        *out = map_ipv4(&four);
        return true;
    }
    if (inet_pton(AF_INET6, copy, &six) != 1)
        return false;
    memcpy(out->bytes, &six, sizeof out->bytes);
    return true;
}

bool vor_address_of_socket(struct vor_address *out, const struct sockaddr *end)
{
    struct sockaddr_in four;
    struct sockaddr_in6 six;

    if (end->sa_family == AF_INET) {
        memcpy(&four, end, sizeof four);
        *out = map_ipv4(&four.sin_addr);
        return true;
    }
    if (end->sa_family == AF_UNIX) {
        four.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        *out = map_ipv4(&four.sin_addr);
        return true;
    }
    if (end->sa_family != AF_INET6)
        return false;
    memcpy(&six, end, sizeof six);
    memcpy(out->bytes, &six.sin6_addr, sizeof out->bytes);
    return true;
}

const char *vor_address_text(const struct vor_address *address, char out[VOR_ADDRESS_TEXT])
{
    const char *text =
        is_ipv4(address) ? inet_ntop(AF_INET, address->bytes + sizeof mapped, out, VOR_ADDRESS_TEXT)
                         : inet_ntop(AF_INET6, address->bytes, out, VOR_ADDRESS_TEXT);

    if (text == NULL)
        out[0] = '\0';
    return out;
}

/* ADDRESS or ADDRESS/BITS. */
static bool parse_network(struct vor_network *out, const char *text, size_t length)
{
    const char *slash = memchr(text, '/', length);
    size_t head = slash != NULL ? (size_t)(slash - text) : length;
    size_t digits = slash != NULL ? length - head - 1 : 0;
    unsigned most;

    if (!vor_address_parse(&out->address, text, head))
        return false;
    most = memchr(text, ':', head) != NULL ? 128 : 32;
    out->bits = 128;
    if (slash == NULL)
        return true;
    if (digits == 0 || digits > 3 || strspn(slash + 1, "0123456789") < digits)
        return false;
    out->bits = (unsigned)strtoul(slash + 1, NULL, 10);
    if (out->bits > most)
        return false;
    out->bits += 128 - most;
    return true;
}

vor_status vor_networks_parse(struct vor_networks *out, const char *name, const char *list,
                              struct vor_error *err)
{
    out->count = 0;
    while (*(list += strspn(list, ", ")) != '\0') {
        size_t word = strcspn(list, ", ");

        if (out->count == VOR_NETWORKS_MAX)
            return vor_fail_param(err, VOR_E_PARAM, name, "--%s has more than %d entries", name,
                                  VOR_NETWORKS_MAX);
        if (!parse_network(&out->list[out->count], list, word))
            return vor_fail_param(err, VOR_E_PARAM, name,
                                  "--%s holds \"%.*s\", want addresses and networks such as "
                                  "127.0.0.1, 10.0.0.0/8 or fd00::/8",
                                  name, (int)(word < 80 ? word : 80), list);
        out->count++;
        list += word;
    }
    return VOR_OK;
}

static bool network_holds(const struct vor_network *network, const struct vor_address *address)
{
    unsigned whole = network->bits / 8, rest = network->bits % 8;
    unsigned differ;

    if (network->bits < MAPPED_BITS && is_ipv4(address))
        return false;
    if (memcmp(network->address.bytes, address->bytes, whole) != 0)
        return false;
    if (rest == 0)
        return true;
    differ = network->address.bytes[whole] ^ address->bytes[whole];
    return differ >> (8 - rest) == 0;
}

bool vor_networks_hold(const struct vor_networks *networks, const struct vor_address *address)
{
    for (unsigned i = 0; i < networks->count; i++)
        if (network_holds(&networks->list[i], address))
            return true;
    return false;
}

size_t vor_host_name_length(const char *host)
{
    return host[0] == '[' ? strcspn(host, "]") + (strchr(host, ']') != NULL) : strcspn(host, ":");
}

bool vor_host_is_sound(const char *host)
{
    static const char in_names[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._";
    size_t name = vor_host_name_length(host);
    struct vor_address address;
    unsigned port;

    if (name == 0 || strlen(host) > VOR_HOST_MAX)
        return false;
    if (host[0] == '[') {
        if (name < 4 || host[name - 1] != ']' || memchr(host, ':', name) == NULL ||
            !vor_address_parse(&address, host + 1, name - 2))
            return false;
    } else if (strspn(host, in_names) < name) {
        return false;
    }
    /* Behind it nothing, or : and a number from 1 to 65535. RFC 9110 lets the number be missing;
     * nobody sends that, and no socket has it. */
    return host[name] == '\0' || (host[name] == ':' && strlen(host + name) <= 6 &&
                                  vor_whole_read(&port, host + name + 1, 1, UINT16_MAX));
}

/* True when the segment of that length may stand in a path that nobody resolves again. */
static bool segment_is_sound(const char *text, size_t length)
{
    static const char allowed[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
                                  "-._~!$&'()*+,;=:@%";
    static const char hex[] = "0123456789abcdefABCDEF";

    if (length == 0 || strspn(text, allowed) < length)
        return false;
    if (text[0] == '.' && (length == 1 || (length == 2 && text[1] == '.')))
        return false;
    for (size_t i = 0; i < length; i++)
        if (text[i] == '%' && (i + 2 >= length || strspn(text + i + 1, hex) < 2))
            return false;
    return true;
}

bool vor_prefix_is_sound(const char *path)
{
    if (path[0] != '/' || strlen(path) > VOR_PREFIX_MAX)
        return false;
    do {
        size_t length = strcspn(++path, "/");

        if (length == 0 && *path == '\0')
            break;
        if (!segment_is_sound(path, length))
            return false;
        path += length;
    } while (*path != '\0');
    return true;
}

struct vor_fairness_key vor_fairness_key_of_address(const char *text)
{
    struct vor_fairness_key sharer = {.name = ""};
    char shown[VOR_ADDRESS_TEXT];
    struct vor_address address;

    if (!vor_address_parse(&address, text, strlen(text)))
        return sharer;
    if (!is_ipv4(&address))
        memset(address.bytes + 8, 0, 8);
    (void)snprintf(sharer.name, sizeof sharer.name, "address %s",
                   vor_address_text(&address, shown));
    return sharer;
}

struct vor_fairness_key vor_fairness_key_of_key(const char *name)
{
    struct vor_fairness_key sharer;

    (void)snprintf(sharer.name, sizeof sharer.name, "key %s", name);
    return sharer;
}

bool vor_fairness_key_same(const struct vor_fairness_key *a, const struct vor_fairness_key *b)
{
    return strcmp(a->name, b->name) == 0;
}

enum { PORT_MAX = 65535 };

vor_status vor_endpoint_parse(struct vor_endpoint *out, const char *flag, const char *text,
                              struct vor_error *err)
{
    const char *colon = strrchr(text, ':');
    size_t length = colon != NULL ? (size_t)(colon - text) : 0;

    memset(out, 0, sizeof *out);
    if (strncmp(text, "unix:", 5) == 0) {
        if (text[5] != '/' || strlen(text + 5) >= sizeof out->path)
            return vor_fail_param(err, VOR_E_PARAM, flag,
                                  "--%s is \"unix:%.120s\", want unix:/PATH with a path of at most "
                                  "%d bytes",
                                  flag, text + 5, VOR_SOCKET_PATH_MAX - 1);
        memcpy(out->path, text + 5, strlen(text + 5) + 1);
        memcpy(out->host, "localhost", sizeof "localhost");
        out->loopback = 1;
        return VOR_OK;
    }
    if (length == 0 || length >= sizeof out->host ||
        !vor_whole_read(&out->port, colon + 1, 0, PORT_MAX))
        return vor_fail_param(err, VOR_E_PARAM, flag,
                              "--%s is \"%.80s\", want HOST:PORT with a port from 0 to %d, or "
                              "unix:/PATH",
                              flag, text, PORT_MAX);
    if (text[0] == '[' && text[length - 1] == ']') {
        text++;
        length -= 2;
    }
    memcpy(out->host, text, length);
    out->loopback = strncmp(out->host, "127.", 4) == 0 || strcmp(out->host, "::1") == 0 ||
                    strcasecmp(out->host, "localhost") == 0;
    return VOR_OK;
}
