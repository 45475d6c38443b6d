/** Rows that a build adds to the tables without touching our files.
 *
 *  -DVOR_EXTENSIONS='"path/to/header.h"' names a header that defines some of the macros below, each
 *  a list to which X is applied as in the table that it ends. Without it they are empty. Files that
 *  share an enum or a struct that grows with its table must be compiled with the same header; a
 *  process alone lets none grow (tests/poison). */
#ifndef VOR_BASE_EXTENSIONS_H
#define VOR_BASE_EXTENSIONS_H

#ifdef VOR_EXTENSIONS
/* cppcheck-suppress preprocessorErrorDirective */
#include VOR_EXTENSIONS
#endif

/* core/spec/tables.h */
#ifndef VOR_EXTRA_GROUPS
#define VOR_EXTRA_GROUPS(X)
#endif
#ifndef VOR_EXTRA_METHOD_CHOICES
#define VOR_EXTRA_METHOD_CHOICES(X)
#endif
#ifndef VOR_EXTRA_PARAMETERS
#define VOR_EXTRA_PARAMETERS(X)
#endif
#ifndef VOR_EXTRA_PROCESSES
#define VOR_EXTRA_PROCESSES(X)
#endif
#ifndef VOR_EXTRA_PRESETS
#define VOR_EXTRA_PRESETS(X)
#endif
#ifndef VOR_EXTRA_NEEDS
#define VOR_EXTRA_NEEDS(X)
#endif

/* core/engine.c */
#ifndef VOR_EXTRA_RUNNERS
#define VOR_EXTRA_RUNNERS(X)
#endif

#endif
