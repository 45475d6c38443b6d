/** A cloud, a request for it, and the domain with what the request wants followed. */
#ifndef VT_MADE_H
#define VT_MADE_H

#include "core/input/domain.h"
#include "tests/support/vt_engine.h"

/** All zero but for engine, which the test opens, and cloud, which it makes, before vt_made_make.
 */
struct vt_made {
    struct vt_engine engine;
    struct vor_cloud cloud;
    struct vor_domain domain;
};

/** vor_input_prepare, then vor_followed_make for `to` points; there is no domain on failure. */
vor_status vt_made_make(struct vt_made *made, size_t to);

/** Frees all of it, and asserts that nothing leaked. */
void vt_made_close(struct vt_made *made);

#endif
