/** All of JSON: writing, reading bytes from outside, and the values of this product. cJSON only
 *  reads; json_write.h writes. Files in proto/json/ include the headers that they need, never this
 *  one, or they would go round in a circle. */
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
