#include "server/work/kinds.h"

#include "server/work/codec_child.h"
#include "server/work/station.h"

const struct vor_child_kind vor_child_kinds[VOR_CHILD_KINDS] = {
    [VOR_CHILD_CODEC] = {"vor-codec", vor_codec_child},
    [VOR_CHILD_WORKER] = {"vor-worker", vor_station_run},
};
