#include "core/input/input.h"

#include "core/input/adjacency.h"
#include "core/input/carried.h"
#include "core/input/followed.h"
#include "core/input/holes.h"
#include "core/input/islands.h"
#include "core/input/lattice.h"
#include "core/input/lists.h"
#include "core/input/mls.h"
#include "core/input/neighbors.h"
#include "core/input/outliers.h"
#include "core/input/settle.h"
#include "core/input/sheets.h"
#include "core/input/thin.h"

/* Whether the input passes a filter: one that the request names or, if it names none, one that the
 * process denoise cannot do without. Spread evenly, points that still have their noise fill it, and
 * lie as far off the surface as its farthest; the methods of lop take the noise away themselves. */
static int has_filter(const struct vor_spec *spec, unsigned filter)
{
    double named = spec->value[VOR_PARAM_FILTERS];

    if (named != 0 || filter == VOR_FILTER_THIN || spec->process != vor_process_find("denoise"))
        return vor_list_has(named, filter);
    return spec->value[VOR_PARAM_METHOD] != VOR_METHOD_WLOP &&
           spec->value[VOR_PARAM_METHOD] != VOR_METHOD_EAR;
}

/* Whether points are to be spread. */
static int spreads(const struct vor_spec *spec)
{
    return vor_process_takes(spec->process, VOR_PARAM_POINTS) && !vor_spec_only_filters(spec);
}

/* What is to be done with outliers: where filters alone make the result, only what they say. */
static int outliers_of(const struct vor_spec *spec)
{
    int asked = vor_spec_outliers(spec);

    if (vor_list_has(spec->value[VOR_PARAM_FILTERS], VOR_FILTER_OUTLIERS))
        return asked == VOR_OUTLIERS_KEEP ? VOR_OUTLIERS_DROP : asked;
    return vor_spec_only_filters(spec) ? VOR_OUTLIERS_KEEP : asked;
}

/* Makes the domain of a cloud. Where remote points take so much of float32 that the others, or the
 * islands among them, cannot be told apart, it is the domain of the others; but not where outliers
 * are kept and filters alone make the result. */
static vor_status make(struct vor_domain *out, struct vor_outliers *outliers,
                       const struct vor_cloud *in, const struct vor_spec *spec,
                       const struct vor_run *run, struct vor_error *err)
{
    int stay = outliers_of(spec) == VOR_OUTLIERS_KEEP && !spreads(spec);
    struct vor_domain others = {.n = 0};
    vor_status status = vor_domain_init(out, in, run, err), left_out = VOR_E_DEGENERATE;

    if (!stay && (status == VOR_OK ? !vor_islands_can_be_told(out) : status == VOR_E_DEGENERATE))
        left_out = vor_outliers_remote(outliers, &others, in, run, err);
    if (left_out != VOR_E_DEGENERATE) {
        if (status == VOR_OK)
            vor_domain_free(out);
        if (left_out == VOR_OK)
            *out = others;
        status = left_out;
    }
    if (status == VOR_OK && spec->value[VOR_PARAM_INPUT_NORMALS] != VOR_INPUT_NORMALS_ESTIMATE)
        out->known.carried = vor_carried(in);
    return status;
}

/* Whether outliers that are kept are none of the method's: what it inserts would fill the gaps
 * around them. */
static int are_aside(const struct vor_spec *spec)
{
    return spreads(spec) && spec->value[VOR_PARAM_METHOD] == VOR_METHOD_EAR &&
           outliers_of(spec) == VOR_OUTLIERS_KEEP;
}

static vor_status take_outliers(struct vor_outliers *out, struct vor_domain *domain,
                                const struct vor_spec *spec, const struct vor_run *run,
                                struct vor_error *err)
{
    int closer = has_filter(spec, VOR_FILTER_OUTLIERS) || outliers_of(spec) == VOR_OUTLIERS_PULL;
    vor_status status;

    if (outliers_of(spec) == VOR_OUTLIERS_KEEP && !are_aside(spec))
        return VOR_OK;
    status = vor_outliers_take(out, domain, closer, run, err);
    if (status == VOR_OK && !are_aside(spec))
        domain->known.outliers = out->n;
    if (status == VOR_OK && outliers_of(spec) == VOR_OUTLIERS_DROP)
        status = vor_islands_drop(domain, run, err);
    return status;
}

/* Looks for a lattice, and if it matters moves the points within their cells, unless points are to
 * stay where they are. */
static vor_status leave_lattice(struct vor_domain *domain, const struct vor_spec *spec,
                                const struct vor_run *run, struct vor_error *err)
{
    int stay = vor_spec_only_filters(spec) &&
               !vor_list_has(spec->value[VOR_PARAM_FILTERS], VOR_FILTER_MLS);
    struct vor_conditioning *known = &domain->known;
    vor_status status = vor_lattice_find(&known->lattice, domain, run, err);

    if (status == VOR_OK && !known->lattice.matters && !vor_lattice_is_full(&known->lattice))
        status = vor_lattice_survey(known->pitch, domain, run, err);
    if (status != VOR_OK || !known->lattice.matters || stay)
        return status;
    return vor_lattice_smooth(domain, &known->off_lattice, &known->lattice, run, err);
}

/* Finds out whether the input has sheets, the way that the request says. */
static vor_status find_sheets(struct vor_domain *domain, const struct vor_spec *spec,
                              const struct vor_run *run, struct vor_error *err)
{
    double intrinsic = spec->value[VOR_PARAM_INTRINSIC];

    if (intrinsic == VOR_INTRINSIC_SATELLITES)
        domain->known.lists = VOR_LISTS_SATELLITES;
    if (intrinsic != VOR_INTRINSIC_LOCAL)
        return VOR_OK;
    domain->known.seek_sheets = 1;
    return vor_sheets_find(&domain->known, domain, run, err);
}

/* Where noise is so wide that few points show no surface, moves them onto it, and looks again for
 * sheets and outliers, which it hides; unless they are to stay where they are, somebody says how
 * many neighbours a fit takes, or the method copes by itself. Sheets that show before are no noise.
 */
static vor_status leave_noise(struct vor_domain *domain, struct vor_outliers *outliers,
                              const struct vor_spec *spec, const struct vor_run *run,
                              struct vor_error *err)
{
    int filtered = has_filter(spec, VOR_FILTER_MLS);
    int spread = spreads(spec) && spec->value[VOR_PARAM_METHOD] == VOR_METHOD_CVT;
    vor_status status;
    int moved = 0;

    if (!(filtered || spread) || spec->value[VOR_PARAM_NEIGHBORS] != VOR_UNSET ||
        domain->known.sheets || domain->known.sheeted.count > 0)
        return VOR_OK;
    status = vor_settle(domain, &moved, run, err);
    if (status == VOR_OK && moved)
        status = take_outliers(outliers, domain, spec, run, err);
    return status == VOR_OK && moved ? find_sheets(domain, spec, run, err) : status;
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

/* Looks whether lists of neighbours pay. Fits to more points than a list has make no use of one. */
static vor_status choose_lists(struct vor_domain *domain, const struct vor_spec *spec,
                               const struct vor_run *run, struct vor_error *err)
{
    int makes_triangles = vor_process_takes(spec->process, VOR_PARAM_SOUP);
    /* where a list of the input reaches as far as the cell of a point of the result */
    int reaches = VOR_ADJACENT * vor_spec_target(spec, domain->n) >= (double)domain->n;
    enum vor_lists *lists = &domain->known.lists;
    vor_status status;

    if (spec->value[VOR_PARAM_INTRINSIC] != VOR_INTRINSIC_LOCAL ||
        domain->known.neighbors.usual > VOR_ADJACENT)
        return VOR_OK;
    status = vor_adjacency_probe(lists, domain, makes_triangles && reaches, run, err);
    domain->known.parted = makes_triangles && *lists != VOR_LISTS_FEW;
    return status;
}

/* The filters that come after everything is known. */
static vor_status filter(struct vor_domain *domain, const struct vor_spec *spec,
                         const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;

    if (has_filter(spec, VOR_FILTER_MLS))
        status = vor_mls_project(domain, run, err);
    if (status == VOR_OK && has_filter(spec, VOR_FILTER_THIN))
        status = vor_thin_filter(domain, run, err);
    return status;
}

/* Finds out what there is to know of a domain before its points are filtered. */
static vor_status know(struct vor_domain *domain, struct vor_outliers *outliers,
                       const struct vor_spec *spec, const struct vor_run *run,
                       struct vor_error *err)
{
    vor_status status = take_outliers(outliers, domain, spec, run, err);

    VOR_THEN(status, leave_lattice(domain, spec, run, err));
    VOR_THEN(status, find_sheets(domain, spec, run, err));
    VOR_THEN(status, choose_neighbors(domain, spec, run, err));
    VOR_THEN(status, leave_noise(domain, outliers, spec, run, err));
    VOR_THEN(status, choose_lists(domain, spec, run, err));
    if (status == VOR_OK && outliers_of(spec) == VOR_OUTLIERS_PULL)
        status = vor_outliers_pull(domain, outliers, run, err);
    return status;
}

/* Makes the domain of a cloud that the process inspect looks at. */
static vor_status see(struct vor_domain *seen, const struct vor_cloud *in,
                      const struct vor_run *run, struct vor_error *err)
{
    struct vor_outliers outliers = {.memory = run->memory};
    struct vor_spec spec;
    vor_status status;

    vor_spec_preset(&spec, vor_process_find("inspect"));
    status = make(seen, &outliers, in, &spec, run, err);
    VOR_THEN(status, know(seen, &outliers, &spec, run, err));
    VOR_THEN(status, vor_lists_make(seen, run, err));
    VOR_THEN(status, vor_lists_make_any(seen, 0, run, err));
    vor_outliers_free(&outliers);
    return status;
}

/* Fills holes where the request says so and points are to be spread. */
static vor_status fill(struct vor_domain *domain, const struct vor_cloud *in,
                       const struct vor_spec *spec, const struct vor_run *run,
                       struct vor_error *err)
{
    struct vor_domain seen = {.n = 0};
    vor_status status;

    if (spec->value[VOR_PARAM_BOUNDARY] != VOR_BOUNDARY_FILL || vor_spec_only_filters(spec))
        return VOR_OK;
    status = see(&seen, in, run, err);
    VOR_THEN(status, vor_holes_fill(domain, &seen, in->origin, spec, run, err));
    vor_domain_free(&seen);
    return status;
}

/* Finds out everything that is known of a domain, fills its holes and filters it. */
static vor_status condition(struct vor_domain *domain, struct vor_outliers *outliers,
                            const struct vor_cloud *in, const struct vor_spec *spec,
                            const struct vor_run *run, struct vor_error *err)
{
    vor_status status = know(domain, outliers, spec, run, err);

    VOR_THEN(status, fill(domain, in, spec, run, err));
    VOR_THEN(status, vor_lists_make(domain, run, err));
    VOR_THEN(status, filter(domain, spec, run, err));
    if (status == VOR_OK)
        status = spreads(spec)
                     ? vor_islands_take(domain, vor_spec_target(spec, domain->n), run, err)
                     : vor_islands_count(domain, run, err);
    if (status == VOR_OK && outliers_of(spec) == VOR_OUTLIERS_KEEP && outliers->n > 0)
        status = vor_islands_add(domain, outliers, run, err);
    VOR_THEN(status, vor_lists_make(domain, run, err)); /* again without islands */
    VOR_THEN(status, vor_lists_keep(domain, run, err));
    return status;
}

vor_status vor_input_prepare(struct vor_domain *out, const struct vor_cloud *in,
                             const struct vor_spec *spec, const struct vor_run *run,
                             struct vor_error *err)
{
    struct vor_outliers outliers = {.memory = run->memory};
    struct vor_domain domain;
    vor_status status = vor_carried_check(in, spec, run, err);

    VOR_THEN(status, vor_followed_check(in, spec, run, err));
    VOR_THEN(status, make(&domain, &outliers, in, spec, run, err));
    if (status != VOR_OK)
        return status;
    domain.known.distinct = domain.n + outliers.n;
    status = condition(&domain, &outliers, in, spec, run, err);
    vor_outliers_free(&outliers);
    if (status == VOR_OK)
        *out = domain;
    else
        vor_domain_free(&domain);
    return status;
}
