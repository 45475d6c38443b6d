#include "server/jobs/memory_estimate.h"

#include "core/cloud/faces.h"
#include "server/base/machine.h"

#include <math.h>

/* Bytes a point, as core/engine.h has them where it has them; the others measured on spheres and
 * noise of 1,000 to 200,000 points to 1,000 to 100,000, each beside what was found. */
#define INDEX 51.0     /* of the input: cloud, positions, order, index; 46 to 67 */
#define SHEETS 122.0   /* of the input, thinned, where it may have two sheets: 0 or 122 */
#define SURFACES 192.0 /* likewise, of an input that is SMALL */
#define SMALL 2048.0
#define TENSORS 265.0 /* of the input, while its metric is found: 263 */
/* Of the input, what inspect takes beside the index: 245 to 335 of models and scans of 2,900 to
 * 40,000 points, 370 to 640 with noise of .005 of the diagonal. */
#define INSPECT 640.0
#define CONVERT 24.0  /* of the input, what convert takes: 24; restore that and the index */
#define REGISTER 24.0 /* of each input, what register takes beside convert: 24 */
#define SAMPLES 7e6   /* whatever the input, what register takes for samples and poses: 6e6 */
#define PREVIOUS 65.0 /* of an earlier result, while points start from it: 53 to 65 */
#define DOUBLES                                                                                    \
    24.0            /* of the input, where it may be doubles that are kept: convert 24 beside what \
                       attributes are reckoned with, denoise 36 */
#define START 393.0 /* of the result and 6 a neighbour, twice where it begins from cells */
#define ITERATE 502.0   /* likewise, once */
#define DENSITY 50.0    /* of the result, with a density: 51 */
#define METRIC 268.0    /* of the result, with a metric: 268 */
#define DESCEND 1060.0  /* of the result, where an energy is minimised */
#define KMEANS 600.0    /* of the result, by that method: 596 */
#define REMESH 300.0    /* of the result, beside its iterations, by isotropic: 294 */
#define BASELINES 170.0 /* of the result: 168 */
/* Of the input, while wlop and ear measure its area, and ear finds its normals; and of the result
 * and 6 a neighbour, in the end. Found on 3,000 to 30,000 points of igea and, with noise, of
 * fandisk: 310 to 570 of wlop, 350 to 680 of ear; 540 to 640. At 30,000 with noise fits take more
 * neighbours than are reckoned with: 720, 890. */
#define WLOP_IN 450.0
#define EAR_IN 470.0
#define PROJECTED 542.0
#define SAMPLED 0.5 /* of the input's points, those that ear projects */

/* Bytes whatever the points: some, and those of each thread's scratch. */
#define ANY_RUN (1 << 18)
#define A_THREAD (200 << 10)

/* An input of so many points for each of the result is thinned, and starts from no cells. */
#define DENSE 10.0

static int has_metric(const struct vor_spec *spec)
{
    return spec->value[VOR_PARAM_METRIC] != VOR_METRIC_ISOTROPIC;
}

/* Points that begin evenly by area, of out in the end. */
static double starting(const struct vor_spec *spec, double in, double out)
{
    double phases = spec->value[VOR_PARAM_PHASES], samples = spec->value[VOR_PARAM_SAMPLES];

    if (spec->value[VOR_PARAM_METHOD] != VOR_METHOD_EAR || phases == VOR_PHASES_RESAMPLE)
        return out;
    if (phases == VOR_PHASES_INSERT)
        return 0; /* others are inserted between the input's own */
    return fmin(samples > 0 ? samples : SAMPLED * in, out);
}

/* Of all points of the result, beside the input's index and lists. */
static double spreading(const struct vor_spec *spec, double in, double out,
                        enum vor_fit_neighbors neighbors)
{
    double given =
        spec->value[VOR_PARAM_NEIGHBORS]; /* then, of each point, besides its neighbours */
    double extra = (has_metric(spec) ? METRIC : 0) +
                   (spec->value[VOR_PARAM_DENSITY] != VOR_DENSITY_UNIFORM ? DENSITY : 0);
    double lists = 6 * (given > 0 ? given : (double)neighbors);
    double first = starting(spec, in, out);
    double cells = in >= DENSE * first ? first : first + fmin(in, first);
    double start = (lists + START + extra) * cells;
    double iterate = (lists + ITERATE + extra) * out;

    if (spec->value[VOR_PARAM_METHOD] == VOR_METHOD_KMEANS)
        return KMEANS * out;
    if (spec->value[VOR_PARAM_METHOD] == VOR_METHOD_WLOP)
        return fmax(fmax((WLOP_IN - INDEX) * in, start), (lists + PROJECTED) * out);
    if (spec->value[VOR_PARAM_METHOD] == VOR_METHOD_EAR)
        return fmax(fmax((EAR_IN - INDEX) * in, start), (lists + PROJECTED) * out);
    if (spec->value[VOR_PARAM_METHOD] == VOR_METHOD_ISOTROPIC)
        iterate += REMESH * out;
    if (vor_spec_descends(spec))
        iterate += DESCEND * out;
    if (spec->value[VOR_PARAM_BASELINES] > 0)
        start += BASELINES * out;
    return fmax(start, iterate);
}

/* Of a process with a method. */
static double of_spread(const struct vor_spec *spec, double points, double attributes,
                        enum vor_fit_neighbors neighbors)
{
    double out = vor_spec_only_filters(spec) ? 0 : vor_spec_target(spec, (uint64_t)points);
    double in = points, index, tensors;

    if (!(out >= 0))
        out = points;
    if (spec->value[VOR_PARAM_SAMPLE] == VOR_SAMPLE_FACES)
        in = (double)vor_faces_samples(out, (size_t)points);
    index = (INDEX + attributes) * in;
    if (spec->value[VOR_PARAM_INTRINSIC] != VOR_INTRINSIC_NONE)
        index += SHEETS * (out > 0 ? fmin(in, DENSE * out) : in) + SURFACES * (in > SMALL ? 0 : in);
    tensors = has_metric(spec) ? TENSORS * in : 0;
    return index + attributes * out + fmax(tensors, spreading(spec, in, out, neighbors));
}

uint64_t vor_memory_estimate(const struct vor_spec *spec, unsigned inputs,
                             const struct vor_job_input input[VOR_INPUTS_MAX],
                             enum vor_fit_neighbors neighbors)
{
    double bytes = ANY_RUN + (double)A_THREAD * vor_machine_cores();

    for (unsigned i = 0; spec->process->inputs[i].name != NULL; i++) {
        double points = (double)input[i].points;
        /* Attributes are as wide as the upload had them; in Draco's, which is compressed, that
         * cannot be seen. A number in text is taken for as much as it takes there. */
        double each = points > 0 ? (double)input[i].bytes / points : 0;
        double attributes = fmax(each - 3 * sizeof(float), 0);

        if ((inputs >> i & 1) == 0)
            continue;
        if (vor_spec_keeps_points(spec) && attributes >= 3 * (sizeof(double) - sizeof(float)))
            bytes += DOUBLES * points;
        if (spec->process->methods != 0 && i > 0)
            bytes += (PREVIOUS + attributes) * points;
        else if (spec->process->methods != 0)
            bytes += of_spread(spec, points, attributes, neighbors);
        else if (vor_process_takes(spec->process, VOR_PARAM_OUTLIERS))
            bytes += (INDEX + INSPECT + attributes) * points;
        else if (vor_process_takes(spec->process, VOR_PARAM_FORMAT))
            bytes += (CONVERT + 2 * attributes) * points;
        else
            bytes += (INDEX + SHEETS + attributes) * points;
        if (spec->process == vor_process_find("restore"))
            bytes += INDEX * points;
        if (spec->process == vor_process_find("register"))
            bytes += REGISTER * points + SAMPLES / 2;
    }
    return (uint64_t)fmin(bytes, 9e18);
}
