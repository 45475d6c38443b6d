#include "core/input/input.h"

#include "core/input/islands.h"
#include "core/input/lattice.h"
#include "core/input/neighbors.h"
#include "core/input/outliers.h"
#include "core/input/sheets.h"

static vor_status drop_outliers(struct vor_domain *domain, const struct vor_spec *spec,
                                const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    if (spec->value[VOR_PARAM_OUTLIERS] != VOR_OUTLIERS_DROP)
        return VOR_OK;
    status = vor_outliers_drop(domain, &domain->known.outliers, run, err);
    return status == VOR_OK ? vor_islands_drop(domain, run, err) : status;
}

/* Looks for a lattice, and if it matters moves the points within their cells. */
static vor_status leave_lattice(struct vor_domain *domain, const struct vor_run *run,
                                struct vor_error *err)
{
    struct vor_conditioning *known = &domain->known;
    vor_status status = vor_lattice_find(&known->lattice, domain, run, err);

    if (status != VOR_OK || !known->lattice.matters)
        return status;
    return vor_lattice_smooth(domain, &known->off_lattice, &known->lattice, run, err);
}

static vor_status choose_neighbors(struct vor_domain *domain, const struct vor_spec *spec,
                                   const struct vor_run *run, struct vor_error *err)
{
    double given = spec->value[VOR_PARAM_NEIGHBORS];

    if (given == VOR_UNSET)
        return vor_neighbors_choose(&domain->known.neighbors, domain, run, err);
    vor_neighbors_fix(&domain->known.neighbors, (unsigned)given);
    return VOR_OK;
}

vor_status vor_input_prepare(struct vor_domain *out, const struct vor_cloud *in,
                             const struct vor_spec *spec, const struct vor_run *run,
                             struct vor_error *err)
{
    struct vor_domain domain;
    vor_status status = vor_domain_init(&domain, in, run, err);

    if (status != VOR_OK)
        return status;
    status = drop_outliers(&domain, spec, run, err);
    if (status == VOR_OK)
        status = leave_lattice(&domain, run, err);
    if (status == VOR_OK)
        status = vor_sheets_find(&domain.known.sheets, &domain, run, err);
    if (status == VOR_OK)
        status = choose_neighbors(&domain, spec, run, err);
    if (status == VOR_OK)
        status = vor_islands_take(&domain, run, err);
    if (status != VOR_OK) {
        vor_domain_free(&domain);
        return status;
    }
    *out = domain;
    return VOR_OK;
}
