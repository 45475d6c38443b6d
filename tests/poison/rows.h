/** Processes that tests/poison adds to the product's tables: each ends whatever runs it, in a way
 *  of its own. They have no parameters, so that only the files that list processes differ. */
#ifndef VT_POISON_ROWS_H
#define VT_POISON_ROWS_H

#include "core/base/status.h"

#define VT_POISON_OUT ({"words", VOR_ARTEFACT_DOCUMENT, 1, "Nothing"})

#define VT_POISON(X, id, name, sentence)                                                           \
    X(id, name, 1, 0, 0, 0, 0, VOR_CLOUD_IN, VT_POISON_OUT, "End the program", sentence)

#define VOR_EXTRA_PROCESSES(X)                                                                     \
    VT_POISON(X, FAULT, fault, "Writes where there is no memory")                                  \
    VT_POISON(X, ABORT, abort, "Gives up")                                                         \
    VT_POISON(X, SPIN, spin, "Never ends and does not listen")                                     \
    VT_POISON(X, LEAK, leak, "Takes what memory there is, uncounted")

#define VOR_EXTRA_RUNNERS(X)                                                                       \
    X("fault", vt_poison_fault)                                                                    \
    X("abort", vt_poison_abort)                                                                    \
    X("spin", vt_poison_spin)                                                                      \
    X("leak", vt_poison_leak)

struct vor_artefacts;
struct vor_spec;
struct vor_run;

#define VT_POISON_RUN(name)                                                                        \
    VOR_NODISCARD vor_status vt_poison_##name(                                                     \
        struct vor_artefacts *out, const struct vor_artefacts *in, const struct vor_spec *spec,    \
        const struct vor_run *run, struct vor_error *err)

VT_POISON_RUN(fault);
VT_POISON_RUN(abort);
VT_POISON_RUN(spin);
VT_POISON_RUN(leak);

#endif
