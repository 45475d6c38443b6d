#include "core/align/align.h"

#include "core/align/fit.h"
#include "core/geom/surface.h"
#include "core/input/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    /* Poses that every third sample refines, of those that every fourth sample finds good, and
     * poses that all samples refine. */
    MIDDLING = 16,
    LAST = 8,
    STEPS_TOLD = 4
};

/* Least share of the gap within which samples lie on the other cloud. Half of it is the most. */
#define WITHIN_LEAST 0.15

/* Where a pose loses half of its score. Right poses of scans, bodies and parts of them: hover at
 * most 0.04, mostly below 0.01; wrong ones 0.1 to 0.6 but for those that nothing contradicts. */
#define HOVERS 0.03

/* Where trust is 0.5. BESIDE and LOOSE also are where a pose loses half of its score. Hover: right
 * poses at most 0.04, in two of 120 0.063. Beside, at borders and folds: right ones at most 0.21,
 * wrong ones of kitti 0.25 to 0.6. Looseness: right ones 0.1 to 1.1 (0.7 of noise alone), wrong
 * ones of kitti 1.4 to 10. Firmness: right poses 0.0048 and more but for 2 of 24 of kitti, spheres,
 * tori and cylinders at most 0.0005. Wrong poses of thin plates have 0.0041 and 0.0051 where little
 * else contradicts them: what is weakly held has to agree the better. */
#define HOVER 0.07
#define BESIDE 0.33
#define LOOSE 1.8
#define FIRM 0.004
#define OVERLAP 0.1
#define LEAD OVERLAP /* over the rival */

/* Poses that parts of the evidence lead to, apart: a degree, as angle and over the unit. Halves of
 * the points, which are twice as far apart as the pose of all is from the right one, and the
 * reference laid on the cloud: office1, scannet and igea, right poses, at most 0.2 degrees and
 * 0.005; kitti, 200 to 700 samples, wrong ones that all else speaks for, 0.7 to 2.2 degrees and
 * 0.017 to 0.08. */
#define REPEATED (M_PI / 180)

/* The poses that are compared. */
struct align {
    struct vor_align_samples samples[2];
    struct vor_align_points points[2];
    struct vor_align_grid grid;
    struct vor_align_fit_of of;
    double within;             /* of judging */
    const struct vor_run *run; /* whose watch is told of each step */
    uint32_t steps;
    unsigned count;
    struct vor_align_candidate candidate[VOR_ALIGN_CANDIDATES];
    struct vor_align_fit fit[VOR_ALIGN_CANDIDATES];
    struct vor_align_fit again[3]; /* the best, refined by either half, and back */
};

static void refine_few(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct align *align = ctx;
    struct vor_align_fit *fit = &align->fit[i];

    *fit =
        (struct vor_align_fit){.pose = align->candidate[i].pose, .flip = align->candidate[i].flip};
    vor_align_refine_few(&fit->pose, fit->flip, &align->of);
    vor_align_judge(fit, &align->of, align->within);
}

static void refine(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct align *align = ctx;

    vor_align_refine(&align->fit[i], &align->of);
    vor_align_judge(&align->fit[i], &align->of, align->within);
}

/* What speaks against a pose, as a factor of its score. */
static double plausible(const struct vor_align_fit *fit)
{
    return 1 / (1 + vor_power(fit->hover / HOVERS, 2)) / (1 + vor_power(fit->beside / BESIDE, 4)) /
           (1 + vor_power(fit->loose / LOOSE, 4));
}

static void settle(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct align *align = ctx;
    struct vor_align_fit *fit = &align->fit[i];

    vor_align_settle(&fit->pose, &align->of);
    vor_align_weigh(fit, &align->of);
    vor_align_judge(fit, &align->of, align->within);
    fit->score = fit->on * plausible(fit);
}

static void refine_again(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    struct align *align = ctx;
    struct vor_align_fit_of of = align->of;
    struct vor_align_fit fit = align->fit[0];

    if (i < 2) {
        of.every = 2;
        of.first = (unsigned)i;
    } else {
        of.points[0] = align->of.points[1];
        of.points[1] = align->of.points[0];
        of.overlap = 0; /* of the cloud */
        vor_pose_invert(&fit.pose, &align->fit[0].pose);
    }
    vor_align_settle(&fit.pose, &of);
    align->again[i] = fit;
    if (i == 2)
        vor_pose_invert(&align->again[i].pose, &fit.pose);
}

static int better_first(const void *a, const void *b)
{
    const struct vor_align_fit *first = a, *second = b;

    if (first->score > second->score || first->score < second->score)
        return first->score > second->score ? -1 : 1;
    for (int c = 0; c < 3; c++)
        if (first->pose.shift[c] < second->pose.shift[c] ||
            first->pose.shift[c] > second->pose.shift[c])
            return first->pose.shift[c] < second->pose.shift[c] ? -1 : 1;
    return 0;
}

/* Sorts the fits, best first, and keeps of those that are alike the best, and at most so many. */
static void keep_best(struct align *align, unsigned most)
{
    struct vor_align_fit *fit = align->fit;
    unsigned kept = 0;

    qsort(fit, align->count, sizeof *fit, better_first);
    for (unsigned i = 0; i < align->count && kept < most; i++) {
        int known = 0;

        for (unsigned j = 0; j < kept; j++)
            known |= vor_poses_are_alike(&fit[j].pose, &fit[i].pose, align->grid.reach);
        if (!known)
            fit[kept++] = fit[i];
    }
    align->count = kept;
}

/* Tells the watch of the best pose so far. A stop has nothing to hand back yet. */
static vor_status tell_step(const struct align *align, struct vor_error *err)
{
    struct vor_record record = {.stage = VOR_RUN_STAGE_ALIGN, .of = STEPS_TOLD};

    record.iteration = record.step = align->steps;
    record.delta = record.sigma = record.epsilon = record.mse = NAN;
    vor_record_unknown_best(&record);
    record.seconds = vor_run_seconds(align->run);
    if (align->steps > 0 && align->count > 0)
        record.mse = vor_power(align->fit[0].rms * align->samples[1].unit, 2);
    return vor_run_tell(align->run, &record) == VOR_CANCEL ? vor_run_answered(VOR_CANCEL, err)
                                                           : VOR_OK;
}

/* Refines all poses by one sample of `every`, and keeps so many of the best. */
static vor_status run_step(struct align *align, vor_row_task task, unsigned every, unsigned most,
                           const struct vor_run *run, struct vor_error *err)
{
    vor_status status;

    align->of.every = every;
    status = vor_run_rows(run, align->count, 1, task, align, err);
    if (status != VOR_OK)
        return status;
    keep_best(align, most);
    align->steps++;
    return tell_step(align, err);
}

/* Narrows what counts as lying on the other cloud to VOR_SURE medians of what the good poses have.
 */
static void narrow(struct align *align)
{
    double gap = align->samples[1].gap, within = align->within;

    for (unsigned i = 0; i < align->count; i++)
        if (2 * align->fit[i].score > align->fit[0].score)
            within = fmin(within, VOR_SURE * align->fit[i].median);
    align->within = fmax(within, WITHIN_LEAST * gap);
}

/* How much a pose speaks against the best one, 0 to 1: as far as as little speaks against it, even
 * if it overlaps by half of it. Halves of a body that is nearly its own image when it is turned lie
 * on each other wholly in a wrong pose, and by half in the right one. */
static double rival(const struct vor_align_fit *fit, const struct vor_align_fit *best)
{
    if (!(best->score > 0))
        return 1;
    return fmin(1, plausible(fit) / plausible(best) * fmin(1, 2 * fit->on / best->on));
}

/* Makes the second one the pose that speaks most against the first. */
static void choose_runner_up(struct align *align)
{
    struct vor_align_fit *fit = align->fit;
    unsigned most = 1;

    for (unsigned i = 2; i < align->count; i++)
        if (rival(&fit[i], fit) > rival(&fit[most], fit))
            most = i;
    if (align->count > 1 && most != 1) {
        struct vor_align_fit second = fit[1];

        fit[1] = fit[most];
        fit[most] = second;
    }
}

/* Finds the best poses: the first fits, the best one and the runner-up before all others. */
static vor_status find_poses(struct align *align, const struct vor_run *run, struct vor_error *err)
{
    struct vor_align_samples *samples = align->samples;
    int both = !(samples[0].carried && samples[1].carried);
    vor_status status = vor_align_grid_make(&align->grid, &samples[1],
                                            fmax(samples[0].apart, samples[1].apart), err);

    if (status == VOR_OK)
        status = tell_step(align, err);
    if (status == VOR_OK)
        status = vor_align_match(align->candidate, &align->count, &samples[0], &align->grid, both,
                                 run, err);
    align->within = samples[1].gap;
    if (status == VOR_OK)
        status = run_step(align, refine_few, 4, MIDDLING, run, err);
    align->within /= 2;
    if (status == VOR_OK)
        status = run_step(align, refine, 3, LAST, run, err);
    if (status == VOR_OK)
        status = run_step(align, refine, 1, LAST, run, err);
    narrow(align);
    if (status == VOR_OK)
        status = run_step(align, settle, 1, LAST, run, err);
    choose_runner_up(align);
    return status;
}

/* The pose between the clouds' own coordinates. */
static struct vor_pose whole_pose(const struct align *align, const struct vor_pose *pose)
{
    const struct vor_align_samples *samples = align->samples;
    struct vor_pose out = *pose;
    double moved[3];

    out.scale = pose->scale * samples[1].unit / samples[0].unit;
    vor_pose_turn(pose, samples[0].middle, moved);
    for (int c = 0; c < 3; c++)
        out.shift[c] =
            samples[1].middle[c] + samples[1].unit * pose->shift[c] - out.scale * moved[c];
    return out;
}

static void set_matrix(double out[16], const struct vor_pose *pose)
{
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            out[4 * r + c] = pose->scale * pose->turn[r][c];
        out[4 * r + 3] = pose->shift[r];
        out[12 + r] = 0;
    }
    out[15] = 1;
}

/* Sets trust to the least of what speaks for the pose, each a half where it is at its limit, and
 * the reason to the least one if that is below. */
static void set_trust(struct vor_report *report, const struct align *align)
{
    const struct vor_align_fit *fit = &align->fit[0];
    double margin = 1 - (align->count > 1 ? rival(&align->fit[1], fit) : 0);
    double overlap = fmax(fit->overlap[0], fit->overlap[1]);
    double held = fmin(fit->slide, fit->turn), hover = fit->hover / HOVER;
    const struct {
        enum vor_doubt doubt;
        double trust;
    } parts[] = {{VOR_DOUBT_SLIDE, fit->slide / (fit->slide + FIRM)},
                 {VOR_DOUBT_TURN, fit->turn / (fit->turn + FIRM)},
                 {VOR_DOUBT_SCALE, align->of.scales ? fit->grow / (fit->grow + FIRM) : 1},
                 {VOR_DOUBT_CONFLICT, held / (held + FIRM) / (1 + hover * hover)},
                 {VOR_DOUBT_CONFLICT, 1 / (1 + vor_power(fit->loose / LOOSE, 4))},
                 {VOR_DOUBT_CONFLICT, 1 / (1 + vor_power(fit->beside / BESIDE, 4))},
                 {VOR_DOUBT_OVERLAP, overlap / (overlap + OVERLAP)},
                 {VOR_DOUBT_POSE, margin / (margin + LEAD)}};

    report->pose_trust = 1;
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
        if (parts[i].trust < report->pose_trust) {
            report->pose_trust = fmax(parts[i].trust, 0);
            report->pose_doubt = parts[i].doubt;
            /* Poses beside a free motion fit as well as the best: the motion says more. */
            if (i < 3 && parts[i].trust < 0.5)
                break;
        }
    if (report->pose_trust >= 0.5)
        report->pose_doubt = VOR_DOUBT_NONE;
    if (report->pose_doubt == VOR_DOUBT_SLIDE)
        memcpy(report->pose_axis, fit->slides, sizeof fit->slides);
    if (report->pose_doubt == VOR_DOUBT_TURN)
        memcpy(report->pose_axis, fit->turns, sizeof fit->turns);
}

/* Lowers trust where halves of the samples, or the reference laid on the cloud, lead to other
 * poses: sparse samples lie on planes of others in many poses near each other, of which each looks
 * as good as the right one. */
static vor_status repeat(struct vor_report *report, struct align *align, const struct vor_run *run,
                         struct vor_error *err)
{
    const struct vor_align_fit *again = align->again;
    double d2, trust;
    vor_status status;

    if (report->pose_trust < 0.5)
        return VOR_OK;
    status = vor_run_rows(run, 3, 1, refine_again, align, err);
    if (status != VOR_OK)
        return status;
    d2 = fmax(vor_pose_apart2(&again[0].pose, &again[1].pose) / 4,
              vor_pose_apart2(&again[2].pose, &align->fit[0].pose));
    trust = 1 / (1 + d2 / (REPEATED * REPEATED));
    report->pose_trust = fmin(report->pose_trust, trust);
    if (trust < 0.5)
        report->pose_doubt = VOR_DOUBT_IMPRECISE;
    return VOR_OK;
}

static void tell(struct vor_report *report, const struct align *align, const struct vor_pose *pose)
{
    const struct vor_align_fit *fit = &align->fit[0];

    report->has_pose = 1;
    set_matrix(report->transform, pose);
    report->pose_scale = pose->scale;
    report->pose_rms = fit->rms * align->samples[1].unit;
    report->pose_mse = report->pose_rms * report->pose_rms;
    report->pose_overlap = fit->overlap[0];
    report->pose_covered = fit->overlap[1];
    report->pose_conflict = fit->hover;
    report->pose_score = fit->score;
    report->spacing_mean *= pose->scale;
    report->sigma *= pose->scale;
    if (align->count > 1) {
        struct vor_pose other = whole_pose(align, &align->fit[1].pose);

        set_matrix(report->runner_up.transform, &other);
        report->runner_up.score = align->fit[1].score;
    }
    set_trust(report, align);
}

/* Sets a scalar of a signed type: whole numbers are rounded, and end where the type does. */
static void set_scalar(const struct vor_attribute *attribute, size_t at, double value)
{
    double most = ldexp(1, (int)(8 * vor_type_size(attribute->type)) - 1) - 1;
    double whole = fmax(-most, fmin(most, rint(value)));

    switch (attribute->type) {
    case VOR_FLOAT32:
        ((float *)attribute->data)[at] = (float)value;
        break;
    case VOR_FLOAT64:
        ((double *)attribute->data)[at] = value;
        break;
    case VOR_INT8:
        ((int8_t *)attribute->data)[at] = (int8_t)whole;
        break;
    case VOR_INT16:
        ((int16_t *)attribute->data)[at] = (int16_t)whole;
        break;
    case VOR_INT32:
        ((int32_t *)attribute->data)[at] = (int32_t)whole;
        break;
    default: /* no direction can be told from these */
        break;
    }
}

static void turn_normals(struct vor_cloud *cloud, const struct vor_pose *pose)
{
    for (size_t k = 0; k < cloud->attribute_count; k++) {
        struct vor_attribute *attribute = &cloud->attributes[k];

        if (attribute->semantic != VOR_NORMAL || attribute->components != 3)
            continue;
        for (size_t i = 0; i < cloud->n; i++) {
            double normal[3], turned[3];

            for (size_t c = 0; c < 3; c++)
                normal[c] = vor_attribute_scalar(attribute, 3 * i + c);
            vor_pose_turn(pose, normal, turned);
            for (size_t c = 0; c < 3; c++)
                set_scalar(attribute, 3 * i + c, turned[c]);
        }
    }
}

/* Moves all points. They stay float32 where both clouds are. */
static vor_status move(struct vor_cloud *cloud, const struct vor_cloud *reference,
                       const struct vor_pose *pose, struct vor_error *err)
{
    int single = cloud->position_type == VOR_FLOAT32 && reference->position_type == VOR_FLOAT32;
    double *moved = vor_malloc(cloud->memory, cloud->n, 3 * sizeof *moved);
    vor_status status = VOR_OK;

    if (moved == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", cloud->n);
    for (size_t i = 0; i < cloud->n; i++) {
        double x[3];

        vor_cloud_position(cloud, i, x);
        vor_pose_move(pose, x, &moved[3 * i]);
    }
    if (single) {
        memset(cloud->origin, 0, sizeof cloud->origin);
        for (size_t i = 0; i < 3 * cloud->n; i++)
            cloud->xyz[i] = (float)moved[i];
    } else {
        status = vor_cloud_set_double(cloud, moved, err);
    }
    vor_free(cloud->memory, moved);
    if (status != VOR_OK)
        return status;
    vor_free(cloud->memory, cloud->exact);
    cloud->exact = NULL;
    turn_normals(cloud, pose);
    return vor_cloud_check(cloud, err);
}

vor_status vor_align_cloud(struct vor_cloud *cloud, struct vor_report *report,
                           const struct vor_cloud *reference, const struct vor_spec *spec,
                           const struct vor_run *run, struct vor_error *err)
{
    const struct vor_cloud *const both[2] = {cloud, reference};
    const struct vor_run whole = vor_run_unstoppable(run);
    int scales = spec->value[VOR_PARAM_SCALE] == VOR_SCALE_FREE;
    double overlap = spec->value[VOR_PARAM_OVERLAP];
    double before = vor_run_clock(run);
    struct align *align;
    vor_status status = vor_splats_check(cloud, spec, err);

    if (status != VOR_OK)
        return vor_fail_param(err, status, "cloud",
                              "the cloud is a 3D Gaussian splat; moving the points would make its "
                              "scales and rotations wrong");
    align = vor_calloc(run->memory, 1, sizeof *align);
    if (align == NULL)
        return vor_fail(err, VOR_E_NOMEM, "poses");
    align->run = run;
    align->of = (struct vor_align_fit_of){.cloud = &align->samples[0],
                                          .reference = &align->samples[1],
                                          .grid = &align->grid,
                                          .scales = scales,
                                          .overlap = overlap == VOR_UNSET ? 0 : overlap};
    status = vor_align_samples_make(align->samples, both, !scales, &whole, err);
    for (int k = 0; status == VOR_OK && k < 2; k++) {
        status = vor_align_points_make(&align->points[k], both[k], &align->samples[k], &whole, err);
        align->of.points[k] = &align->points[k];
    }
    if (status == VOR_OK)
        status = find_poses(align, &whole, err);
    if (status == VOR_OK && align->count == 0)
        align->fit[align->count++].pose = (struct vor_pose){
            .turn = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .scale = 1}; /* onto the middle */
    if (status == VOR_OK) {
        struct vor_pose pose = whole_pose(align, &align->fit[0].pose);

        status = move(cloud, reference, &pose, err);
        if (status == VOR_OK)
            tell(report, align, &pose);
        if (status == VOR_OK)
            status = repeat(report, align, &whole, err);
        vor_report_stage(report, VOR_RUN_STAGE_ALIGN, align->steps, vor_run_clock(run) - before);
    }
    vor_align_grid_free(&align->grid);
    for (int k = 0; k < 2; k++) {
        vor_align_samples_free(&align->samples[k]);
        vor_align_points_free(&align->points[k]);
    }
    vor_free(run->memory, align);
    return status;
}
