#include "core/output/notes.h"

#include <stdio.h>
#include <string.h>

void vor_output_report_notes(struct vor_report *report, const struct vor_cloud *in)
{
    report->invalid = in->notes.invalid;
    report->faces = in->notes.faces;
    report->dropped_count = in->notes.dropped_count;
    memcpy(report->dropped, in->notes.dropped, sizeof report->dropped);
}

vor_status vor_output_notes(struct vor_cloud *out, struct vor_report *report,
                            const struct vor_cloud *in, struct vor_error *err)
{
    char what[VOR_MEMBER_TEXT_SIZE];

    vor_output_report_notes(report, in);
    for (size_t i = 0; i < in->attribute_count; i++) {
        const char *name = in->attributes[i].name;

        if (vor_cloud_find_name(out, name) != NULL)
            continue;
        (void)snprintf(what, sizeof what, "attribute %.50s", name);
        vor_dropped_add(report->dropped, &report->dropped_count, what, in->n);
    }
    return vor_notes_copy_remarks(&out->notes, &in->notes, out->memory, err);
}
