#include "tests/support/vt_stages.h"
#include "tests/support/vt_engine.h"

#include "core/cvt/lloyd.h"
#include "core/geom/patch.h"
#include "core/input/input.h"
#include "core/input/thin.h"
#include "core/output/last_record.h"
#include "core/output/output.h"
#include "core/seeds/area.h"
#include "core/seeds/attach.h"
#include "core/seeds/repel.h"
#include "core/seeds/start.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

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

/* True for what means nothing without a density or metric, without sites on edges or without holes
 * to fill, where none are asked for. */
static int is_idle(const struct vor_spec *spec, int parameter)
{
    if (parameter == VOR_PARAM_METRIC || parameter == VOR_PARAM_MAX_ASPECT)
        return spec->value[VOR_PARAM_METRIC] == VOR_METRIC_ISOTROPIC;
    if (parameter == VOR_PARAM_EDGES)
        return spec->value[parameter] == VOR_EDGES_IGNORE;
    if (parameter == VOR_PARAM_HOLES || parameter == VOR_PARAM_HOLE_MAX)
        return spec->value[VOR_PARAM_BOUNDARY] != VOR_BOUNDARY_FILL;
    return spec->value[VOR_PARAM_DENSITY] == VOR_DENSITY_UNIFORM &&
           (parameter == VOR_PARAM_DENSITY || parameter == VOR_PARAM_CONTRAST ||
            parameter == VOR_PARAM_GRADING);
}

/* The same without an energy to minimise, and for a stop that is not asked for. */
static int is_idle_descent(const struct vor_spec *spec, int parameter)
{
    return parameter == VOR_PARAM_MOVE_STOP
               ? !vor_spec_given(spec, VOR_PARAM_MOVE_STOP)
               : !vor_spec_descends(spec) &&
                     (parameter == VOR_PARAM_P || parameter == VOR_PARAM_CELLS);
}

/* What the process takes: a parameter that only others do is no part of the request, nor is how the
 * input was read or what of it is sampled, which is over before the first stage, nor what a file
 * counts from or what is made beside the result, after the last. */
static void add_spec(uint64_t *hash, const struct vor_spec *spec)
{
    add_bytes(hash, spec->process->id, strlen(spec->process->id) + 1);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        const char *name = vor_parameter_info((enum vor_parameter)i)->name;

        if (vor_parameter_info((enum vor_parameter)i)->group == VOR_GROUP_READ ||
            i == VOR_PARAM_ORIGIN || i == VOR_PARAM_SAMPLE || i == VOR_PARAM_BASELINES)
            continue;
        if (!vor_process_takes(spec->process, (enum vor_parameter)i) || is_idle(spec, i) ||
            is_idle_descent(spec, i))
            continue;
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

/* One run from the inside, as core/engine.c and core/cvt/cvt.c string it together. */
struct stages {
    const struct vor_cloud *in;
    struct told told;
    struct vor_run run, whole; /* whole: for what a stop must not cut short */
    struct vor_no_stop no_stop;
    struct vor_spec spec;
    struct vor_domain domain, thin;
    struct vor_seeds seeds;
    struct vor_outcome outcome;
    struct vor_report report;
    size_t n;
    double area;
};

static void resolve_target(struct stages *s)
{
    double n = vor_spec_target(&s->spec, s->in->n);

    if (vor_spec_given(&s->spec, VOR_PARAM_SPACING)) {
        double spacing = s->spec.value[VOR_PARAM_SPACING] / s->domain.unit;

        vt_assert_ok(vor_area_of_surface(
            &s->area, &s->domain, (uint64_t)s->spec.value[VOR_PARAM_SEED], &s->whole, &vt_err));
        n = rint(s->area / (VOR_HEXAGON_HEIGHT * spacing * spacing));
    }
    vt_assert_ok(vor_spec_check_target(&s->spec, n, s->in->n, &vt_err));
    s->n = (size_t)n;
}

/* Input: the points that surfaces are fitted to, what was found out about them, and how many points
 * are to come out. */
static void hash_input(uint64_t *hash, const struct stages *s)
{
    const struct vor_domain *domain = &s->domain;
    const struct vor_conditioning *known = &domain->known;
    const struct vor_neighbors *neighbors = &known->neighbors;

    start_hash(hash);
    add_positions(hash, domain->xyz, domain->n);
    add_bytes(hash, domain->source, domain->n * sizeof *domain->source);
    add_doubles(hash, domain->shift, 3);
    add_double(hash, domain->unit);
    add_double(hash, domain->sparse);
    add_count(hash, known->sheets != 0);
    add_count(hash, !vor_domain_is_exact(domain));
    add_count(hash, known->outliers);
    for (int c = 0; c < 3; c++)
        add_double(hash, known->lattice.cell[c] * domain->unit);
    add_count(hash, known->off_lattice);
    add_count(hash, neighbors->usual);
    add_count(hash, neighbors->most);
    add_positions(hash, neighbors->xyz, neighbors->places);
    for (unsigned i = 0; i < neighbors->places; i++)
        add_count(hash, neighbors->k[i]);
    add_count(hash, s->n);
}

static void run_input(struct stages *s)
{
    vt_assert_ok(vor_input_prepare(&s->domain, s->in, &s->spec, &s->whole, &vt_err));
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
    vt_assert_ok(vor_start_seeds(&s->seeds, &s->domain, s->n, &s->spec, &s->run, &vt_err));
    vt_assert_ok(
        vor_domain_thin_for(&s->thin, &s->domain, s->n, s->seeds.area, &s->whole, &vt_err));
    if (s->thin.n >= s->seeds.input_lists.wide)
        vor_seeds_onto(&s->seeds, &s->thin);
}

/* Iterate: the most even iterate, why the loop ended, and what it told. */
static void hash_iterate(uint64_t *hash, struct stages *s)
{
    double unit = s->domain.unit;

    start_hash(hash);
    add_positions(hash, s->seeds.xyz, s->seeds.n);
    add_count(hash, s->outcome.steps[VOR_RUN_STAGE_ITERATE]);
    add_count(hash, s->outcome.stopped);
    add_count(hash, s->outcome.held);
    add_count(hash, s->outcome.held_ever);
    add_count(hash, s->outcome.fallback_plane);
    add_count(hash, s->outcome.fallback_left);
    add_double(hash, s->outcome.area * unit * unit);
    add_told(hash, &s->told);
}

static void run_iterate(struct stages *s)
{
    vt_assert_ok(vor_lloyd_run(&s->seeds, &s->outcome, &s->spec, &s->run, &vt_err));
}

/* Even out: where the points end, how many steps that took, and what was told of them. */
static void hash_even_out(uint64_t *hash, struct stages *s)
{
    start_hash(hash);
    add_positions(hash, s->seeds.xyz, s->seeds.n);
    add_count(hash, s->outcome.steps[VOR_RUN_STAGE_POLISH]);
    add_count(hash, s->outcome.stopped);
    add_told(hash, &s->told);
}

static void run_even_out(struct stages *s)
{
    int keep_holes;

    vt_assert_ok(vor_attach(&s->seeds, &keep_holes, &vt_err));
    vt_assert_ok(vor_repel(&s->seeds, &s->outcome, keep_holes, &s->spec, &s->run, &vt_err));
    vt_assert_ok(vor_attach_to_whole(&s->seeds, keep_holes, &vt_err));
    if (s->outcome.steps[VOR_RUN_STAGE_POLISH] > 0)
        vt_assert_ok(vor_attach_last(&s->seeds, &vt_err));
}

static void run_output(struct stages *s, struct vor_cloud *out)
{
    struct vor_placed placed = {s->in, &s->seeds, &s->outcome, &s->spec, NULL};
    struct vor_report *report = &s->report;
    double unit = s->domain.unit;

    vt_assert_ok(vor_output_make(out, report, &placed, &vt_err));
    vt_assert_ok(vor_last_record_tell(&s->outcome, report, &s->run, &vt_err));
    report->parameters = s->spec;
    report->parameters.value[VOR_PARAM_POINTS] = (double)s->n;
    report->parameters.value[VOR_PARAM_NEIGHBORS] = s->domain.known.neighbors.usual;
    if (vor_spec_given(&s->spec, VOR_PARAM_SPACING))
        report->area = s->area * unit * unit;
}

void vt_stages_drive(uint64_t hash[VT_STAGE_COUNT], const struct vt_stages_run *run)
{
    struct stages s = {.in = run->in, .spec = run->spec};
    struct vor_cloud out;

    listen(&s.told, run->stop);
    vt_assert_ok(vor_pool_create(&s.run.pool, run->threads, &vt_err));
    s.run.memory = &vt_memory;
    s.run.watch = &s.told.watch;
    s.run.no_stop = vor_no_stop_watch(&s.no_stop, s.run.watch);
    s.whole = vor_run_unstoppable(&s.run);
    run_input(&s);
    hash_input(&hash[VT_STAGE_INPUT], &s);
    run_start(&s);
    hash_start(&hash[VT_STAGE_START], &s);
    run_iterate(&s);
    hash_iterate(&hash[VT_STAGE_ITERATE], &s);
    run_even_out(&s);
    hash_even_out(&hash[VT_STAGE_EVEN_OUT], &s);
    vor_cloud_init(&out, &vt_memory);
    run_output(&s, &out);
    hash_cloud(&hash[VT_STAGE_OUTPUT], &out);
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
    vt_assert_ok(vt_run_engine(&out, &report, run->in, &run->spec, &engine_run, &vt_err));
    hash_cloud(&hash[VT_STAGE_OUTPUT], &out);
    hash_report(&hash[VT_STAGE_REPORT], &report, &told);
    vor_cloud_free(&out);
    vor_pool_destroy(engine_run.pool);
}
