#include "server/cli/cli.h"

#include "server/cli/cli_log.h"

#include <string.h>

/* The pages: name, option. The assembler takes each in from the folder where make has made it. */
#define PAGES(X)                                                                                   \
    X(bash, "--completion")                                                                        \
    X(zsh, "--completion") X(fish, "--completion") X(1, "--man") X(8, "--man")

#define EMBED(name, option)                                                                        \
    __asm__(".pushsection .rodata, \"a\"\n"                                                        \
            ".global vor_page_text_" #name "\n"                                                    \
            "vor_page_text_" #name ":\n"                                                           \
            ".incbin \"voronoid." #name "\"\n"                                                     \
            ".byte 0\n"                                                                            \
            ".popsection\n");                                                                      \
    extern const char vor_page_text_##name[];
PAGES(EMBED)
#undef EMBED

int vor_cli_page(FILE *out, const char *option, const char *name)
{
    static const struct {
        const char *option, *name, *text;
    } pages[] = {
#define ROW(name, option) {option, #name, vor_page_text_##name},
        PAGES(ROW)
#undef ROW
    };

    for (size_t i = 0; i < sizeof pages / sizeof pages[0]; i++)
        if (strcmp(pages[i].option, option) == 0 && strcmp(pages[i].name, name) == 0)
            return fputs(pages[i].text, out) >= 0 && fflush(out) == 0 ? VOR_EXIT_OK
                                                                      : VOR_EXIT_FAILED;
    vor_cli_say(option, strcmp(option, "--man") == 0 ? "want 1 (the commands) or 8 (the daemon)"
                                                     : "want bash, zsh or fish");
    return VOR_EXIT_USAGE;
}
