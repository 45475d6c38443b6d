/* Every process and every method, short of memory, cancelled or stopped at any moment: a clear
 * status, nothing handed out, nothing left behind. */
#include "tests/support/vt_methods.h"

START_TEST(whichever_allocation_fails_nothing_is_left)
{
    if (vt_methods[_i].few > 0)
        vt_drive_failures(&vt_methods[_i]);
}
END_TEST

START_TEST(a_cancel_at_any_question_ends_with_nothing_a_stop_with_all_points)
{
    if (vt_methods[_i].few > 0)
        vt_drive_answers(&vt_methods[_i]);
}
END_TEST

void vt_suite(Suite *suite)
{
    vt_add_loop(suite, whichever_allocation_fails_nothing_is_left, vt_methods_count());
    vt_add_loop(suite, a_cancel_at_any_question_ends_with_nothing_a_stop_with_all_points,
                vt_methods_count());
}
