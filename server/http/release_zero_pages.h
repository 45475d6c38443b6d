/** Giving memory back to the system that holds nothing but zeros. */
#ifndef VOR_SERVER_HTTP_RELEASE_ZERO_PAGES_H
#define VOR_SERVER_HTTP_RELEASE_ZERO_PAGES_H

#include <stddef.h>

/** Returns the pages of zeros in the mapping that begins at `start`, which must be the beginning of
 *  a page, for bytes bytes. They read as zeros afterwards, as before, and cost nothing until they
 *  are written again. The memory must be private, backed by no file, and not written by another
 *  thread during the call.
 *
 *  Cost: reads the range, and a system call for each run of such pages. */
void vor_release_zero_pages(void *start, size_t bytes);

#endif
