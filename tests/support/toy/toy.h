/** A dry run of the seams: rows that config=toy adds to the tables of the product
 *  (core/base/extensions.h). tests/toy drives the binary that comes of it.
 *
 *  The method `toy` copies points of the input, in two stages. The process `excerpt` is resample by
 *  that method alone; `census` counts the points of one cloud, and `overlap` tells how far two
 *  clouds lie from each other: both hand out a document. `ribbon` is convert that adds faces, and
 *  `poison` crashes the program. The parameters are of every kind that no parameter of the product
 * has. */
#ifndef VOR_TOY_H
#define VOR_TOY_H

#include "core/base/status.h"

#include <stddef.h>

/* --- core/report.h ---------------------------------------------------------------------------- */

#define VOR_EXTRA_RUN_STAGES(X)                                                                    \
    X(COPY, "copy", "copied part", "Copies points of the input")                                   \
    X(PROVE, "prove", "proved part", "Finds every copy among the points of the input")             \
    X(TALLY, "tally", "tallied part", "Counts the points and measures their box")                  \
    X(REACH, "reach", "reached part", "Counts the points near the middle")                         \
    X(FORTH, "forth", "part there", "Measures from the cloud to the other one")                    \
    X(BACK, "back", "part back", "Measures from the other cloud to this one")

#define VOR_EXTRA_STOPPED(X) X(COPIED, "copied")

#define VOR_EXTRA_DOCUMENTS(X)                                                                     \
    X("census", vor_toy_census_members)                                                            \
    X("overlap", vor_toy_overlap_members)

/* --- core/spec/tables.h ----------------------------------------------------------------------- */

#define VOR_EXTRA_GROUPS(X)                                                                        \
    X(TOY_STEPS, "The steps of the toy")                                                           \
    X(TOY_POINTS, "Points that count")                                                             \
    X(TOY_CENSUS, "The census")                                                                    \
    X(TOY_OVERLAP, "The overlap")                                                                  \
    X(TOY_POISON, "The poison")

#define VOR_EXTRA_SPREAD_GROUPS VOR_IN(TOY_STEPS)

#define VOR_EXTRA_METHOD_CHOICES(X) X(TOY, "toy")

#define VOR_EXTRA_PARAMETERS(X)                                                                    \
    X(PARTS, parts, COUNT, TOY_STEPS, "steps", 1, 100000, 4, "",                                   \
      "Steps that each stage of the toy takes")                                                    \
    X(PAUSE, pause, REAL_OR_WORD, TOY_STEPS, "s", 0, 60, VOR_WORD(0), "none blink",                \
      "Time that each of its steps takes at least; blink is 0.05 s")                               \
    X(AMONG, among, CHOICE_OR_NAME, TOY_POINTS, "", 1, 40, 0, "all attribute:NAME",                \
      "Points that count; attribute:NAME: those where that attribute is not 0")                    \
    X(AXES, axes, LIST_OR_AUTO, TOY_POINTS, "", 0, 0, VOR_UNSET, "x y z",                          \
      "Axes that lengths are taken along; auto: those along which points differ")                  \
    X(NEARBY, nearby, REAL_OR_AUTO, TOY_POINTS, "unit of the cloud", 0, 1e30, VOR_UNSET, "",       \
      "Distance that is near; auto: half the diagonal of the box, or the mean distance")           \
    X(STRICT, strict, FLAG, TOY_POINTS, "", 0, 0, 0, "", "Points at just that distance are not")   \
    X(REMARK, remark, TEXT, TOY_POINTS, "", 0, 60, VOR_UNSET, "", "A text for the document")       \
    X(TELL, tell, LIST, TOY_CENSUS, "", 0, 0, 3, "box middle", "Parts that the document has")      \
    X(BACKWARD, backward, FLAG, TOY_OVERLAP, "", 0, 0, 0, "",                                      \
      "Distances from the other cloud to this one are told, too")                                  \
    X(VENOM, venom, CHOICE, TOY_POISON, "", 0, 0, 0, "fault abort spin leak",                      \
      "How the program ends, if it does. fault: it writes where there is no memory; abort: it "    \
      "gives up; spin: it never ends; leak: it takes what memory there is, uncounted")

#define VOR_TOY_TWO_IN                                                                             \
    ({"cloud", VOR_ARTEFACT_CLOUD, 1, "The point cloud, recognised by its bytes"},                 \
     {"other", VOR_ARTEFACT_CLOUD, 1, "The cloud beside it"})
#define VOR_TOY_CENSUS_OUT                                                                         \
    ({"census", VOR_ARTEFACT_DOCUMENT, 1, "How many points there are, and where"})
#define VOR_TOY_OVERLAP_OUT                                                                        \
    ({"overlap", VOR_ARTEFACT_DOCUMENT, 1, "How many points are near the other cloud"})

#define VOR_EXTRA_PROCESSES(X)                                                                     \
    X(EXCERPT, excerpt, 1, VOR_SPREAD_GROUPS & ~VOR_IN(CVT), VOR_BY(TOY), 0, 1, VOR_CLOUD_IN,      \
      VOR_CLOUD_OUT, "Take an excerpt of a point cloud", "Copies the number of points asked for")  \
    X(CENSUS, census, 1, VOR_IN(TOY_STEPS) | VOR_IN(TOY_POINTS) | VOR_IN(TOY_CENSUS), 0, 0, 0,     \
      VOR_CLOUD_IN, VOR_TOY_CENSUS_OUT, "Count the points of a cloud",                             \
      "Tells how many points a cloud has, and where they lie")                                     \
    X(OVERLAP, overlap, 0, VOR_IN(TOY_STEPS) | VOR_IN(TOY_POINTS) | VOR_IN(TOY_OVERLAP), 0, 0, 0,  \
      VOR_TOY_TWO_IN, VOR_TOY_OVERLAP_OUT, "Compare two clouds",                                   \
      "Tells how far the points of a cloud lie from another one")                                  \
    X(RIBBON, ribbon, 1, VOR_IN(READ) | VOR_IN(FORMAT), 0, 0, 0, VOR_CLOUD_IN, VOR_CLOUD_OUT,      \
      "Join points by triangles", "Joins each three successive points of a cloud by a triangle")   \
    X(POISON, poison, 1, VOR_IN(TOY_POISON), 0, 0, 0, VOR_CLOUD_IN, VOR_TOY_CENSUS_OUT,            \
      "End the program", "Crashes whatever runs it")

#define VOR_EXTRA_PRESETS(X)                                                                       \
    X(EXCERPT, METHOD, VOR_METHOD_TOY)                                                             \
    X(OVERLAP, PARTS, 3)

/* --- core/engine.c ---------------------------------------------------------------------------- */

#define VOR_EXTRA_METHODS(X) X("toy", vor_toy_run)

#define VOR_EXTRA_RUNNERS(X)                                                                       \
    X("excerpt", run_resample)                                                                     \
    X("census", vor_toy_census)                                                                    \
    X("overlap", vor_toy_overlap)                                                                  \
    X("ribbon", vor_toy_ribbon)                                                                    \
    X("poison", vor_toy_poison)

/* ---------------------------------------------------------------------------------------------- */

struct vor_artefacts;
struct vor_domain;
struct vor_members;
struct vor_outcome;
struct vor_run;
struct vor_seeds;
struct vor_spec;

extern const struct vor_members vor_toy_census_members, vor_toy_overlap_members;

/** A vor_method's run (core/method.h): n points of the domain at equal steps along its order. Goes
 *  through the stages COPY and PROVE; a stop ends the first at once, with every point copied, and
 *  leaves the second out.
 *
 *  @param[in] spec  read: boundary, parts, pause
 *
 *  @retval VOR_E_TARGET    n exceeds the points of the domain
 *  @retval VOR_E_INTERNAL  a copy is not among them
 *  @retval VOR_E_CANCELLED, VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_toy_run(struct vor_seeds *out, struct vor_outcome *told,
                                     const struct vor_domain *domain, size_t n,
                                     const struct vor_spec *spec, const struct vor_run *run,
                                     struct vor_error *err);

/** A vor_process's run (core/process.h): `cloud` in, the document `census` out. Goes through the
 *  stages TALLY and REACH; a stop ends it with what was counted.
 *
 *  @retval VOR_E_PARAM  `among` names an attribute that the cloud does not have
 *  @retval VOR_E_CANCELLED, VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_toy_census(struct vor_artefacts *out, const struct vor_artefacts *in,
                                        const struct vor_spec *spec, const struct vor_run *run,
                                        struct vor_error *err);

/** The same: `cloud` and `other` in, the document `overlap` out. Goes through the stage FORTH and,
 *  where the request asks for it, BACK. `among` chooses among the points of `cloud`; the distances
 *  are those to all of `other`, and back to all of `cloud`.
 *
 *  @retval VOR_E_PARAM  as vor_toy_census
 *  @retval VOR_E_CANCELLED, VOR_E_NOMEM; a stop ends it as VOR_E_STOPPED */
VOR_NODISCARD vor_status vor_toy_overlap(struct vor_artefacts *out, const struct vor_artefacts *in,
                                         const struct vor_spec *spec, const struct vor_run *run,
                                         struct vor_error *err);

/** The same: `cloud` in, and out again with faces, a strip of triangles along the order of its
 *  points, which lie in rows of two for it to be a surface; and a `report`.
 *
 *  @retval VOR_E_CANCELLED, VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_toy_ribbon(struct vor_artefacts *out, const struct vor_artefacts *in,
                                        const struct vor_spec *spec, const struct vor_run *run,
                                        struct vor_error *err);

/** The same, but for how it ends: the program does not survive it. Reads venom. */
VOR_NODISCARD vor_status vor_toy_poison(struct vor_artefacts *out, const struct vor_artefacts *in,
                                        const struct vor_spec *spec, const struct vor_run *run,
                                        struct vor_error *err);

#endif
