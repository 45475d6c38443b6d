#include "proto/draco/draco_precheck.h"

#include "core/cloud/cloud.h"

#include <string.h>

enum { VERSION = 5, KIND = 7, METHOD = 8, HEADER = 11 }; /* bytes of the header, and its size */
enum { POINT_CLOUD, MESH };
enum { SEQUENTIAL, KD_OR_BREAKER };
enum { METADATA = 0x8000 };             /* in the flags */
enum { KIND_FIRST = 0, KIND_LAST = 4 }; /* position, normal, colour, texture, generic */
enum { TYPE_FIRST = 1, TYPE_LAST = 11 };
enum { KD_FLOATS, KD_INTEGERS }; /* before bitstream 2.3 */

#define BITSTREAM(major, minor) ((major) << 8 | (minor))

/* A file that is being walked. The first failure is kept in *err and ends every later step. */
struct walk {
    const uint8_t *bytes;
    size_t size, at;
    size_t metadata; /* bytes of it: they stand for no points */
    unsigned version;
    vor_status status;
    struct vor_error *err;
    const struct vor_limits *limits;
};

static void fail_at(struct walk *walk, size_t at, vor_status status)
{
    walk->status = status;
    if (walk->err != NULL)
        walk->err->byte_offset = (int64_t)at;
}

/* The next `count` bytes as a little-endian number; 0 once the walk has failed. */
static uint32_t fixed(struct walk *walk, unsigned count, const char *what)
{
    uint32_t value = 0;

    if (walk->status != VOR_OK)
        return 0;
    if (walk->size - walk->at < count) {
        fail_at(walk, walk->size,
                vor_fail(walk->err, VOR_E_FORMAT, "the Draco file ends after %zu bytes, within %s",
                         walk->size, what));
        return 0;
    }
    for (unsigned i = 0; i < count; i++)
        value |= (uint32_t)walk->bytes[walk->at + i] << (8 * i);
    walk->at += count;
    return value;
}

static uint32_t varint(struct walk *walk, const char *what)
{
    size_t start = walk->at;
    uint64_t value = 0;

    for (unsigned i = 0; i < 5; i++) {
        uint32_t byte = fixed(walk, 1, what);

        value |= (uint64_t)(byte & 0x7f) << (7 * i);
        if ((byte & 0x80) != 0)
            continue;
        if (walk->status == VOR_OK && value <= UINT32_MAX)
            return (uint32_t)value;
        break;
    }
    if (walk->status == VOR_OK)
        fail_at(walk, start,
                vor_fail(walk->err, VOR_E_FORMAT, "%s of the Draco file exceeds 32 bits", what));
    return 0;
}

/* Counts are fixed 32-bit numbers in bitstreams before `since`, varints from there on. */
static uint32_t count_since(struct walk *walk, unsigned since, const char *what)
{
    return walk->version < since ? fixed(walk, 4, what) : varint(walk, what);
}

static void skip(struct walk *walk, uint32_t count, const char *what)
{
    if (walk->status == VOR_OK && walk->size - walk->at < count)
        fail_at(walk, walk->size,
                vor_fail(walk->err, VOR_E_FORMAT,
                         "the Draco file ends after %zu bytes, in the middle of %s (%u bytes)",
                         walk->size, what, count));
    if (walk->status == VOR_OK)
        walk->at += count;
}

static void refuse(struct walk *walk, size_t at, const char *what, uint64_t got, uint64_t low,
                   uint64_t high)
{
    if (walk->status == VOR_OK && (got < low || got > high))
        fail_at(walk, at,
                vor_fail(walk->err, VOR_E_FORMAT, "%s of the Draco file is %llu, want %llu to %llu",
                         what, (unsigned long long)got, (unsigned long long)low,
                         (unsigned long long)high));
}

/* Reads a number of `count` bytes, and refuses one that is out of range. */
static uint32_t ranged(struct walk *walk, unsigned count, const char *where, const char *what,
                       uint64_t low, uint64_t high)
{
    size_t at = walk->at;
    uint32_t got = fixed(walk, count, where);

    refuse(walk, at, what, got, low, high);
    return got;
}

static void refuse_over(struct walk *walk, size_t at, const char *what, uint64_t got,
                        uint64_t limit)
{
    if (walk->status != VOR_OK || got <= limit)
        return;
    fail_at(walk, at,
            vor_fail(walk->err, VOR_E_LIMIT,
                     "the Draco file of %zu bytes declares %llu %s, want at most %llu", walk->size,
                     (unsigned long long)got, what, (unsigned long long)limit));
    (void)vor_fail_over(walk->err, VOR_E_LIMIT, limit, got);
}

static uint64_t points_of_bytes(size_t size)
{
    return VOR_DRACO_POINTS_PER_BYTE * (uint64_t)size + VOR_DRACO_POINTS_FREE;
}

uint64_t vor_draco_points_max(size_t size, const struct vor_limits *limits)
{
    uint64_t most = points_of_bytes(size);

    return limits->points < most ? limits->points : most;
}

static uint64_t most_points(const struct walk *walk)
{
    return vor_draco_points_max(walk->size - walk->metadata, walk->limits);
}

static void refuse_points(struct walk *walk, size_t at, uint32_t points)
{
    if (walk->status == VOR_OK && points == 0)
        fail_at(walk, at, vor_fail(walk->err, VOR_E_EMPTY, "the Draco file has 0 points"));
    refuse_over(walk, at, "points", points, most_points(walk));
}

/* Returns the flags. */
static uint32_t walk_header(struct walk *walk)
{
    unsigned major, minor, newest;

    if (walk->size < 5 || memcmp(walk->bytes, "DRACO", 5) != 0) {
        fail_at(walk, 0, vor_fail(walk->err, VOR_E_FORMAT, "the file does not begin with DRACO"));
        return 0;
    }
    walk->at = VERSION;
    major = fixed(walk, 1, "the header");
    minor = fixed(walk, 1, "the header");
    (void)fixed(walk, 2, "the header");
    walk->version = BITSTREAM(major, minor);
    if (walk->status != VOR_OK)
        return 0;
    newest = walk->bytes[KIND] == MESH ? 2 : 3;
    if (major < 1 || major > 2 || minor > (major == 1 ? 3 : newest)) {
        fail_at(walk, VERSION,
                vor_fail(walk->err, VOR_E_FORMAT,
                         "the Draco bitstream is %u.%u, want 1.0 to 1.3 or 2.0 to 2.%u", major,
                         minor, newest));
        return 0;
    }
    refuse(walk, KIND, "the kind of geometry", walk->bytes[KIND], POINT_CLOUD, MESH);
    refuse(walk, METHOD, "the encoding method", walk->bytes[METHOD], SEQUENTIAL, KD_OR_BREAKER);
    walk->at = walk->status == VOR_OK ? METHOD + 1 : walk->at;
    return fixed(walk, 2, "the header");
}

static void walk_entries(struct walk *walk)
{
    uint32_t count = varint(walk, "the metadata");

    for (uint32_t i = 0; i < count && walk->status == VOR_OK; i++) {
        skip(walk, fixed(walk, 1, "the metadata"), "metadata");
        skip(walk, varint(walk, "the metadata"), "metadata");
    }
}

/* One block of entries and the blocks nested in it, by counting what is left to do at each level.
 */
static void walk_metadata_block(struct walk *walk)
{
    uint32_t left[VOR_DRACO_METADATA_DEPTH];
    unsigned depth = 0;

    walk_entries(walk);
    left[0] = varint(walk, "the metadata");
    while (walk->status == VOR_OK) {
        while (left[depth] == 0) {
            if (depth == 0)
                return;
            depth--;
        }
        left[depth]--;
        if (depth + 1 == VOR_DRACO_METADATA_DEPTH) {
            fail_at(walk, walk->at,
                    vor_fail(walk->err, VOR_E_FORMAT, "Draco metadata nests deeper than %d levels",
                             VOR_DRACO_METADATA_DEPTH));
            return;
        }
        skip(walk, fixed(walk, 1, "the metadata"), "metadata");
        walk_entries(walk);
        left[++depth] = varint(walk, "the metadata");
    }
}

/* The table of attributes: returns the scalars of a point. */
static uint32_t walk_attributes(struct walk *walk)
{
    size_t start = walk->at;
    uint32_t count = count_since(walk, BITSTREAM(2, 0), "the number of attributes");
    uint32_t scalars = 0;

    refuse(walk, start, "the number of attributes", count, 1, UINT32_MAX);
    refuse_over(walk, start, "attributes", count, VOR_ATTRIBUTES_MAX + 1);
    for (uint32_t i = 0; i < count && walk->status == VOR_OK; i++) {
        size_t at = walk->at;
        uint32_t kind = fixed(walk, 1, "the table of attributes");
        uint32_t type = fixed(walk, 1, "the table of attributes");
        uint32_t components = fixed(walk, 1, "the table of attributes");

        (void)fixed(walk, 1, "the table of attributes");
        if (walk->version < BITSTREAM(1, 3))
            (void)fixed(walk, 2, "the table of attributes");
        else
            (void)varint(walk, "the table of attributes");
        refuse(walk, at, "the kind of an attribute", kind, KIND_FIRST, KIND_LAST);
        refuse(walk, at + 1, "the type of an attribute", type, TYPE_FIRST, TYPE_LAST);
        refuse(walk, at + 2, "the number of components of an attribute", components, 1, 16);
        scalars += components;
    }
    return scalars;
}

/* A number of the kd-tree. */
static uint32_t kd_number(struct walk *walk, unsigned count, const char *what, uint64_t low,
                          uint64_t high)
{
    return ranged(walk, count, "the kd-tree", what, low, high);
}

static void walk_kd_tree(struct walk *walk, uint32_t points)
{
    uint32_t method = KD_INTEGERS;

    if (walk->version < BITSTREAM(2, 3))
        method = kd_number(walk, 1, "the kd-tree's method", KD_FLOATS, KD_INTEGERS);
    if (method == KD_INTEGERS) {
        /* Bitstream 2.3 and later, and the integers of earlier ones: level, bits, points. */
        (void)kd_number(walk, 1, "the kd-tree's level", 0, 6);
        if (walk->version < BITSTREAM(2, 3))
            (void)kd_number(walk, 4, "the kd-tree's number of points", points, points);
        (void)kd_number(walk, 4, "the kd-tree's number of bits", 0, 32);
        (void)kd_number(walk, 4, "the kd-tree's number of points", points, points);
    } else {
        /* Bitstreams before 2.3 had an encoding of its own for float positions. */
        (void)kd_number(walk, 1, "the kd-tree's level", 0, 6);
        (void)kd_number(walk, 4, "the kd-tree's number of points", points, points);
        if (kd_number(walk, 4, "the kd-tree's version", 2, 3) == 3)
            (void)kd_number(walk, 1, "the kd-tree's method", 1, 1);
        (void)kd_number(walk, 4, "the kd-tree's quantisation", 0, 31);
        (void)fixed(walk, 4, "the kd-tree");
        (void)kd_number(walk, 4, "the kd-tree's number of points", points, points);
        (void)kd_number(walk, 4, "the kd-tree's level", 0, 6);
    }
}

/* Bitstream 2.3: the data of the tree's four coders, and behind them what turns integers into the
 * values of attributes: of floats the quantisation, of signed integers their minima. So the end of
 * the stream is known nearly, before the tree is decoded, whose points may be millions in a few
 * bytes. */
static void walk_kd_coders(struct walk *walk, unsigned level, uint32_t scalars)
{
    enum { RANS_FROM = 2, FOLDED_FROM = 4, FOLDED_CODERS = 33, SCALAR_TAIL_MAX = 9 };
    unsigned coders = level >= FOLDED_FROM ? FOLDED_CODERS : level >= RANS_FROM ? 1 : 0;
    unsigned direct = coders > 0 ? 3 : 4;
    uint64_t most;

    for (unsigned i = 0; i < coders; i++) {
        /* A coder of single bits: its first probability, the size of its data, the data. */
        (void)fixed(walk, 1, "the kd-tree");
        skip(walk, varint(walk, "the kd-tree"), "the kd-tree");
    }
    for (unsigned i = 0; i < direct; i++)
        skip(walk, fixed(walk, 4, "the kd-tree"), "the kd-tree");
    most = walk->at + (uint64_t)scalars * SCALAR_TAIL_MAX;
    if (walk->status == VOR_OK && walk->size > most + VOR_DRACO_PADDING_MAX)
        fail_at(walk, (size_t)most,
                vor_fail(walk->err, VOR_E_FORMAT,
                         "the Draco data ends before byte %zu of %zu; only up to %d zero bytes "
                         "may follow the data",
                         (size_t)most, walk->size, VOR_DRACO_PADDING_MAX));
}

static void walk_point_cloud(struct walk *walk)
{
    size_t at = walk->at;
    uint32_t points = fixed(walk, 4, "the number of points"), scalars;

    refuse(walk, at, "the number of points", points, 0, INT32_MAX);
    refuse_points(walk, at, points);
    at = walk->at;
    (void)ranged(walk, 1, "the attribute decoders", "the number of attribute decoders", 1,
                 walk->bytes[METHOD] == KD_OR_BREAKER ? 1 : UINT8_MAX);
    if (walk->status == VOR_OK && walk->bytes[at] != 1)
        return; /* several tables follow one another with data of their own in between */
    at = walk->at;
    scalars = walk_attributes(walk);
    if (walk->bytes[METHOD] != KD_OR_BREAKER)
        return;
    refuse_over(walk, at, "scalars per point in a kd-tree", scalars, VOR_DRACO_KD_SCALARS);
    refuse_over(walk, at, "scalars in a kd-tree", (uint64_t)points * scalars,
                3 * points_of_bytes(walk->size - walk->metadata));
    at = walk->at;
    walk_kd_tree(walk, points);
    if (walk->status == VOR_OK && walk->version >= BITSTREAM(2, 3))
        walk_kd_coders(walk, walk->bytes[at], scalars);
}

static void walk_breaker_mesh(struct walk *walk)
{
    size_t at = walk->at;
    uint32_t vertices, faces, symbols, splits;

    (void)ranged(walk, 1, "the mesh", "the traversal", 0, 2);
    if (walk->version < BITSTREAM(2, 2)) {
        at = walk->at;
        refuse_over(walk, at, "new vertices",
                    count_since(walk, BITSTREAM(2, 0), "the number of new vertices"),
                    most_points(walk));
    }
    at = walk->at;
    vertices = count_since(walk, BITSTREAM(2, 0), "the number of vertices");
    refuse_points(walk, at, vertices);
    at = walk->at;
    faces = count_since(walk, BITSTREAM(2, 0), "the number of faces");
    refuse_over(walk, at, "faces", faces, 2 * most_points(walk));
    refuse(walk, at, "the number of faces", faces, 1, UINT32_MAX);
    (void)fixed(walk, 1, "the number of attribute tables");
    at = walk->at;
    symbols = count_since(walk, BITSTREAM(2, 0), "the number of symbols");
    refuse(walk, at, "the number of symbols", symbols, 0, faces);
    at = walk->at;
    splits = count_since(walk, BITSTREAM(2, 0), "the number of split symbols");
    refuse(walk, at, "the number of split symbols", splits, 0, symbols);
}

vor_status vor_draco_precheck(const uint8_t *bytes, size_t size, const struct vor_limits *limits,
                              struct vor_error *err)
{
    struct walk walk = {
        .bytes = bytes, .size = size, .status = VOR_OK, .err = err, .limits = limits};
    uint32_t flags = walk_header(&walk);

    if (walk.status == VOR_OK && limits->strict_draco) {
        /* Refuses what narrower code of the library reads. */
        const char *what = NULL;
        size_t at = VERSION;

        if (walk.version != BITSTREAM(2, 3))
            what = "has another version of the bitstream";
        if (walk.bytes[KIND] != POINT_CLOUD) {
            what = "is a mesh";
            at = KIND;
        } else if (what == NULL && (flags & METADATA) != 0) {
            what = "has metadata";
            at = METHOD + 1;
        }
        if (what != NULL)
            fail_at(&walk, at,
                    vor_fail(walk.err, VOR_E_FORMAT,
                             "the Draco file %s; with --draco strict the daemon reads only point "
                             "clouds of bitstream 2.3 without metadata",
                             what));
    }
    if (walk.status != VOR_OK)
        return walk.status;
    if ((flags & METADATA) != 0 && walk.version >= BITSTREAM(1, 3)) {
        uint32_t attributes = varint(&walk, "the metadata");

        for (uint32_t i = 0; i < attributes && walk.status == VOR_OK; i++) {
            (void)varint(&walk, "the metadata");
            walk_metadata_block(&walk);
        }
        walk_metadata_block(&walk);
    }
    walk.metadata = walk.at - HEADER;
    if (bytes[KIND] == POINT_CLOUD)
        walk_point_cloud(&walk);
    else if (bytes[METHOD] == SEQUENTIAL) {
        size_t at = walk.at;
        uint32_t faces = count_since(&walk, BITSTREAM(2, 2), "the number of faces");

        refuse_over(&walk, at, "faces", faces, 2 * most_points(&walk));
        at = walk.at;
        refuse_points(&walk, at, count_since(&walk, BITSTREAM(2, 2), "the number of points"));
    } else
        walk_breaker_mesh(&walk);
    return walk.status;
}
