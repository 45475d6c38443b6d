/** What the fuzzers share: libFuzzer's entry, and a claim that ends the program where it does not
 * hold. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static inline void require(int holds, const char *what)
{
    if (holds)
        return;
    (void)fprintf(stderr, "%s: %s\n", __BASE_FILE__, what);
    abort();
}

/** The bytes as a string, to be freed. */
static inline char *fuzz_text(const uint8_t *bytes, size_t size)
{
    char *text = malloc(size + 1);

    require(text != NULL, "no memory");
    memcpy(text, bytes, size);
    text[size] = '\0';
    return text;
}

/** Hashes told events (FNV-1a), so that no memory hangs on them. */
#define FUZZ_HASH UINT64_C(0xcbf29ce484222325)

static inline void fuzz_mix(uint64_t *hash, const void *bytes, size_t size)
{
    const uint8_t *at = bytes;

    for (size_t i = 0; i < size; i++)
        *hash = (*hash ^ at[i]) * UINT64_C(0x100000001b3);
}

/** A copy of the next piece of bytes at `at`, to be freed, so that a read beyond it is seen: *size
 *  bytes of those left, or where that is 0 as many as its first one says, at most `most`. */
static inline uint8_t *fuzz_piece(const uint8_t *at, size_t left, unsigned most, size_t *size)
{
    uint8_t *copy;

    *size = *size > 0 ? *size : 1u + at[0] % most;
    *size = *size < left ? *size : left;
    copy = malloc(*size);
    require(copy != NULL, "no memory");
    memcpy(copy, at, *size);
    return copy;
}

#endif
