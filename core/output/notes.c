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

/* Tells which attributes of the input the result does not have. */
static void report_attributes(struct vor_report *report, const struct vor_cloud *out,
                              const struct vor_cloud *in)
{
    char what[VOR_MEMBER_TEXT_SIZE];

    for (size_t i = 0; i < in->attribute_count; i++) {
        const char *name = in->attributes[i].name;

        if (vor_cloud_find_name(out, name) != NULL)
            continue;
        (void)snprintf(what, sizeof what, "attribute %.50s", name);
        vor_dropped_add(report->dropped, &report->dropped_count, what, in->n);
    }
}

vor_status vor_output_notes(struct vor_cloud *out, struct vor_report *report,
                            const struct vor_cloud *in, struct vor_error *err)
{
    vor_output_report_notes(report, in);
    report_attributes(report, out, in);
    return vor_notes_copy_remarks(&out->notes, &in->notes, out->memory, err);
}
