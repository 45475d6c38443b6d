/** What a PLY file has beside its points: remarks, which are kept, and what is left out. */
#ifndef VOR_PROTO_PLY_NOTES_H
#define VOR_PROTO_PLY_NOTES_H

#include "proto/ply/ply_header.h"

/** The remark that the writer makes, without "comment "; it is not kept, as each file gets it anew.
 */
#define VOR_PLY_SIGNATURE "written by voronoid"

/** Most bytes of remarks that are kept: what a reader's default of 65,536 bytes for a header
 * leaves, once the properties of any PLY file are written in it. */
enum { VOR_PLY_REMARKS_MAX = 49152 };

/** Adds to the cloud's notes the remarks of a header, control characters in them as '?', how many
 *  faces it declares, and what a cloud of the element `vertex` leaves out of the file: other
 *  elements, and lists.
 *
 *  @param[in] bytes       a file whose header is `header`
 *  @param[in] vertex      one of its elements
 *  @param[in] keep_faces  elements of faces (proto/ply/ply_faces.h) are not left out, only what
 *                         they have besides corners
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_ply_note(struct vor_cloud *cloud, const uint8_t *bytes,
                                      const struct vor_ply_header *header,
                                      const struct vor_ply_element *vertex, int keep_faces,
                                      struct vor_error *err);

#endif
