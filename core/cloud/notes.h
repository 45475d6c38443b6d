/** What a cloud has beside its points: the remarks of its file, and what reading left out. */
#ifndef VOR_CLOUD_NOTES_H
#define VOR_CLOUD_NOTES_H

#include "core/base/members.h"
#include "core/base/memory.h"
#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

/** Something that was left out. */
#define VOR_DROPPED_TABLE(X)                                                                       \
    X(TEXT, what, "what", "",                                                                      \
      "Kind of content: comment, obj_info, an element of a PLY file such as face, a list "         \
      "property as ELEMENT.PROPERTY, metadata (entries of a Draco file), digits of an attribute "  \
      "(integers that a double cannot hold) or of positions (doubles that float32 cannot hold), "  \
      "name of an attribute (longer than 63 bytes, or with blanks, which PLY does not allow), "    \
      "meaning of an attribute (such as a normal without three numbers), attribute and its name, " \
      "or others, if there are more kinds than fit here")                                          \
    X(U64, count, "count", "", "How many, as far as the file says")

struct vor_dropped {
    VOR_DROPPED_TABLE(VOR_FIELD)
};

/** Most kinds of things in a list; further ones are counted together. A PLY file has at most 15
 *  other elements; more list properties than the rest holds are rare. */
#define VOR_DROPPED_MAX 24

/** A list of what was left out, as a member of a report. */
#define VOR_FIELD_DROPPED(field)                                                                   \
    struct vor_dropped field[VOR_DROPPED_MAX];                                                     \
    unsigned field##_count;

/** All zero for a cloud that was not read from a file. */
struct vor_notes {
    unsigned format;  /**< of the file, a word of the parameter of that name */
    uint64_t invalid; /**< points left out, as one of their coordinates was not finite */
    uint64_t faces; /**< that the file has, as far as it says; a strip of triangles counts as one */
    char *remarks;  /**< lines "comment ..." and "obj_info ...", each with '\n' and without other
                         control characters than tabs; owned by the cloud, NULL for none */
    size_t remarks_size;
    VOR_FIELD_DROPPED(dropped)
};

/** Adds to a list that `count` of something were left out; nothing if that is 0.
 *
 *  @param[in] what  without control characters; cut to what fits */
void vor_dropped_add(struct vor_dropped list[VOR_DROPPED_MAX], unsigned *list_count,
                     const char *what, uint64_t count);

/** Counts the remarks that begin with a word. */
uint64_t vor_notes_remarks(const struct vor_notes *notes, const char *word);

/** Copies the remarks of notes to notes that have none.
 *
 *  @retval VOR_E_NOMEM they do not fit; *out is as it was */
VOR_NODISCARD vor_status vor_notes_copy_remarks(struct vor_notes *out, const struct vor_notes *in,
                                                struct vor_memory *memory, struct vor_error *err);

#endif
