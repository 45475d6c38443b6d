/** Which words somebody may have meant by one that nobody knows: up to three, nearest first. */
#ifndef VOR_BASE_NEAREST_H
#define VOR_BASE_NEAREST_H

#include <stddef.h>

enum {
    VOR_NEAREST_MAX = 3,
    VOR_NEAREST_WORD = 64,      /**< bytes that are compared; a longer word is near nothing */
    VOR_NEAREST_TEXT_SIZE = 256 /**< of vor_nearest_text, with the NUL */
};

struct vor_nearest {
    char word[VOR_NEAREST_WORD + 1]; /**< in lower case; "" if it is too long */
    size_t near;                     /**< most edits of a word that is near */
    unsigned count;
    struct {
        const char *word;
        size_t length, edits;
    } found[VOR_NEAREST_MAX];
};

/** Begins with the word that is unknown: one edit in three bytes is near, one at least if it has
 *  three bytes. An edit inserts, deletes, replaces or swaps; case does not count. */
void vor_nearest_init(struct vor_nearest *nearest, const char *word, size_t length);

/** The same, but any word is near enough. */
void vor_nearest_init_any(struct vor_nearest *nearest, const char *word, size_t length);

/** Offers a word, which is borrowed. Of equally near ones the first come first. */
void vor_nearest_try(struct vor_nearest *nearest, const char *word, size_t length);

/** "; did you mean --a, --b or --c?", each with the prefix; "" if none is near. Returns out. */
const char *vor_nearest_text(const struct vor_nearest *nearest, const char *prefix,
                             char out[VOR_NEAREST_TEXT_SIZE]);

#endif
