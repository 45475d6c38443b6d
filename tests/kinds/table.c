/* What tests/unit/spec_table.c asks of every row, of rows of every kind. */
#include "tests/unit/spec_table.c"
