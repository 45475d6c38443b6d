/* main() of a test program that has none of its own. */
#include "tests/support/vt.h"

int main(void)
{
    Suite *suite = suite_create("tests"); /* TAP names the file and the test, not the suite */

    if (vt_suite != NULL)
        vt_suite(suite);
    return vt_run(suite);
}
