/** Structs that describe themselves (core/base/members.h) as JSON. */
#ifndef VOR_PROTO_JSON_MEMBERS_H
#define VOR_PROTO_JSON_MEMBERS_H

#include "core/base/members.h"
#include "proto/json/json_read.h"
#include "proto/text.h"

/** Writes the members of values, a struct with that description, into an open object. */
void vor_json_members(struct vor_text *text, const struct vor_members *members, const void *values);

/** Writes a document as an object. */
void vor_json_document(struct vor_text *text, const struct vor_document *document);

/** Reads the members of an object back into values, a struct with that description; the object may
 * have others. The description has numbers and words only. A member that is missing
 * becomes 0, and so does a number that is none, negative or too large for its type; but a REAL that
 * is null becomes NAN, as which it was written. A word that is not among the row's becomes
 * word_count. */
void vor_json_members_read(void *values, const struct vor_members *members,
                           const struct vor_json *object);

/** Writes a JSON schema of a struct into an open object, in the dialect of OpenAPI 3.0: types,
 * descriptions and, as "x-unit", units. Every member is required but the optional ones. */
void vor_json_members_schema(struct vor_text *text, const struct vor_members *members);

#endif
