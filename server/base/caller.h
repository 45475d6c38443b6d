/** Who asks: those of one caller share what a caller is given. */
#ifndef VOR_SERVER_BASE_CALLER_H
#define VOR_SERVER_BASE_CALLER_H

#include "server/base/address.h"

#include <stdbool.h>

/** Bytes of a caller's name, with its NUL. */
#define VOR_CALLER_SIZE 80

/** A name that tells callers apart, of whatever kind: "address 192.0.2.1", or that of a key. "" is
 *  nobody in particular, which is a caller like others. All zero is "". */
struct vor_caller {
    char name[VOR_CALLER_SIZE];
};

/** The caller at an address: of IPv6 its network of 64 bits, as whoever has one of its addresses
 * has all of them; "" for what is no address. */
struct vor_caller vor_caller_of_address(const char *text);

bool vor_caller_same(const struct vor_caller *a, const struct vor_caller *b);

#endif
