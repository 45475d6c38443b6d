/** Callers with the same key share one limit. */
#ifndef VOR_SERVER_BASE_FAIRNESS_KEY_H
#define VOR_SERVER_BASE_FAIRNESS_KEY_H

#include "server/base/address.h"

#include <stdbool.h>

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

#endif
