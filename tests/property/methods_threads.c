/* Every process and every method gives the same bytes at one thread and at three: positions,
 * attributes, triangles, and what the documents say. ThreadSanitizer runs this program for all of
 * the engine. */
#include "tests/support/vt_methods.h"

#include <string.h>

VT_TEST_LOOP(one_and_three_threads_give_the_same_bytes, vt_methods_count())
{
    vt_drive_threads(&vt_methods[_i]);
}

static int is_run(const char *words)
{
    for (int i = 0; i < vt_methods_count(); i++)
        if (strstr(vt_methods[i].options, words) != NULL)
            return 1;
    return 0;
}

/* A further process or method needs a row. */
VT_TEST(every_process_and_method_has_a_row)
{
#define CHECK_METHOD(id, word)                                                                     \
    ck_assert(VOR_METHOD_##id == VOR_METHOD_CVT || is_run("method=" word));
    VOR_METHOD_CHOICE_TABLE(CHECK_METHOD)
#undef CHECK_METHOD
    for (unsigned p = 0; vor_process_info(p) != NULL; p++)
        ck_assert_msg(is_run(vor_process_info(p)->id), "no row runs %s", vor_process_info(p)->id);
}
