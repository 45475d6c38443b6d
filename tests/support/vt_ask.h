/** Requests written as text, for tests that make many. */
#ifndef VT_ASK_H
#define VT_ASK_H

#include "tests/support/vt_engine.h"

/** One request: a cloud in, NAME=VALUE with blanks between, threads. */
struct vt_ask {
    const struct vor_cloud *in;
    const char *options;
    unsigned threads;
};

/** Runs a request to resample; out is initialised, and empty on failure. */
vor_status vt_ask_try(struct vor_cloud *out, struct vor_report *report,
                      const struct vt_ask *request);

/** The same; a failure fails the test. */
void vt_ask(struct vor_cloud *out, struct vor_report *report, const struct vt_ask *request);

/** The same on two threads, with options as printf writes them. */
void vt_resample(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
                 const char *format, ...) __attribute__((format(printf, 4, 5)));

/** Sets the parameters of an engine's request. */
void vt_ask_set(struct vt_engine *engine, const char *options);

#endif
