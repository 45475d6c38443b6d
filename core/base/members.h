/** Describes the members of structs that are written as JSON, CSV or traces.
 *
 *  Such a struct (progress record, report, measure) is one X-macro table with a row for each
 *  member: kind, member of the struct, name, unit, sentence. The table makes the C struct
 *  (VOR_FIELD) and the description below (VOR_MEMBER), so each member is spelled once; JSON, CSV,
 *  traces and the descriptions of processes read the description.
 *
 *  A name with dots puts the member into objects: "points.in" is the member "in" of the object
 *  "points". Rows that share an object stand next to each other. */
#ifndef VOR_BASE_MEMBERS_H
#define VOR_BASE_MEMBERS_H

#include <stddef.h>
#include <stdint.h>

/** How a member is stored, and what it is in JSON. */
enum vor_member_kind {
    VOR_MEMBER_U32,     /**< uint32_t: a number */
    VOR_MEMBER_U64,     /**< uint64_t: a number */
    VOR_MEMBER_REAL,    /**< double: a number, null when it is not finite */
    VOR_MEMBER_VECTOR,  /**< double[3]: the members x, y and z of an object */
    VOR_MEMBER_NUMBERS, /**< an array of `word_count` doubles: an array */
    VOR_MEMBER_TEXT,    /**< char[VOR_MEMBER_TEXT_SIZE]: a string */
    VOR_MEMBER_WORD,    /**< an enum that counts from 0: one of `words`, null past the last */
    VOR_MEMBER_OBJECT,  /**< a struct that has a table of its own, `inner`: an object */
    VOR_MEMBER_LIST,    /**< an array of such structs, and how many are in use: an array */
    VOR_MEMBER_REQUEST, /**< struct vor_spec: an object of its parameters that have a value */
    VOR_MEMBER_OPTIONAL /**< int, not told itself: where it is 0, the object of this name, whose
                             rows follow, is left out */
};

/** Bytes of a text, with its NUL. */
#define VOR_MEMBER_TEXT_SIZE 64

struct vor_members;

/** One row. */
struct vor_member {
    const char *name;
    const char *unit; /**< "" for none */
    const char *sentence;
    enum vor_member_kind kind;
    size_t offset;                   /**< of the member in its struct */
    const char *const *words;        /**< WORD: words[0 .. word_count - 1] */
    unsigned word_count;             /**< WORD, NUMBERS */
    const struct vor_members *inner; /**< OBJECT, LIST */
    size_t count_offset;             /**< LIST: of the unsigned that says how many are in use */
};

/** The description of a struct: its rows, in the order in which they are told. */
struct vor_members {
    const struct vor_member *rows;
    unsigned count;
    size_t size; /**< of the struct */
};

/** What a process hands out that is no cloud: a name ("report") and values with their table. Owns
 *  nothing. */
struct vor_document {
    const char *name;
    const struct vor_members *members;
    const void *values; /**< a struct of members->size bytes */
};

/** The member of `values` that a row describes. */
static inline const void *vor_member_at(const struct vor_member *member, const void *values)
{
    return (const unsigned char *)values + member->offset;
}

/** VOR_FIELD declares the member of a row; VOR_MEMBER describes it, given its struct. A table may
 *  use kinds of its own, such as an enum or a list: it defines VOR_FIELD_<kind> and
 *  VOR_KIND_OF_<kind> for each. */
#define VOR_FIELD(kind, field, name, unit, sentence) VOR_FIELD_##kind(field)
#define VOR_FIELD_U32(field) uint32_t field;
#define VOR_FIELD_U64(field) uint64_t field;
#define VOR_FIELD_REAL(field) double field;
#define VOR_FIELD_VECTOR(field) double field[3];
#define VOR_FIELD_TEXT(field) char field[VOR_MEMBER_TEXT_SIZE];
#define VOR_FIELD_OPTIONAL(field) int field;

#define VOR_MEMBER(type, member_kind, field, member_name, member_unit, text)                       \
    {.name = (member_name),                                                                        \
     .unit = (member_unit),                                                                        \
     .sentence = (text),                                                                           \
     .offset = offsetof(type, field),                                                              \
     VOR_KIND_OF_##member_kind(type, field)},
#define VOR_KIND_OF_U32(type, field) .kind = VOR_MEMBER_U32
#define VOR_KIND_OF_U64(type, field) .kind = VOR_MEMBER_U64
#define VOR_KIND_OF_REAL(type, field) .kind = VOR_MEMBER_REAL
#define VOR_KIND_OF_VECTOR(type, field) .kind = VOR_MEMBER_VECTOR
#define VOR_KIND_OF_TEXT(type, field) .kind = VOR_MEMBER_TEXT
#define VOR_KIND_OF_OPTIONAL(type, field) .kind = VOR_MEMBER_OPTIONAL

/** The description of `type` from its rows, an array. */
#define VOR_MEMBERS(type, rows_of)                                                                 \
    {                                                                                              \
        .rows = (rows_of), .count = sizeof(rows_of) / sizeof(rows_of)[0], .size = sizeof(type)     \
    }

#endif
