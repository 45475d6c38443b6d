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

#endif
