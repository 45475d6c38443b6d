/** Rows that a build adds to the tables without touching our files.
 *
 *  -DVOR_EXTENSIONS='"path/to/header.h"' names a header that defines some of the macros below, each
 *  a list to which X is applied as in the table that it ends. Without it they are empty. Every file
 *  of a build must be compiled with the same header, because enums and structs grow with their
 *  tables. */
#ifndef VOR_BASE_EXTENSIONS_H
#define VOR_BASE_EXTENSIONS_H

#ifdef VOR_EXTENSIONS
/* cppcheck-suppress preprocessorErrorDirective */
#include VOR_EXTENSIONS
#endif

/* core/report.h */
#ifndef VOR_EXTRA_RUN_STAGES
#define VOR_EXTRA_RUN_STAGES(X)
#endif
#ifndef VOR_EXTRA_STOPPED
#define VOR_EXTRA_STOPPED(X)
#endif
#ifndef VOR_EXTRA_DOCUMENTS
#define VOR_EXTRA_DOCUMENTS(X)
#endif

/* core/spec/tables.h */
#ifndef VOR_EXTRA_GROUPS
#define VOR_EXTRA_GROUPS(X)
#endif
#ifndef VOR_EXTRA_SPREAD_GROUPS /* a set, not a list */
#define VOR_EXTRA_SPREAD_GROUPS 0
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
#ifndef VOR_EXTRA_METHODS
#define VOR_EXTRA_METHODS(X)
#endif
#ifndef VOR_EXTRA_RUNNERS
#define VOR_EXTRA_RUNNERS(X)
#endif

#endif
