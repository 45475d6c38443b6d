/* usage: pages PAGE: prints what the tables tell of a page: bash, zsh, fish, 1 or 8. */
#include "docker/pages/pages.h"

int main(int argc, char **argv)
{
    if (argc != 2 ||
        (vor_page_completion(stdout, argv[1]) != 0 && vor_page_manual(stdout, argv[1]) != 0)) {
        (void)fputs("pages: want bash, zsh, fish, 1 or 8\n", stderr);
        return 2;
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
