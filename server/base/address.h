/** Internet addresses, networks of them, and names of hosts. Pure functions on strings. */
#ifndef VOR_SERVER_BASE_ADDRESS_H
#define VOR_SERVER_BASE_ADDRESS_H

#include "core/base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct sockaddr;

enum {
    VOR_ADDRESS_TEXT = 46, /**< bytes of the longest address as text, and its end (RFC 4291) */
    VOR_HOST_MAX = 255,    /**< bytes of a host's name (RFC 1035) and its port */
    VOR_PREFIX_MAX = 128,  /**< bytes of the path that a proxy puts before ours */
    VOR_NETWORKS_MAX = 64  /**< entries of a list of networks */
};

/** An IPv6 address; one of IPv4 is ::ffff:a.b.c.d (RFC 4291, 2.5.5.2), however it was written. */
struct vor_address {
    uint8_t bytes[16];
};

/** The addresses that share their first `bits` bits, of 128 in either family. A network of IPv6
 *  holds no address of IPv4. */
struct vor_network {
    struct vor_address address;
    unsigned bits;
};

struct vor_networks {
    struct vor_network list[VOR_NETWORKS_MAX];
    unsigned count;
};

/** Reads length bytes: 192.0.2.1 or 2001:db8::1, without brackets, port or zone. False, and *out
 *  stays as it is, when they are neither. */
bool vor_address_parse(struct vor_address *out, const char *text, size_t length);

/** The address of one end of a connection; that of a Unix socket, which this machine alone reaches,
 *  is 127.0.0.1. False when it has none, as in another family. */
bool vor_address_of_socket(struct vor_address *out, const struct sockaddr *end);

/** As text, an IPv4 address in its own form. Returns out. */
const char *vor_address_text(const struct vor_address *address, char out[VOR_ADDRESS_TEXT]);

/** Reads addresses and networks (192.0.2.1, 10.0.0.0/8, fd00::/8), separated by commas or blanks.
 *  Bits beyond a network's length do not count.
 *
 *  @retval VOR_E_PARAM an entry is neither, or there are more than VOR_NETWORKS_MAX; the message
 *                      names the entry and begins with name, which is also the parameter at fault
 */
VOR_NODISCARD vor_status vor_networks_parse(struct vor_networks *out, const char *name,
                                            const char *list, struct vor_error *err);

/** True when one of the networks holds the address. */
bool vor_networks_hold(const struct vor_networks *networks, const struct vor_address *address);

/** True for NAME, NAME:PORT, [ADDRESS] and [ADDRESS]:PORT of at most VOR_HOST_MAX bytes, with a
 * PORT from 1 to 65535 and nothing behind: what may stand in Host (RFC 9110, 7.2), and in a URL
 * between scheme and path. */
bool vor_host_is_sound(const char *host);

/** Length of the name or bracketed address in a sound host: what stands before the port. */
size_t vor_host_name_length(const char *host);

/** True for a path of at most VOR_PREFIX_MAX bytes such as /clouds or /a/b/: segments of RFC 3986
 *  that are neither empty nor . or .. ; a slash may end it. */
bool vor_prefix_is_sound(const char *path);

/* Fairness keys: callers with the same key share one limit. */

/** Bytes of a key, with its NUL. */
#define VOR_FAIRNESS_KEY_SIZE 80

/** "address 192.0.2.1", or the name of an API key; "" stands for all callers without either. All
 *  zero is "". */
struct vor_fairness_key {
    char name[VOR_FAIRNESS_KEY_SIZE];
};

/** The key of an address. All addresses of an IPv6 network of 64 bits have the same key, because a
 *  caller usually owns such a network. "" if text is no address. */
struct vor_fairness_key vor_fairness_key_of_address(const char *text);

/** The key of callers with an API key of that name, at whatever address. */
struct vor_fairness_key vor_fairness_key_of_key(const char *name);

bool vor_fairness_key_same(const struct vor_fairness_key *a, const struct vor_fairness_key *b);

/* Where a daemon listens. */

/** Bytes of a socket's path that the kernel takes, with the NUL. */
enum { VOR_SOCKET_PATH_MAX = 108, VOR_ENDPOINT_HOST_MAX = 256 };

struct vor_endpoint {
    char host[VOR_ENDPOINT_HOST_MAX]; /**< without brackets; "localhost" of a socket's path */
    unsigned port;                    /**< 0 of a socket's path */
    char path[VOR_SOCKET_PATH_MAX];   /**< of a Unix socket; "" of a host */
    int loopback;                     /**< this machine only */
};

/** Reads "HOST:PORT", "[::1]:8080" or "unix:/PATH", the value of a setting.
 *
 *  @retval VOR_E_PARAM it is none of these (message: flag, value, and what is wanted) */
VOR_NODISCARD vor_status vor_endpoint_parse(struct vor_endpoint *out, const char *flag,
                                            const char *text, struct vor_error *err);

#endif
