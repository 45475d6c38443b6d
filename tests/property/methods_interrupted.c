/* Every process and every method, short of memory, cancelled or stopped at any moment: a clear
 * status, nothing handed out, nothing left behind. */
#include "tests/support/vt_methods.h"

VT_TEST_LOOP(whichever_allocation_fails_nothing_is_left, vt_methods_count())
{
    if (vt_methods[_i].few > 0)
        vt_drive_failures(&vt_methods[_i]);
}

VT_TEST_LOOP(a_cancel_at_any_question_ends_with_nothing_a_stop_with_all_points, vt_methods_count())
{
    if (vt_methods[_i].few > 0)
        vt_drive_answers(&vt_methods[_i]);
}
