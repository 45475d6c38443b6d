#include "core/method.h"

#include <assert.h>

static const struct vor_method methods[] = {{"cvt", vor_cvt_run}};

const struct vor_method *vor_method(unsigned index)
{
    assert(index < sizeof methods / sizeof methods[0]);
    return &methods[index];
}
