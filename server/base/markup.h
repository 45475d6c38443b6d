/** The text that help topics are written in (server/cli/help): readable as it stands, and taken
 *  apart here for a terminal, the manual and a browser.
 *
 *    A heading          a line in the first column with dashes below
 *    A paragraph        lines in the first column
 *      a term           two blanks; what it means follows, six blanks deep
 *        lines          four blanks: shown as they are; `%sh` before them says what they are
 *    %table NAME        a table of ours (server/base/reference.h)
 *
 *  Blank lines part blocks. */
#ifndef VOR_SERVER_BASE_MARKUP_H
#define VOR_SERVER_BASE_MARKUP_H

#include <stddef.h>
#include <stdio.h>

enum vor_markup_kind {
    VOR_MARKUP_HEADING,
    VOR_MARKUP_PARAGRAPH,
    VOR_MARKUP_ITEM,
    VOR_MARKUP_CODE,
    VOR_MARKUP_TABLE
};

/** A part of a text; nothing is copied and nothing ends with a NUL. */
struct vor_span_of_text {
    const char *at;
    size_t length;
};

struct vor_markup_block {
    enum vor_markup_kind kind;
    struct vor_span_of_text term; /**< of an item; the name of a table */
    struct vor_span_of_text text; /**< words between blanks and line ends; of code its lines, each
                                       with four blanks before it */
};

/** The block at *at, which moves behind it; false at the end of the text. */
int vor_markup_next(struct vor_markup_block *out, const char **at);

/** The next word of a text, which loses it; false when there is none. */
int vor_markup_word(struct vor_span_of_text *out, struct vor_span_of_text *text);

/** The next line of code, without its four blanks; false when there is none. */
int vor_markup_line(struct vor_span_of_text *out, struct vor_span_of_text *text);

/** Writes words into lines of at most 79 columns, the first of which begins at `column`, the others
 *  behind `indent` blanks. Ends its last line. */
void vor_markup_wrap(FILE *out, struct vor_span_of_text text, int column, int indent);

/** The same for a whole string, whose first line is indented too. */
void vor_markup_wrap_string(FILE *out, const char *text, int indent);

#endif
