/** Structs that describe themselves (core/base/members.h) as rows of a table, RFC 4180 with LF for
 * CRLF. */
#ifndef VOR_PROTO_CSV_H
#define VOR_PROTO_CSV_H

#include "core/base/members.h"
#include "proto/text.h"

/** Writes the names of the members as the first line. The description has numbers and words only.
 */
void vor_csv_head(struct vor_text *text, const struct vor_members *members);

/** Writes values, a struct with that description, as a line. What is null in JSON is empty. */
void vor_csv_line(struct vor_text *text, const struct vor_members *members, const void *values);

#endif
