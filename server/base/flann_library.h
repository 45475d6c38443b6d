/** FLANN, loaded when the first index is built. Its binding alone, of eleven thousand symbols,
 * takes a third of the time in which the command line starts. core calls its functions by their
 * names, which is what libvoronoid needs; here these are defined, and call those of the library. */
#ifndef VOR_SERVER_BASE_FLANN_LIBRARY_H
#define VOR_SERVER_BASE_FLANN_LIBRARY_H

#include "core/base/status.h"

/** Loads the library, once. The first index that is built calls it, too; should it fail there, the
 *  engine fails with VOR_E_INTERNAL, and who calls this then learns why. Thread-safe.
 *
 *  @retval VOR_E_IO it is not installed, or lacks a function */
VOR_NODISCARD vor_status vor_flann_load(struct vor_error *err);

#endif
