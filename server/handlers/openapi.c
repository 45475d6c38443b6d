#include "server/handlers/openapi.h"

/* The assembler takes the file in; its path is seen from the root of the tree, where make runs. The
 * sections of ELF are what gcc and clang share here. */
__asm__(".pushsection .rodata, \"a\"\n"
        ".global vor_openapi_begin\n"
        ".global vor_openapi_end\n"
        "vor_openapi_begin:\n"
        ".incbin \"openapi.yaml\"\n"
        "vor_openapi_end:\n"
        ".byte 0\n"
        ".popsection\n");

extern const char vor_openapi_begin[], vor_openapi_end[];

const char *vor_openapi_text(void)
{
    return vor_openapi_begin;
}

size_t vor_openapi_size(void)
{
    return (size_t)(vor_openapi_end - vor_openapi_begin);
}
