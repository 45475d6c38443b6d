#include "core/output/notes.h"

#include <string.h>

void vor_output_report_notes(struct vor_report *report, const struct vor_cloud *in)
{
    report->invalid = in->notes.invalid;
    report->dropped_count = in->notes.dropped_count;
    memcpy(report->dropped, in->notes.dropped, sizeof report->dropped);
}

vor_status vor_output_notes(struct vor_cloud *out, struct vor_report *report,
                            const struct vor_cloud *in, struct vor_error *err)
{
    vor_output_report_notes(report, in);
    return vor_notes_copy_remarks(&out->notes, &in->notes, out->memory, err);
}
