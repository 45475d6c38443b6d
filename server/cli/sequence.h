/** Frames of a sequence: clouds of which each is resampled from the result for the one before. */
#ifndef VOR_CLI_SEQUENCE_H
#define VOR_CLI_SEQUENCE_H

#include "core/cloud/cloud.h"
#include "server/cli/options.h"

/** Names of attributes. */
struct vor_attribute_names {
    unsigned count;
    char name[VOR_ATTRIBUTES_MAX][sizeof((struct vor_attribute *)NULL)->name];
};

/** Finds the attributes that all operands have, and names the others on stderr. The attribute track
 *  is none of either: results have one of their own. Operands that cannot be read do not count:
 *  their run says why.
 *
 *  @retval VOR_E_NOMEM
 *
 *  Reads each file, one after the other. */
VOR_NODISCARD vor_status vor_sequence_common(struct vor_attribute_names *out,
                                             const struct vor_cli *cli, struct vor_error *err);

/** Frees the attributes of a cloud that are not among the names. */
void vor_sequence_keep(struct vor_cloud *cloud, const struct vor_attribute_names *names);

#endif
