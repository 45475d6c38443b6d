#include "proto/ply/ply_notes.h"

#include "proto/ply/ply_faces.h"

#include <stdio.h>
#include <string.h>

/* Notes one property of an element as ELEMENT.PROPERTY. */
static void note_property(struct vor_notes *notes, const struct vor_ply_element *element,
                          const struct vor_ply_property *property)
{
    char what[VOR_MEMBER_TEXT_SIZE];
    int of = element->name_length < sizeof what ? (int)element->name_length : (int)sizeof what - 1;
    int name =
        property->name_length < sizeof what ? (int)property->name_length : (int)sizeof what - 1;

    (void)snprintf(what, sizeof what, "%.*s.%.*s", of, element->name, name, property->name);
    vor_dropped_add(notes->dropped, &notes->dropped_count, what, element->count);
}

/* Notes an element beside the vertices: where it holds faces that are kept, what else it has. */
static void note_other(struct vor_notes *notes, const struct vor_ply_element *element,
                       int keep_faces)
{
    int list = vor_ply_face_list(element);

    if (list >= 0 && __builtin_add_overflow(notes->faces, element->count, &notes->faces))
        notes->faces = UINT64_MAX;
    if (list < 0 || !keep_faces) {
        char what[VOR_MEMBER_TEXT_SIZE];

        (void)snprintf(what, sizeof what, "%.*s",
                       element->name_length < sizeof what ? (int)element->name_length
                                                          : (int)sizeof what - 1,
                       element->name);
        vor_dropped_add(notes->dropped, &notes->dropped_count, what, element->count);
        return;
    }
    for (unsigned k = 0; k < element->property_count; k++)
        if ((int)k != list)
            note_property(notes, element, &element->properties[k]);
}

/* Writes the remarks among the lines of a header, up to VOR_PLY_REMARKS_MAX, and counts the others;
 * returns the bytes written. out may be NULL. */
static size_t put_remarks(char *out, uint64_t *others, const uint8_t *bytes, size_t size)
{
    static const char signature[] = "comment " VOR_PLY_SIGNATURE;
    uint8_t stop = vor_ply_line_stop(bytes, size);
    size_t used = 0, length;

    *others = 0;
    for (size_t at = 0; at < size; at += length + 1) {
        const char *line = (const char *)bytes + at;
        const char *end = memchr(line, stop, size - at);
        size_t kept;

        length = end != NULL ? (size_t)(end - line) : size - at;
        kept = length - (stop == '\n' && length > 0 && line[length - 1] == '\r');
        if (!vor_ply_is_remark(line, kept) ||
            (kept == sizeof signature - 1 && memcmp(line, signature, kept) == 0))
            continue;
        if (used + kept + 1 > VOR_PLY_REMARKS_MAX) {
            ++*others;
            continue;
        }
        for (size_t i = 0; out != NULL && i < kept; i++) {
            uint8_t c = (uint8_t)line[i];

            out[used + i] = (c < 0x20 && c != '\t') || c == 0x7f ? '?' : line[i];
        }
        if (out != NULL)
            out[used + kept] = '\n';
        used += kept + 1;
    }
    return used;
}

vor_status vor_ply_note(struct vor_cloud *cloud, const uint8_t *bytes,
                        const struct vor_ply_header *header, const struct vor_ply_element *vertex,
                        int keep_faces, struct vor_error *err)
{
    struct vor_notes *notes = &cloud->notes;
    uint64_t others;
    size_t size = put_remarks(NULL, &others, bytes, header->body);

    for (unsigned i = 0; i < header->element_count; i++)
        if (&header->elements[i] != vertex)
            note_other(notes, &header->elements[i], keep_faces);
    for (unsigned k = 0; k < vertex->property_count; k++)
        if (vertex->properties[k].list)
            note_property(notes, vertex, &vertex->properties[k]);
    vor_dropped_add(notes->dropped, &notes->dropped_count, "comment", others);
    if (size == 0)
        return VOR_OK;
    notes->remarks = vor_malloc(cloud->memory, size, 1);
    if (notes->remarks == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu bytes of comments", size);
    notes->remarks_size = put_remarks(notes->remarks, &others, bytes, header->body);
    return VOR_OK;
}
