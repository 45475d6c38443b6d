#include "tests/support/vt_made.h"

#include "core/input/followed.h"
#include "core/input/input.h"

vor_status vt_made_make(struct vt_made *made, size_t to)
{
    struct vor_run *run = &made->engine.run;
    vor_status status =
        vor_input_prepare(&made->domain, &made->cloud, &made->engine.spec, run, &vt_err);

    if (status != VOR_OK)
        return status;
    status = vor_followed_make(&made->domain, &made->cloud, to, &made->engine.spec, run, &vt_err);
    if (status != VOR_OK)
        vor_domain_free(&made->domain);
    return status;
}

void vt_made_close(struct vt_made *made)
{
    vor_domain_free(&made->domain);
    vor_cloud_free(&made->cloud);
    vt_engine_close(&made->engine);
}
