/* main() of a test program that defines vt_suite and no main() of its own. */
#include "tests/support/vt.h"

int main(void)
{
    Suite *suite = suite_create("tests"); /* TAP names the file and the test, not the suite */

    vt_suite(suite);
    return vt_run(suite);
}
