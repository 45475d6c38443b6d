#include "core/mesh/close.h"

#include "core/mesh/crossing.h"
#include "core/mesh/cut.h"
#include "core/mesh/twosided.h"

#include <string.h>

struct closing {
    struct vor_complex *complex;
    struct vor_cut cut;
    struct vor_twosided sides; /* of the triangles there are */
};

static vor_status close_loop(struct closing *closing, size_t *closed, struct vor_error *err)
{
    vor_status status = VOR_OK;
    int whole = 1;

    if (closing->cut.count > VOR_CUT_MOST || !vor_cut_find(&closing->cut))
        return VOR_OK;
    for (unsigned t = 0; t < closing->cut.taken && status == VOR_OK; t++) {
        int takes =
            vor_complex_takes(closing->complex, closing->cut.triangle[t]) &&
            vor_twosided_takes(&closing->sides, closing->complex, closing->cut.triangle[t]) &&
            vor_crossing_near(closing->complex, closing->cut.balls, closing->cut.triangle[t], 0) ==
                closing->complex->count;

        whole &= takes;
        if (!takes)
            continue;
        status = vor_complex_add(closing->complex, closing->cut.triangle[t], err);
        if (status == VOR_OK)
            vor_twosided_add(&closing->sides, closing->complex,
                             (uint32_t)(closing->complex->count - 1));
    }
    *closed += whole != 0;
    return status;
}

vor_status vor_close(struct vor_complex *complex, size_t *closed, const struct vor_balls *balls,
                     const struct vor_run *run, struct vor_error *err)
{
    struct closing *closing = vor_calloc(complex->memory, 1, sizeof *closing);
    struct vor_rims rims = {.count = 0};
    vor_status status;

    *closed = 0;
    if (closing == NULL)
        return vor_fail(err, VOR_E_NOMEM, "closing loops of the mesh");
    closing->complex = complex;
    closing->cut.complex = complex;
    closing->cut.balls = balls;
    status = vor_rims_find(&rims, complex, balls->sheet, err);
    if (status == VOR_OK && rims.count > 0) /* a loop of k edges has k - 2 triangles */
        status = vor_twosided_make(&closing->sides, complex, rims.start[rims.count], err);
    for (size_t l = 0; l < rims.count && status == VOR_OK; l++) {
        vor_cut_set_loop(&closing->cut, &rims, l);
        status = vor_run_answered(vor_run_poll(run), err);
        VOR_THEN(status, close_loop(closing, closed, err));
    }
    vor_twosided_free(&closing->sides);
    vor_rims_free(&rims);
    vor_free(complex->memory, closing);
    return status;
}
