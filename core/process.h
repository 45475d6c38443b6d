/** What a process is: artefacts by name in, artefacts by name out. The table of processes and their
 *  functions stands in core/engine.c; what they are called and take, in core/spec/tables.h. */
#ifndef VOR_PROCESS_H
#define VOR_PROCESS_H

#include "core/base/members.h"
#include "core/base/run.h"
#include "core/cloud/cloud.h"
#include "core/cloud/mesh.h"
#include "core/spec.h"

/** Something that goes into a run or comes out of it. */
struct vor_artefact {
    const char *name; /**< of the process's row: "cloud", "reference", "report" */
    enum vor_artefact_kind kind;
    struct vor_cloud cloud;       /**< CLOUD */
    struct vor_mesh mesh;         /**< CLOUD: its faces; count is 0 where it has none */
    struct vor_document document; /**< DOCUMENT; its values belong to the set */
    void *values;                 /**< the same values, to be written */
};

#define VOR_ARTEFACTS_MAX (VOR_INPUTS_MAX > VOR_OUTPUTS_MAX ? VOR_INPUTS_MAX : VOR_OUTPUTS_MAX)

/** A set of artefacts with names of their own. It owns what is in it. */
struct vor_artefacts {
    struct vor_memory *memory; /**< of the documents; clouds have their own */
    unsigned count;
    struct vor_artefact item[VOR_ARTEFACTS_MAX];
};

/** Makes an empty set. Free it with vor_artefacts_free, also after a failed run. */
void vor_artefacts_init(struct vor_artefacts *set, struct vor_memory *memory);

/** Frees what is in the set and leaves it empty. set may be all zero. */
void vor_artefacts_free(struct vor_artefacts *set);

/** Moves a cloud into the set: *cloud is empty afterwards. name outlives the set; the set has no
 *  artefact of that name yet, and fewer than VOR_ARTEFACTS_MAX. */
void vor_artefacts_put_cloud(struct vor_artefacts *set, const char *name, struct vor_cloud *cloud);

/** The same with faces over the points of the cloud: *mesh is empty afterwards, too. */
void vor_artefacts_put_mesh(struct vor_artefacts *set, const char *name, struct vor_cloud *cloud,
                            struct vor_mesh *mesh);

/** Adds a document whose values are all zero, a struct of members->size bytes that the set owns,
 *  and returns the values for the process to set. name as above. NULL, with err set to VOR_E_NOMEM,
 *  when they do not fit. */
void *vor_artefacts_put_document(struct vor_artefacts *set, const char *name,
                                 const struct vor_members *members, struct vor_error *err);

/** The artefact of that name; NULL when there is none. */
const struct vor_artefact *vor_artefacts_find(const struct vor_artefacts *set, const char *name);

/** The cloud of that name; NULL when there is none. */
const struct vor_cloud *vor_artefacts_cloud(const struct vor_artefacts *set, const char *name);

/** The triangles over the cloud of that name, which may be none; NULL when there is no such cloud.
 */
const struct vor_mesh *vor_artefacts_mesh(const struct vor_artefacts *set, const char *name);

/** The values of the document of that name, for the caller of a run to complete; NULL unless
 *  `members` describes them. */
void *vor_artefacts_values(struct vor_artefacts *set, const char *name,
                           const struct vor_members *members);

/** One process. */
struct vor_process {
    const char *id; /**< of the row that describes it */

    /** Runs the process.
     *
     *  @param[out] out   initialised, empty; receives every output of the row
     *  @param[in]  in    every required input of the row is there, clouds are checked
     *                    (vor_cloud_check)
     *  @param[in]  spec  checked (vor_spec_check); spec->process is the row
     *  @param[in]  run   began just now: began and no_stop are set
     *
     *  Fails as the process says; whatever is in *out then is the caller's to free. */
    vor_status (*run)(struct vor_artefacts *out, const struct vor_artefacts *in,
                      const struct vor_spec *spec, const struct vor_run *run,
                      struct vor_error *err);
};

/** Begins a run of the process, with the time that the request allows, and makes it. Parameters and
 *  failures as those of its function. */
VOR_NODISCARD vor_status vor_process_run(const struct vor_process *process,
                                         struct vor_artefacts *out, const struct vor_artefacts *in,
                                         const struct vor_spec *spec, const struct vor_run *run,
                                         struct vor_error *err);

#endif
