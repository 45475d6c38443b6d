/** Tables of small input files, written by hand (tests/data/), and what must come out of each.
 *
 *  A line is `name | what comes out | file`; one that begins with blanks continues the line before.
 *  `#` begins a comment, `[drc points=9 faces drop strict]` the format (PLY without drc) and
 *  the limits of the rows that follow, and `NAME = file` a piece that later files hold as {NAME}.
 * In a file stand, besides its text, the escapes \n \r \t \0 \\ \xNN and
 *
 *    {^} {^9}      the place that the error must point at: here, or byte 9
 *    {*9:text}     text nine times; # in it is 0, 1, ...
 *    {@9:text}     text over what stands from byte 9 on
 *    {-9}          the last nine bytes go
 *    {<path}       the bytes of a file of the repository */
#ifndef VT_FILES_H
#define VT_FILES_H

#include "proto/limits.h"
#include "tests/support/vt.h"

struct vt_file {
    char *name, *want;
    struct vt_bytes bytes;
    int64_t mark; /**< byte of the error, -1 for none */
    unsigned format;
    struct vor_limits limits;
};

/** Reads tables, one behind the other; *count gets their rows. Once in a process, whose end frees
 *  them. */
struct vt_file *vt_files(const char *const *paths, int path_count, int *count);

/** What a cloud holds: "float32 x y z, x y z; color uint8 1 2 3; triangles 0 1 2; faces 1; ...".
 *  Within 4,095 bytes; static. */
const char *vt_cloud_words(const struct vor_cloud *cloud);

#endif
