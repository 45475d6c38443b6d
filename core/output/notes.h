/** Carries what an input has beside its points to the result and its report. */
#ifndef VOR_OUTPUT_NOTES_H
#define VOR_OUTPUT_NOTES_H

#include "core/cloud/cloud.h"
#include "core/report.h"

/** Tells in the report what reading the input left out, and how many faces its file has. */
void vor_output_report_notes(struct vor_report *report, const struct vor_cloud *in);

/** The same, and which of its attributes the result does not have; also gives the result the
 *  remarks of the input.
 *
 *  @param[in,out] out  a cloud without remarks
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_output_notes(struct vor_cloud *out, struct vor_report *report,
                                          const struct vor_cloud *in, struct vor_error *err);

#endif
