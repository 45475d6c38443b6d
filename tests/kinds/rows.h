/** Rows that the tests in tests/kinds add to the tables of requests: a parameter of each kind that
 *  the product has none of, in a group of their own, and a process that takes them. */
#ifndef VT_KINDS_ROWS_H
#define VT_KINDS_ROWS_H

#define VOR_EXTRA_GROUPS(X) X(KINDS, "Kinds")

#define VOR_EXTRA_METHOD_CHOICES(X) X(SLOW, "slow") X(SLOWER, "slower")

#define VOR_EXTRA_PARAMETERS(X)                                                                    \
    X(LABEL, label, TEXT, KINDS, "", 1, 300, VOR_UNSET, "", "A text")                              \
    X(CLOSED, closed, FLAG, KINDS, "", 0, 0, 0, "", "A flag")                                      \
    X(SIEVES, sieves, LIST, KINDS, "", 0, 0, 2, "mls outliers thin", "A list")                     \
    X(WEIGHT, weight, CHOICE_OR_NAME, KINDS, "", 1, 200, 0, "even attribute:NAME",                 \
      "A word or a name")                                                                          \
    X(TITLE, title, TEXT, KINDS, "", 0, 300, VOR_UNSET, "", "Another text")                        \
    X(RUNGS, rungs, LIST_OR_AUTO, KINDS, "", 0, 0, VOR_UNSET, "up down", "A list or auto")         \
    X(ANGLE, angle, REAL_OR_WORD, KINDS, "degrees", 0, 90, VOR_WORD(0), "mean max",                \
      "A number or a word")                                                                        \
    X(REACH, reach, REAL_OR_AUTO, KINDS, "", 0, 1, 0.25, "", "A number or auto")

#define VT_KINDS_IN                                                                                \
    ({"first", VOR_ARTEFACT_CLOUD, 1, "The one cloud"},                                            \
     {"second", VOR_ARTEFACT_CLOUD, 1, "The other cloud"},                                         \
     {"third", VOR_ARTEFACT_CLOUD, 0, "What nobody needs"})
#define VT_KINDS_OUT ({"words", VOR_ARTEFACT_DOCUMENT, 1, "What was asked for"})

#define VOR_EXTRA_PROCESSES(X)                                                                     \
    X(KINDS, kinds, 0, VOR_IN(KINDS) | VOR_IN(SPREAD), VOR_BY(CVT) | VOR_BY(SLOWER), 0, 0,         \
      VT_KINDS_IN, VT_KINDS_OUT, "Take every kind", "Takes a parameter of every kind")

#define VOR_EXTRA_PRESETS(X)                                                                       \
    X(KINDS, REACH, VOR_UNSET)                                                                     \
    X(KINDS, CLOSED, 1)

#define VOR_EXTRA_NEEDS(X) X(TITLE, "third")

#endif
