/** All of JSON: writing text, reading strangers' text, and the values that this product speaks.
 * cJSON only reads; what is written here is written by ourselves. Files of proto/json/ include the
 * part that they need, never this one. */
#ifndef VOR_PROTO_JSON_H
#define VOR_PROTO_JSON_H

#include "proto/json/json_members.h"
#include "proto/json/json_process.h"
#include "proto/json/json_read.h"
#include "proto/json/json_scan.h"
#include "proto/json/json_spec.h"
#include "proto/json/json_values.h"
#include "proto/json/json_write.h"

#endif
