/** A run of the engine taken apart: a hash for each of its stages. Knows the engine's rooms, so
 * that the tests that compare hashes need not. */
#ifndef VT_STAGES_H
#define VT_STAGES_H

#include "core/engine.h"

#include <stdint.h>

/** Identifier, word in messages. What each hash covers is said in vt_stages.c. */
#define VT_STAGE_TABLE(X)                                                                          \
    X(INPUT, "input")                                                                              \
    X(START, "start")                                                                              \
    X(ITERATE, "iterate")                                                                          \
    X(EVEN_OUT, "even out")                                                                        \
    X(OUTPUT, "output")                                                                            \
    X(REPORT, "report")

enum vt_stage {
#define VT_STAGE_ENUM(id, word) VT_STAGE_##id,
    VT_STAGE_TABLE(VT_STAGE_ENUM)
#undef VT_STAGE_ENUM
        VT_STAGE_COUNT
};

const char *vt_stage_word(enum vt_stage stage);

/** What is run. */
struct vt_stages_run {
    const struct vor_cloud *in;
    struct vor_spec spec; /**< checked */
    unsigned stop; /**< the watch answers VOR_STOP to this record, counted from 1; 0: never */
    unsigned threads;
};

/** Goes the way of vor_engine_run step by step and hashes what each stage leaves. Asserts that
 * every step works. Nothing that depends on time or memory is hashed, and no padding. The clock of
 * the run shows how many records were told, so that a limit in seconds ends it at a known place. */
void vt_stages_drive(uint64_t hash[VT_STAGE_COUNT], const struct vt_stages_run *run);

/** The same run by vor_engine_run. Sets hash[VT_STAGE_OUTPUT] and hash[VT_STAGE_REPORT], which say
 *  whether vt_stages_drive still goes the engine's way, and leaves the others. */
void vt_stages_engine(uint64_t hash[VT_STAGE_COUNT], const struct vt_stages_run *run);

#endif
