/** A point cloud: positions relative to a double-precision origin, and typed attributes. */
#ifndef VOR_CLOUD_H
#define VOR_CLOUD_H

#include "core/base/memory.h"
#include "core/base/status.h"
#include "core/cloud/notes.h"

#include <stddef.h>
#include <stdint.h>

/** Most points of a cloud: indices are uint32_t and a count must fit an int32_t. */
#define VOR_POINTS_MAX ((size_t)INT32_MAX - 1)

/** Name of the attribute that tells which point of a sequence of clouds a point is: whole numbers,
 *  each of one point. */
#define VOR_TRACK "track"

/** Most attributes of a cloud. */
#define VOR_ATTRIBUTES_MAX 64

/** Scalar types: name, C type, PLY 1.0 spelling, sized spelling. */
#define VOR_TYPE_TABLE(X)                                                                          \
    X(INT8, int8_t, "char", "int8")                                                                \
    X(UINT8, uint8_t, "uchar", "uint8")                                                            \
    X(INT16, int16_t, "short", "int16")                                                            \
    X(UINT16, uint16_t, "ushort", "uint16")                                                        \
    X(INT32, int32_t, "int", "int32")                                                              \
    X(UINT32, uint32_t, "uint", "uint32")                                                          \
    X(FLOAT32, float, "float", "float32")                                                          \
    X(FLOAT64, double, "double", "float64")                                                        \
    X(INT64, int64_t, "", "int64")                                                                 \
    X(UINT64, uint64_t, "", "uint64")

enum vor_type {
#define VOR_TYPE_ENUM(name, ctype, ply, sized) VOR_##name,
    VOR_TYPE_TABLE(VOR_TYPE_ENUM)
#undef VOR_TYPE_ENUM
        VOR_TYPE_COUNT
};

/** Bytes of one scalar. */
size_t vor_type_size(enum vor_type type);

/** "char" ... "double" and "int8" ... "uint64". vor_type_name yields the PLY spelling, or the sized
 *  one where PLY has none. */
const char *vor_type_name(enum vor_type type);
const char *vor_type_name_sized(enum vor_type type);

/** Reads either spelling; false when it is neither. */
int vor_type_parse(enum vor_type *out, const char *name, size_t length);

/** What an attribute means; everything not listed is GENERIC. */
enum vor_semantic { VOR_GENERIC, VOR_NORMAL, VOR_COLOR, VOR_TEX_COORD };

/** One value of `components` scalars for every point, interleaved. A PLY reader groups nx ny nz
 *  into one NORMAL of three and red green blue [alpha] into one COLOR of three or four; a TEX_COORD
 *  of two or three is what Draco has for places in a texture; every other vertex property is a
 *  GENERIC of one component under its own name. */
struct vor_attribute {
    char name[64]; /**< "normal", "color", or the property's own name, in any character set and
                        without control characters; NUL-terminated */
    enum vor_semantic semantic;
    enum vor_type type;
    unsigned components; /**< 1 .. 16 */
    void *data;          /**< n * components scalars of type, owned by the cloud */
};

/** Scalar number `at` of an attribute (value i has components i * components ...), whatever its
 *  type. 64-bit integers beyond 2^53 are rounded. */
double vor_attribute_scalar(const struct vor_attribute *attribute, size_t at);

/** Points whose values are mixed into one. */
struct vor_mix {
    const uint32_t *point; /**< count >= 1 */
    const double *weight;  /**< of each; their sum is 1 */
    unsigned count;
};

/** Sets value i of `to` to the mean of values of `from`, an attribute like it. Colours are rounded,
 *  normals get length 1. Values of which there is no mean that makes sense, such as whole numbers
 *  that are no colours, are those of the point with the largest weight. */
void vor_attribute_mix(struct vor_attribute *to, size_t i, const struct vor_attribute *from,
                       const struct vor_mix *mix);

/** True where a float holds the bytes of a colour, as the Point Cloud Library has it: one float32
 *  called rgb or rgba, in any case. Such numbers are copied; they cannot be rounded or averaged. */
int vor_attribute_is_packed(const struct vor_attribute *attribute);

/** n points: point i lies at origin + xyz[3 i .. 3 i + 2], in the input's own unit.
 *
 *  Where the source coordinates are float32, origin is 0 and xyz holds them bit for bit. Where they
 *  are double, vor_cloud_set_double picks the origin. */
struct vor_cloud {
    struct vor_memory *memory; /**< borrowed; everything below is allocated from it */
    size_t n;
    double origin[3];
    float *xyz;
    double *exact; /**< n x 3, the coordinates of the source where they are doubles that the rest
                      does not hold; only where a reader was asked to keep them, else NULL */
    enum vor_type position_type; /**< FLOAT32 or FLOAT64: of the source, and of PLY output */
    size_t attribute_count;
    struct vor_attribute attributes[VOR_ATTRIBUTES_MAX];
    size_t triangle_count;
    uint32_t *triangles; /**< three points each, below n; only where a reader was asked for them
                              (core/cloud/faces.h), and never of a result */
    int polygons;        /**< of the triangles, as of struct vor_mesh */
    struct vor_notes notes;
};

/** Makes an empty cloud that allocates from memory. */
void vor_cloud_init(struct vor_cloud *cloud, struct vor_memory *memory);

/** Frees everything and leaves the cloud as vor_cloud_init does. */
void vor_cloud_free(struct vor_cloud *cloud);

/** Gives the cloud n points with unset positions and no attributes; the cloud must be empty.
 *
 *  @retval VOR_E_EMPTY n is 0
 *  @retval VOR_E_LIMIT n exceeds VOR_POINTS_MAX
 *  @retval VOR_E_NOMEM the positions do not fit under the cap */
VOR_NODISCARD vor_status vor_cloud_resize(struct vor_cloud *cloud, size_t n, struct vor_error *err);

/** Makes *out, an initialised, empty cloud, the same as another: points, attributes, remarks. Of
 * its other notes it has none, nor triangles.
 *
 *  @retval VOR_E_NOMEM it does not fit; *out is empty */
VOR_NODISCARD vor_status vor_cloud_copy(struct vor_cloud *out, const struct vor_cloud *in,
                                        struct vor_error *err);

/** Adds an attribute with unset values; *out (may be NULL) points at it until the next change.
 *  A name that is taken gets "_2", "_3" ... appended; one that is longer than fits is cut, and the
 *  cloud's notes say so.
 *
 *  @retval VOR_E_LIMIT more than VOR_ATTRIBUTES_MAX attributes
 *  @retval VOR_E_NOMEM the values do not fit under the cap */
VOR_NODISCARD vor_status vor_cloud_add_attribute(struct vor_cloud *cloud, const char *name,
                                                 enum vor_semantic semantic, enum vor_type type,
                                                 unsigned components, struct vor_attribute **out,
                                                 struct vor_error *err);

/** Adds an attribute like one of another cloud: point i gets the value of its point source[i].
 *  Fails as vor_cloud_add_attribute. */
VOR_NODISCARD vor_status vor_cloud_copy_attribute(struct vor_cloud *cloud,
                                                  const struct vor_attribute *from,
                                                  const uint32_t *source, struct vor_error *err);

/** First attribute with that semantic, or by name; NULL when there is none. */
const struct vor_attribute *vor_cloud_find(const struct vor_cloud *cloud,
                                           enum vor_semantic semantic);
const struct vor_attribute *vor_cloud_find_name(const struct vor_cloud *cloud, const char *name);

/** Sets positions and origin from n x 3 doubles. The relative positions are multiples of a power of
 *  two near extent / 2^25 counted from the lower corner, so that every one is exact in float32 and
 *  a cloud that was only shifted gets the same relative positions, bit for bit. position_type
 *  becomes FLOAT64.
 *
 *  Cost: one pass; the positions move by at most extent / 2^25.
 *
 *  @retval VOR_E_NONFINITE a coordinate is NaN or infinite (message names the point and the value),
 *                          or the extent exceeds the range of float32 */
VOR_NODISCARD vor_status vor_cloud_set_double(struct vor_cloud *cloud, const double *xyz,
                                              struct vor_error *err);

/** Where positions that vor_cloud_set_double got are not those of the cloud, bit for bit, the cloud
 *  keeps them as they were, for a result that does not move its points.
 *
 *  @param[in,out] xyz  allocated from the cloud's memory; NULL once the cloud has them
 *
 *  Cost: one pass. */
void vor_cloud_keep_double(struct vor_cloud *cloud, double **xyz);

/** Reorders the points of a cloud without triangles, with their attributes: point order[k] becomes
 *  the k-th.
 *
 *  @param[in] order  a permutation of 0 .. n - 1
 *
 *  @retval VOR_E_NOMEM a copy of the widest column does not fit; the cloud is as it was */
VOR_NODISCARD vor_status vor_cloud_reorder(struct vor_cloud *cloud, const uint32_t *order,
                                           struct vor_error *err);

/** Point i in absolute double coordinates, as the engine has it: see `exact`. */
void vor_cloud_position(const struct vor_cloud *cloud, size_t i, double out[3]);

/** Checks what every codec must ensure, once where a cloud enters: at least one point, every
 *  coordinate finite.
 *
 *  @retval VOR_E_EMPTY, VOR_E_NONFINITE
 *
 *  O(n). */
VOR_NODISCARD vor_status vor_cloud_check(const struct vor_cloud *cloud, struct vor_error *err);

#endif
