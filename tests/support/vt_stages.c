#include "tests/support/vt_stages.h"

#include "core/cvt/start.h"
#include "core/input/lattice.h"
#include "core/input/neighbors.h"
#include "core/input/outliers.h"
#include "core/input/sheets.h"
#include "core/method.h"
#include "core/output/compare.h"
#include "core/output/order.h"
#include "core/output/transfer.h"
#include "core/seeds/attach.h"
#include "core/seeds/repel.h"
#include "core/seeds/uniformity.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

/* As in core/engine.c. */
enum { THINNED = 5, THINNED_FOR = 20, THINNED_LEAST = 20000 };

const char *vt_stage_word(enum vt_stage stage)
{
    static const char *const words[VT_STAGE_COUNT] = {
#define STAGE_WORD(id, word) word,
        VT_STAGE_TABLE(STAGE_WORD)
#undef STAGE_WORD
    };

    return words[stage];
}

/* FNV-1a, continued. */
static void add_bytes(uint64_t *hash, const void *data, size_t size)
{
    const unsigned char *byte = data;

    for (size_t i = 0; i < size; i++)
        *hash = (*hash ^ byte[i]) * UINT64_C(0x100000001b3);
}

static void add_count(uint64_t *hash, uint64_t count)
{
    add_bytes(hash, &count, sizeof count);
}

static void add_double(uint64_t *hash, double x)
{
    add_bytes(hash, &x, sizeof x);
}

static void add_doubles(uint64_t *hash, const double *x, size_t n)
{
    add_bytes(hash, x, n * sizeof *x);
}

static void add_positions(uint64_t *hash, const float *xyz, size_t n)
{
    add_count(hash, n);
    add_bytes(hash, xyz, 3 * n * sizeof *xyz);
}

static void start_hash(uint64_t *hash)
{
    *hash = UINT64_C(0xcbf29ce484222325);
}

/* Everything of a record but its seconds. */
static void add_record(uint64_t *hash, const struct vor_record *record)
{
    add_count(hash, record->iteration);
    add_count(hash, record->polish);
    add_double(hash, record->delta);
    add_double(hash, record->sigma);
    add_double(hash, record->epsilon);
    add_double(hash, record->energy);
    add_double(hash, record->max_move);
    add_count(hash, record->held);
}

/* What the watch is told: in the stage at hand, and in the whole run. */
struct told {
    uint64_t stage, all;
    unsigned records, stop;
    struct vor_watch watch;
};

static enum vor_answer progress(void *ctx, const struct vor_record *record)
{
    struct told *told = ctx;

    add_record(&told->stage, record);
    add_record(&told->all, record);
    return ++told->records == told->stop ? VOR_STOP : VOR_CONTINUE;
}

static double records_told(void *ctx)
{
    return ((const struct told *)ctx)->records;
}

static void listen(struct told *told, unsigned stop)
{
    *told = (struct told){.stop = stop};
    start_hash(&told->stage);
    start_hash(&told->all);
    told->watch = (struct vor_watch){.ctx = told, .progress = progress, .clock = records_told};
}

/* The records since the last time. */
static void add_told(uint64_t *hash, struct told *told)
{
    add_count(hash, told->stage);
    start_hash(&told->stage);
}

/* Output: everything that a cloud has. */
static void hash_cloud(uint64_t *hash, const struct vor_cloud *cloud)
{
    start_hash(hash);
    add_count(hash, cloud->position_type);
    add_doubles(hash, cloud->origin, 3);
    add_positions(hash, cloud->xyz, cloud->n);
    add_count(hash, cloud->attribute_count);
    for (size_t a = 0; a < cloud->attribute_count; a++) {
        const struct vor_attribute *attribute = &cloud->attributes[a];

        add_bytes(hash, attribute->name, strlen(attribute->name) + 1);
        add_count(hash, attribute->semantic);
        add_count(hash, attribute->type);
        add_count(hash, attribute->components);
        add_bytes(hash, attribute->data,
                  cloud->n * attribute->components * vor_type_size(attribute->type));
    }
}

static void add_apart(uint64_t *hash, const struct vor_apart *apart)
{
    add_double(hash, apart->mean);
    add_double(hash, apart->rms);
    add_double(hash, apart->max);
    add_count(hash, apart->points);
}

static void add_spec(uint64_t *hash, const struct vor_spec *spec)
{
    add_bytes(hash, spec->process->id, strlen(spec->process->id) + 1);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        const char *name = vor_parameter_info((enum vor_parameter)i)->name;

        add_bytes(hash, name, strlen(name) + 1);
        add_double(hash, spec->value[i]);
    }
}

/* Report: all of it but times and memory, and every record of the run. */
static void hash_report(uint64_t *hash, const struct vor_report *report, const struct told *told)
{
    start_hash(hash);
    add_count(hash, told->all);
    add_count(hash, report->points_in);
    add_count(hash, report->points_out);
    add_double(hash, report->delta);
    add_double(hash, report->sigma);
    add_double(hash, report->epsilon);
    add_count(hash, report->iterations);
    add_count(hash, report->polish_steps);
    add_count(hash, report->stopped);
    add_count(hash, report->outliers);
    add_doubles(hash, report->lattice, 3);
    add_count(hash, report->off_lattice);
    add_apart(hash, &report->in_to_out);
    add_apart(hash, &report->out_to_in);
    add_count(hash, report->boundary_points);
    add_count(hash, report->fitted_count);
    for (unsigned i = 0; i < report->fitted_count; i++) {
        add_count(hash, report->fitted[i].neighbors);
        add_count(hash, report->fitted[i].points);
    }
    add_count(hash, report->held);
    add_count(hash, report->held_ever);
    add_count(hash, report->fallback_plane);
    add_count(hash, report->fallback_left);
    add_double(hash, report->area);
    add_double(hash, report->spacing_mean);
    add_double(hash, report->min_over_mean);
    add_double(hash, report->max_over_mean);
    add_double(hash, report->six_share);
    add_double(hash, report->bisectors_per_cell);
    add_double(hash, report->triangles_per_cell);
    add_count(hash, report->queries);
    add_count(hash, report->list_rebuilds);
    add_spec(hash, &report->parameters);
}

/* One run from the inside, as struct engine of core/engine.c. */
struct stages {
    const struct vor_cloud *in;
    struct told told;
    struct vor_run run, no_stop_run;
    struct vor_no_stop no_stop;
    struct vor_spec spec;
    struct vor_domain domain, thin;
    struct vor_neighbors neighbors;
    struct vor_seeds seeds;
    struct vor_cvt_result result;
    struct vor_uniformity even;
    struct vor_report report;
    size_t n;
    double area;
};

static void leave_lattice(struct stages *s)
{
    struct vor_lattice lattice;
    size_t moved = 0;

    vt_assert_ok(vor_lattice_find(&lattice, &s->domain, &s->no_stop_run, &vt_err));
    if (lattice.matters)
        vt_assert_ok(vor_lattice_smooth(&s->domain, &moved, &lattice, &s->no_stop_run, &vt_err));
    for (int c = 0; c < 3; c++)
        s->report.lattice[c] = lattice.cell[c] * s->domain.unit;
    s->report.off_lattice = moved;
}

static void resolve_neighbors(struct stages *s)
{
    double *value = &s->spec.value[VOR_PARAM_NEIGHBORS];

    if (*value != VOR_UNSET) {
        vor_neighbors_fix(&s->neighbors, (unsigned)*value);
        return;
    }
    vt_assert_ok(vor_neighbors_choose(&s->neighbors, &s->domain, &s->no_stop_run, &vt_err));
    *value = s->neighbors.usual;
}

static void resolve_target(struct stages *s)
{
    double n = vor_spec_target(&s->spec, s->in->n);

    if (vor_spec_given(&s->spec, VOR_PARAM_SPACING)) {
        double spacing = s->spec.value[VOR_PARAM_SPACING] / s->domain.unit;

        vt_assert_ok(vor_seeds_area(&s->area, &s->domain, &s->neighbors, &s->spec, &s->no_stop_run,
                                    &vt_err));
        n = rint(s->area / (0.86602540378443865 * spacing * spacing));
    }
    vt_assert_ok(vor_spec_check_target(&s->spec, n, s->in->n, &vt_err));
    s->n = (size_t)n;
    s->report.parameters = s->spec;
    s->report.parameters.value[VOR_PARAM_POINTS] = n;
}

/* Input: the points that surfaces are fitted to, what was found out about them, and how many points
 * are to come out. */
static void hash_input(uint64_t *hash, const struct stages *s)
{
    const struct vor_domain *domain = &s->domain;
    const struct vor_neighbors *neighbors = &s->neighbors;

    start_hash(hash);
    add_positions(hash, domain->xyz, domain->n);
    add_bytes(hash, domain->source, domain->n * sizeof *domain->source);
    add_doubles(hash, domain->shift, 3);
    add_double(hash, domain->unit);
    add_double(hash, domain->sparse);
    add_count(hash, domain->sheets != 0);
    add_count(hash, domain->rounded != 0);
    add_count(hash, s->report.outliers);
    add_doubles(hash, s->report.lattice, 3);
    add_count(hash, s->report.off_lattice);
    add_count(hash, neighbors->usual);
    add_count(hash, neighbors->most);
    add_positions(hash, neighbors->xyz, neighbors->places);
    for (unsigned i = 0; i < neighbors->places; i++)
        add_count(hash, neighbors->k[i]);
    add_count(hash, s->n);
}

static void run_input(struct stages *s)
{
    vt_assert_ok(vor_domain_init(&s->domain, s->in, &s->no_stop_run, &vt_err));
    if (s->spec.value[VOR_PARAM_OUTLIERS] == VOR_OUTLIERS_DROP) {
        size_t dropped = 0;

        vt_assert_ok(vor_outliers_drop(&s->domain, &dropped, &s->no_stop_run, &vt_err));
        s->report.outliers = dropped;
    }
    leave_lattice(s);
    vt_assert_ok(vor_sheets_find(&s->domain, &s->no_stop_run, &vt_err));
    resolve_neighbors(s);
    resolve_target(s);
}

/* Start: the seeds, and the points of a dense input that they begin on. */
static void hash_start(uint64_t *hash, const struct stages *s)
{
    start_hash(hash);
    add_positions(hash, s->seeds.xyz, s->seeds.n);
    add_double(hash, s->seeds.area);
    add_positions(hash, s->thin.xyz, s->thin.n);
}

static void run_start(struct stages *s)
{
    double more, wanted;

    vt_assert_ok(vor_start_seeds(&s->seeds, &s->domain, s->n, &s->neighbors, &s->spec,
                                 &s->no_stop_run, &vt_err));
    more = fmax(1, (double)s->neighbors.most / THINNED_FOR);
    wanted = fmax(THINNED * more * (double)s->n, THINNED_LEAST);
    if ((double)s->domain.n < 2 * wanted || !(s->seeds.area > 0))
        return;
    vt_assert_ok(vor_domain_thin(&s->thin, &s->domain, sqrt(s->seeds.area / wanted),
                                 &s->no_stop_run, &vt_err));
    if (s->thin.n >= s->seeds.input_lists.wide)
        vor_seeds_onto(&s->seeds, &s->thin);
}

/* Iterate: the most even iterate, why the loop ended, and what it told. */
static void hash_iterate(uint64_t *hash, struct stages *s)
{
    start_hash(hash);
    add_positions(hash, s->seeds.xyz, s->seeds.n);
    add_count(hash, s->result.iterations);
    add_count(hash, s->result.stopped);
    add_count(hash, s->result.held);
    add_count(hash, s->result.held_ever);
    add_count(hash, s->result.fallback_plane);
    add_count(hash, s->result.fallback_left);
    add_double(hash, s->result.area);
    add_told(hash, &s->told);
}

static void run_iterate(struct stages *s)
{
    const struct vor_method *method = vor_method((unsigned)s->spec.value[VOR_PARAM_METHOD]);

    s->seeds.run = &s->run;
    vt_assert_ok(method->run(&s->seeds, &s->result, &s->spec, 0, &vt_err));
}

/* Even out: where the points end, how many steps that took, and what was told of them. */
static void hash_even_out(uint64_t *hash, struct stages *s)
{
    start_hash(hash);
    add_positions(hash, s->seeds.xyz, s->seeds.n);
    add_count(hash, s->result.polish_steps);
    add_count(hash, s->result.stopped);
    add_told(hash, &s->told);
}

static void run_even_out(struct stages *s)
{
    s->seeds.run = &s->no_stop_run;
    vt_assert_ok(vor_attach(&s->seeds, &vt_err));
    s->seeds.run = &s->run;
    vt_assert_ok(vor_repel(&s->seeds, &s->result, &s->spec, 0, &vt_err));
    s->seeds.run = &s->no_stop_run;
    vt_assert_ok(vor_attach_to_whole(&s->seeds, &vt_err));
    if (s->result.polish_steps > 0)
        vt_assert_ok(vor_attach_last(&s->seeds, &vt_err));
}

static struct vor_apart in_unit(const struct vor_compare_apart *apart, double unit)
{
    return (struct vor_apart){apart->mean * unit, apart->rms * unit, apart->max * unit,
                              apart->points};
}

/* Distances to the input, the border, and the numbers of neighbours. */
static void account_for(struct stages *s)
{
    struct vor_report *report = &s->report;
    struct vor_comparison account;

    vt_assert_ok(vor_compare(&account, &s->seeds, s->even.mean, &vt_err));
    report->in_to_out = in_unit(&account.in_to_out, s->domain.unit);
    report->out_to_in = in_unit(&account.out_to_in, s->domain.unit);
    report->boundary_points = account.border;
    for (unsigned k = 0; k <= VOR_NEIGHBORS_MAX; k++)
        if (account.fitted[k] > 0)
            report->fitted[report->fitted_count++] = (struct vor_fitted){k, account.fitted[k]};
}

/* What is measured on the result before it is handed back. */
static void measure(struct stages *s)
{
    float *nearest = vor_malloc(s->run.memory, s->n, sizeof *nearest);
    struct vor_counts counts;

    ck_assert_ptr_nonnull(nearest);
    vt_assert_ok(vor_seeds_index(&s->seeds, &vt_err));
    vt_assert_ok(vor_seeds_uniformity(&s->even, nearest, &s->seeds, s->seeds.xyz, &vt_err));
    vt_assert_ok(vor_seeds_six_share(&s->report.six_share, &s->seeds, &vt_err));
    vor_free(s->run.memory, nearest);
    counts = vor_seeds_counts(&s->seeds);
    s->report.queries = counts.queries;
    if (counts.cells > 0) {
        s->report.bisectors_per_cell = (double)counts.bisectors / (double)counts.cells;
        s->report.triangles_per_cell = (double)counts.triangles / (double)counts.cells;
    }
    account_for(s);
}

static void hand_back(struct stages *s, struct vor_cloud *out)
{
    double spacing = s->even.mean * s->domain.unit;
    uint32_t *order = NULL;

    if (s->spec.value[VOR_PARAM_ORDER] == VOR_ORDER_PROGRESSIVE) {
        order = vor_malloc(s->run.memory, s->n, sizeof *order);
        ck_assert_ptr_nonnull(order);
        vt_assert_ok(vor_order_progressive(order, s->seeds.xyz, s->seeds.n, s->even.mean,
                                           s->seeds.run, &vt_err));
    }
    vt_assert_ok(vor_transfer(out, s->in, &s->seeds, spacing, &s->spec, &vt_err));
    if (order != NULL)
        vt_assert_ok(vor_cloud_reorder(out, order, &vt_err));
    vor_free(s->run.memory, order);
}

/* What is not in the report yet. */
static void finish_report(struct stages *s)
{
    struct vor_report *report = &s->report;
    double unit = s->domain.unit;

    report->points_in = s->in->n;
    report->points_out = s->n;
    report->delta = s->even.delta;
    report->sigma = s->even.sigma * unit;
    report->epsilon = s->even.epsilon;
    report->spacing_mean = s->even.mean * unit;
    report->iterations = s->result.iterations;
    report->polish_steps = s->result.polish_steps;
    report->stopped = s->result.stopped;
    report->held = s->result.held;
    report->held_ever = s->result.held_ever;
    report->fallback_plane = s->result.fallback_plane;
    report->fallback_left = s->result.fallback_left;
    report->area = s->result.iterations > 0 ? s->result.area : s->seeds.area * unit * unit;
    if (vor_spec_given(&s->spec, VOR_PARAM_SPACING))
        report->area = s->area * unit * unit;
    report->min_over_mean = s->even.mean > 0 ? s->even.min / s->even.mean : 0;
    report->max_over_mean = s->even.mean > 0 ? s->even.max / s->even.mean : 0;
    report->list_rebuilds = s->seeds.point_lists.indexed;
}

void vt_stages_drive(uint64_t hash[VT_STAGE_COUNT], const struct vt_stages_run *run)
{
    struct stages s = {.in = run->in, .spec = run->spec};
    struct vor_cloud out;

    listen(&s.told, run->stop);
    vt_assert_ok(vor_pool_create(&s.run.pool, run->threads, &vt_err));
    s.run.memory = &vt_memory;
    s.run.watch = &s.told.watch;
    s.no_stop_run = s.run;
    s.no_stop_run.watch = vor_no_stop_watch(&s.no_stop, s.run.watch);
    run_input(&s);
    hash_input(&hash[VT_STAGE_INPUT], &s);
    run_start(&s);
    hash_start(&hash[VT_STAGE_START], &s);
    run_iterate(&s);
    hash_iterate(&hash[VT_STAGE_ITERATE], &s);
    run_even_out(&s);
    hash_even_out(&hash[VT_STAGE_EVEN_OUT], &s);
    measure(&s);
    vor_cloud_init(&out, &vt_memory);
    hand_back(&s, &out);
    hash_cloud(&hash[VT_STAGE_OUTPUT], &out);
    finish_report(&s);
    hash_report(&hash[VT_STAGE_REPORT], &s.report, &s.told);

    vor_cloud_free(&out);
    vor_seeds_free(&s.seeds);
    vor_domain_free(&s.thin);
    vor_domain_free(&s.domain);
    vor_pool_destroy(s.run.pool);
}

void vt_stages_engine(uint64_t hash[VT_STAGE_COUNT], const struct vt_stages_run *run)
{
    struct vor_run engine_run = {.memory = &vt_memory};
    struct vor_report report;
    struct vor_cloud out;
    struct told told;

    listen(&told, run->stop);
    engine_run.watch = &told.watch;
    vt_assert_ok(vor_pool_create(&engine_run.pool, run->threads, &vt_err));
    vor_cloud_init(&out, &vt_memory);
    vt_assert_ok(vor_engine_run(&out, &report, run->in, &run->spec, &engine_run, &vt_err));
    hash_cloud(&hash[VT_STAGE_OUTPUT], &out);
    hash_report(&hash[VT_STAGE_REPORT], &report, &told);
    vor_cloud_free(&out);
    vor_pool_destroy(engine_run.pool);
}
