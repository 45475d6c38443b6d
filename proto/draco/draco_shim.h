/** The C face of the Draco library. Behind it is the only C++ of the project; nothing throws across
 *  it, and nothing behind it allocates past its meter.
 *
 *  Only proto/draco_*.c include this file: it checks what memory safety needs, not what the formats
 *  promise. */
#ifndef VOR_PROTO_DRACO_SHIM_H
#define VOR_PROTO_DRACO_SHIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#define VOR_NOEXCEPT noexcept
#else
#define VOR_NOEXCEPT
#endif

enum vor_draco_result {
    VOR_DRACO_DONE,
    VOR_DRACO_NO_MEMORY, /**< the meter or malloc refused */
    VOR_DRACO_REFUSED,   /**< the library did, or what it decoded does not fit together */
    VOR_DRACO_NOT_TAKEN  /**< the sink refused the bytes */
};

/** What an attribute stands for; the numbers are the library's and the bitstream's. */
enum vor_draco_kind {
    VOR_DRACO_POSITION,
    VOR_DRACO_NORMAL,
    VOR_DRACO_COLOR,
    VOR_DRACO_TEX_COORD,
    VOR_DRACO_GENERIC
};

/** Scalars in the order of enum vor_type. */
enum vor_draco_scalar {
    VOR_DRACO_INT8,
    VOR_DRACO_UINT8,
    VOR_DRACO_INT16,
    VOR_DRACO_UINT16,
    VOR_DRACO_INT32,
    VOR_DRACO_UINT32,
    VOR_DRACO_FLOAT32,
    VOR_DRACO_FLOAT64,
    VOR_DRACO_INT64,
    VOR_DRACO_UINT64,
    VOR_DRACO_SCALAR_COUNT
};

/** Who pays for what the library allocates. charge answers 0 to refuse. The calls come from the
 *  thread that called; ctx must stay valid for as long as the handle made with it. */
struct vor_draco_meter {
    void *ctx;
    int (*charge)(void *ctx, size_t bytes);
    void (*release)(void *ctx, size_t bytes);
};

/** A decoded file. */
struct vor_draco_decoded;

/** One attribute of a decoded file; texts are "" where the file has none. */
struct vor_draco_info {
    enum vor_draco_kind kind;
    enum vor_draco_scalar scalar; /**< booleans are UINT8 */
    unsigned components;          /**< 0 .. 255, as the file has it */
    char name[256];               /**< metadata entry "name", cut to fit */
    char type[16];                /**< metadata entry "voronoid.type" */
};

/** Decodes a file of *size bytes, of which *size then are those that it has read, from the first
 * one on. On failure *out is NULL and message says why ("" when nobody knows). Thread-safe. */
enum vor_draco_result vor_draco_decode(struct vor_draco_decoded **out,
                                       const struct vor_draco_meter *meter, const uint8_t *bytes,
                                       size_t *size, char message[96]) VOR_NOEXCEPT;

/** decoded may be NULL. Gives back to the meter whatever is still booked. */
void vor_draco_free(struct vor_draco_decoded *decoded) VOR_NOEXCEPT;

size_t vor_draco_points(const struct vor_draco_decoded *decoded) VOR_NOEXCEPT;

/** Faces of a mesh; 0 of a point cloud. */
size_t vor_draco_faces(const struct vor_draco_decoded *decoded) VOR_NOEXCEPT;

/** The points of each face, three for each. REFUSED when one does not exist. */
enum vor_draco_result vor_draco_corners(const struct vor_draco_decoded *decoded,
                                        uint32_t *out) VOR_NOEXCEPT;
unsigned vor_draco_attributes(const struct vor_draco_decoded *decoded) VOR_NOEXCEPT;

/** index is below vor_draco_attributes. REFUSED when the type is none of ours. */
enum vor_draco_result vor_draco_describe(const struct vor_draco_decoded *decoded, unsigned index,
                                         struct vor_draco_info *out) VOR_NOEXCEPT;

/** Copies the values of all points, interleaved, in the attribute's own type. REFUSED when a value
 *  does not exist. */
enum vor_draco_result vor_draco_values(const struct vor_draco_decoded *decoded, unsigned index,
                                       void *out) VOR_NOEXCEPT;

/** Entries of metadata that are none of ours: neither called voronoid..., nor the name of an
 *  attribute. */
size_t vor_draco_metadata(const struct vor_draco_decoded *decoded) VOR_NOEXCEPT;

/** The metadata entries "voronoid.origin.x", ".y" and ".z" (a double each) and
 *  "voronoid.position_type" (type is "" without it). 0 when there is no origin. */
int vor_draco_origin(const struct vor_draco_decoded *decoded, double origin[3],
                     char type[16]) VOR_NOEXCEPT;

/** One attribute to be written; all pointers are borrowed for the call. */
struct vor_draco_column {
    enum vor_draco_kind kind;
    enum vor_draco_scalar scalar;
    unsigned components; /**< 1 .. 16 */
    const void *data;    /**< n * components scalars */
    const char *name;    /**< metadata "name"; NULL for none */
    const char *type;    /**< metadata "voronoid.type"; NULL for none */
    int bits;            /**< of quantisation, for FLOAT32; 0 for none */
    float low[16];       /**< of the box that is quantised, for each component */
    float range;         /**< its edge, > 0 */
};

struct vor_draco_source {
    size_t n; /**< points, 1 .. INT32_MAX */
    unsigned count;
    const struct vor_draco_column *columns;
    const double *origin;      /**< three, or NULL for no metadata of ours */
    const char *position_type; /**< with origin */
    const uint32_t *triangles; /**< three points each; NULL for a point cloud */
    size_t triangle_count;
    int reorders; /**< kd-tree of a point cloud, edgebreaker of a mesh; else sequential */
    int speed;    /**< 0 smallest .. 10 fastest */
};

/** Encodes a point cloud or a mesh and hands the file to write (0: taken) in one piece. The meter
 * is not asked for what write allocates. REFUSED, before anything is handed over, also where the
 *  encoding would split or lose points, or lose faces, as edgebreaker may. Thread-safe. */
enum vor_draco_result vor_draco_encode(const struct vor_draco_source *source,
                                       const struct vor_draco_meter *meter, void *ctx,
                                       int (*write)(void *ctx, const void *bytes, size_t size),
                                       char message[96]) VOR_NOEXCEPT;

#ifdef __cplusplus
}
#endif

#endif
