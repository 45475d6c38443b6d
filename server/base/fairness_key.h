/** Who shares what: callers of one sharer are given together what a sharer is given. */
#ifndef VOR_SERVER_BASE_FAIRNESS_KEY_H
#define VOR_SERVER_BASE_FAIRNESS_KEY_H

#include "server/base/address.h"

#include <stdbool.h>

/** Bytes of a sharer's name, with its NUL. */
#define VOR_FAIRNESS_KEY_SIZE 80

/** A name that tells sharers apart, of whatever kind: "address 192.0.2.1", or that of a key. "" is
 *  nobody in particular, which is a sharer like others. All zero is "". */
struct vor_fairness_key {
    char name[VOR_FAIRNESS_KEY_SIZE];
};

/** The sharer at an address: of IPv6 its network of 64 bits, as whoever has one of its addresses
 * has all of them; "" for what is no address. */
struct vor_fairness_key vor_fairness_key_of_address(const char *text);

/** The sharer with a key of that name, at whatever address. */
struct vor_fairness_key vor_fairness_key_of_key(const char *name);

bool vor_fairness_key_same(const struct vor_fairness_key *a, const struct vor_fairness_key *b);

#endif
