#include "server/api/handlers/openapi.h"

#include <stdint.h>

/* The assembler takes the file in; its path is seen from the root of the tree, where make runs. The
 * sections of ELF are what gcc and clang share here. */
__asm__(".pushsection .rodata, \"a\"\n"
        ".global vor_openapi_begin\n"
        ".global vor_openapi_length\n"
        "vor_openapi_begin:\n"
        ".incbin \"openapi.yaml\"\n"
        "vor_openapi_end:\n"
        ".byte 0\n"
        ".balign 8\n"
        "vor_openapi_length:\n"
        ".quad vor_openapi_end - vor_openapi_begin\n"
        ".popsection\n");

extern const char vor_openapi_begin[];
extern const uint64_t vor_openapi_length;

const char *vor_openapi_text(void)
{
    return vor_openapi_begin;
}

size_t vor_openapi_size(void)
{
    return (size_t)vor_openapi_length;
}
