/** The frame of a result whose positions are float32: which point of the input's coordinates its
 *  file counts from (parameter origin), and when that is too coarse. */
#ifndef VOR_PROTO_ORIGIN_H
#define VOR_PROTO_ORIGIN_H

#include "core/cloud/extent.h"
#include "core/spec.h"

/** origin=auto is absolute where the steps of float32 at the farthest coordinate of the input are
 *  at most its spacing over this: they are then as fine as the cells of quantization=auto. */
#define VOR_ORIGIN_STEPS_AUTO 200

/** An origin that is asked for is refused where they exceed the spacing of the result over this:
 *  rounding to them would cost more than the result's own unevenness of 2 to 5 %. */
#define VOR_ORIGIN_STEPS_LEAST 20

/** The spacing of a result is known only at its end. Before the work, an origin is refused if it
 *  would be at a spacing of so many times the estimate, twice the largest ratio measured there
 *  (vor_extent_spacing): inputs of a few dozen points are estimated at two thirds. */
#define VOR_ORIGIN_MARGIN 2

/** Refuses before the work what vor_origin_resolve would surely refuse after it, as far as the
 *  input and the number of points or the spacing asked for tell it.
 *
 *  @retval VOR_E_ORIGIN as vor_origin_resolve */
VOR_NODISCARD vor_status vor_origin_check(const struct vor_spec *spec,
                                          const struct vor_extent *input, struct vor_error *err);

/** Sets *out to the origin that a request comes to. auto and relative depend on the input alone, so
 *  that results of different numbers of points lie in one frame.
 *
 *  @param[in] input    extent of the main input. Its spacing is the estimate of vor_extent_spacing:
 *                      the engine's own is known only after an index is built
 *  @param[in] spacing  mean distance between neighbours of the result; 0 when not known
 *
 *  @retval VOR_E_ORIGIN the origin is absolute or X,Y,Z, and float32 is too coarse for it (the
 *                       message names its step and the spacing); *out is unchanged */
VOR_NODISCARD vor_status vor_origin_resolve(double out[3], const struct vor_spec *spec,
                                            const struct vor_extent *input, double spacing,
                                            struct vor_error *err);

/** Bytes that vor_origin_text writes at most, with the NUL. */
#define VOR_ORIGIN_TEXT_SIZE 80

/** Writes an origin as the parameter has it, "X,Y,Z", with as many digits as read back the same.
 *  Returns out. */
const char *vor_origin_text(const double origin[3], char out[VOR_ORIGIN_TEXT_SIZE]);

#endif
