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
      "Kind of the missing content. comment or obj_info: lines of a PLY header; ELEMENT or "       \
      "ELEMENT.PROPERTY: an element of a PLY file, such as `face`, or one of its list "            \
      "properties; metadata: entries of a Draco file; digits of NAME: an attribute has integers "  \
      "that a double cannot hold; digits of positions: positions have doubles that float32 "       \
      "cannot hold; name of NAME: the name of an attribute has more than 63 bytes, or blanks, "    \
      "which PLY does not allow; meaning of NAME: an attribute lost its meaning, for example a "   \
      "normal that does not have three numbers; attribute NAME: a whole attribute; others: "       \
      "kinds that do not fit into this list")                                                      \
    X(U64, count, "count", "", "Number of missing items, as far as the file declares it")

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
