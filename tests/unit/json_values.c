/* The values the product speaks: their exact shape. */
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static struct vor_text text;

static void expect(const char *wanted)
{
    vt_assert_ok(vor_text_status(&text, &vt_err));
    ck_assert_str_eq(text.data, wanted);
    vt_assert_ok(vor_json_scan(text.data, text.size, &vt_err));
    vor_text_free(&text);
}

static struct vor_json *parsed(const char *json)
{
    struct vor_json *out = NULL;

    vt_assert_ok(vor_json_parse(&out, json, strlen(json), &vt_err));
    return out;
}

static const struct vor_record record = {.iteration = 37,
                                         .polish = 30,
                                         .delta = 0.0813,
                                         .sigma = 0.000211,
                                         .epsilon = 0.9967,
                                         .energy = 1.9e-5,
                                         .max_move = 0.5,
                                         .held = 2,
                                         .seconds = 1.25,
                                         .stage = VOR_RUN_STAGE_POLISH,
                                         .step = 30,
                                         .of = 100,
                                         .ahead = 5,
                                         .best_iteration = 36,
                                         .best_polish = 20,
                                         .best_delta = 0.08,
                                         .best_sigma = 0.0002,
                                         .best_epsilon = 0.9968};

#define RECORD                                                                                     \
    "{\"iteration\":37,\"polish\":30,\"delta\":0.0813,\"sigma\":0.000211,\"epsilon\":0.9967,"      \
    "\"energy\":1.9e-05,\"max_move\":0.5,\"held\":2,\"seconds\":1.25,\"run_stage\":\"polish\","    \
    "\"step\":30,\"of\":100,\"ahead\":5,\"best\":{\"iteration\":36,\"polish\":20,"                 \
    "\"delta\":0.08,\"sigma\":0.0002,\"epsilon\":0.9968}}"

START_TEST(a_record_has_its_shape)
{
    vor_text_init(&text, 0);
    vor_json_record(&text, &record);
    expect(RECORD);
}
END_TEST

START_TEST(a_record_comes_back)
{
    struct vor_json *json = parsed(RECORD);
    struct vor_record back;

    ck_assert(vor_json_record_read(&back, json));
    ck_assert_mem_eq(&back, &record, sizeof record);
    vor_json_free(json);
    json = parsed("{\"delta\":1}");
    ck_assert(!vor_json_record_read(&back, json));
    vor_json_free(json);
    json = parsed("{\"iteration\":-1,\"polish\":4294967296,\"held\":1e300,\"delta\":null}");
    ck_assert(vor_json_record_read(&back, json));
    ck_assert(back.iteration == 0 && back.polish == 0 && back.held == 0 && isnan(back.delta));
    vor_json_free(json);
}
END_TEST

START_TEST(a_stage_of_another_build_is_none_of_ours)
{
    struct vor_json *json =
        parsed("{\"iteration\":0,\"run_stage\":\"melt\",\"step\":3,\"of\":7,\"ahead\":9}");
    struct vor_record back;

    ck_assert(vor_json_record_read(&back, json));
    ck_assert_uint_eq(back.stage, VOR_RUN_STAGE_COUNT);
    ck_assert(back.step == 3 && back.of == 7 && back.ahead == 9);
    vor_json_free(json);
    vor_text_init(&text, 0);
    vor_json_record(&text, &back);
    ck_assert_ptr_nonnull(strstr(text.data, "\"run_stage\":null"));
    vor_text_free(&text);
}
END_TEST

START_TEST(a_report_has_its_shape)
{
    struct vor_report report = {
        .points_in = 35947,
        .points_out = 5000,
        .delta = 0.07,
        .sigma = 0.001,
        .epsilon = 0.99,
        .iterations = 50,
        .polish_steps = 40,
        .stopped = VOR_STOPPED_ITERATIONS,
        .stages = {{VOR_RUN_STAGE_ITERATE, 50, 4}, {VOR_RUN_STAGE_POLISH, 40, 4.5}},
        .stages_count = 2,
        .seconds_read = 1,
        .seconds_index = 2,
        .seconds_init = 3,
        .seconds_iterate = 4,
        .seconds_polish = 4.5,
        .seconds_write = 5,
        .memory_peak_bytes = 123456789,
        .held = 6,
        .held_ever = 7,
        .outliers = 5,
        .parts = 6,
        .islands = 4,
        .in_islands = 43,
        .on_islands = 8,
        .delta_beside = 0.0625,
        .lattice = {0.5, 0.25, 0},
        .off_lattice = 12,
        .orientation = VOR_ORIENTED_ONE_SIDED,
        .one_sided = 3,
        .warnings = {{VOR_WARNING_ONE_SIDED, 3, 0, VOR_WARNING_ONE_SIDED}},
        .warnings_count = 1,
        .in_to_out = {0.125, 0.25, 0.375, 35000},
        .out_to_in = {0.5, 0.625, 0.75, 5000},
        .boundary_points = 13,
        .fitted = {{12, 700}, {20, 4300}},
        .fitted_count = 2,
        .fallback_plane = 8,
        .fallback_left = 9,
        .area = 10.5,
        .spacing_mean = 0.25,
        .min_over_mean = 0.75,
        .max_over_mean = 1.25,
        .six_share = 0.875,
        .bisectors_per_cell = 6.5,
        .triangles_per_cell = 24.5,
        .queries = 10000000000,
        .list_rebuilds = 11,
        .origin = {637000, -0.5, 0}};
    struct vor_document document = {"report", &vor_report_members, &report};

    vor_spec_init(&report.parameters);
    vt_assert_ok(vor_spec_set(&report.parameters, "points", "5000", &vt_err));
    vt_assert_ok(vor_spec_set(&report.parameters, "polish", "60", &vt_err));
    vor_text_init(&text, 0);
    vor_json_document(&text, &document);
    expect(
        "{\"points\":{\"in\":35947,\"out\":5000},\"delta\":0.07,\"sigma\":0.001,"
        "\"epsilon\":0.99,\"iterations\":50,\"polish_steps\":40,\"stopped\":\"iterations\","
        "\"warnings\":[{\"about\":\"orientation\",\"value\":3,\"limit\":0,\"says\":\"Connected "
        "parts of the input have one side only: no signs of their normals are consistent\"}],"
        "\"stages\":[{\"stage\":\"iterate\",\"steps\":50,\"seconds\":4},"
        "{\"stage\":\"polish\",\"steps\":40,\"seconds\":4.5}],"
        "\"seconds\":{\"read\":1,\"index\":2,\"init\":3,\"iterate\":4,\"polish\":4.5,\"write\":5},"
        "\"memory_peak_bytes\":123456789,\"invalid\":0,\"faces\":0,"
        "\"samples\":0,\"dropped\":[],"
        "\"outliers\":5,\"components\":6,\"islands\":{\"components\":4,\"points_in\":43,"
        "\"points_out\":8,\"delta_beside\":0.0625},\"lattice\":{\"x\":0.5,\"y\":0.25,\"z\":0,"
        "\"moved\":12},\"orientation\":\"one-sided\",\"one_sided\":3,\"in_to_out\":{"
        "\"mean\":0.125,\"rms\":0.25,\"max\":0.375,\"points\":35000},\"out_to_in\":{\"mean\":0.5,"
        "\"rms\":0.625,\"max\":0.75,\"points\":5000},\"boundary_points\":13,\"neighbors_"
        "histogram\":[{\"neighbors\":12,\"points\":700},{\"neighbors\":20,\"points\":4300}],"
        "\"held\":6,\"held_ever\":7,\"fallbacks\":{\"plane\":8,\"left\":9},\"area\":"
        "10.5,"
        "\"spacing\":0.25,\"min_over_mean\":0.75,\"max_over_mean\":1.25,\"six_share\":0.875,"
        "\"bisectors_per_cell\":6.5,\"triangles_per_cell\":24.5,\"queries\":10000000000,"
        "\"list_rebuilds\":11,\"origin\":{\"x\":637000,\"y\":-0.5,\"z\":0},\"parameters\":{"
        "\"points\":5000,\"method\":\"cvt\",\"patch\":"
        "\"quadric\",\"density\":\"uniform\",\"contrast\":4,\"grading\":0.2,\"metric\":"
        "\"isotropic\",\"maxAspect\":6,\"p\":8,\"cells\":\"metric\",\"neighbors\":\"auto\","
        "\"polish\":60,\"sigmaN\":15,\"sigmaP\":\"auto\",\"mu\":0.45,\"rounds\":3,"
        "\"rho\":5,\"phases\":\"both\",\"samples\":\"auto\",\"gaps\":\"keep\","
        "\"boundary\":\"keep\",\"holes\":\"auto\",\"holeMax\":\"auto\",\"edges\":"
        "\"ignore\",\"outliers\":"
        "\"keep\",\"sample\":\"vertices\",\"filters\":[],\"inputNormals\":\"auto\",\"intrinsic\":"
        "\"local\",\"invalid\":"
        "\"refuse\","
        "\"seed\":1,\"order\":\"spatial\",\"quantization\":\"auto\",\"compression\":7,\"origin\":"
        "\"auto\","
        "\"attributes\":\"nearest\","
        "\"normals\":\"nearest\",\"baselines\":false}}");
}
END_TEST

START_TEST(a_measure_is_written_in_this_shape)
{
    struct vor_measure measure = {.n = 3,
                                  .delta = 0.1,
                                  .sigma = 0.2,
                                  .epsilon = 0.3,
                                  .mean_nn = 0.4,
                                  .min_over_mean = 0.5,
                                  .max_over_mean = 0.6,
                                  .coincident = 2,
                                  .far_over_knn6_mean = 1,
                                  .far_over_knn6_p999 = 2,
                                  .out_to_ref_mean = 3,
                                  .out_to_ref_max = 4,
                                  .ref_to_out_mean = 5,
                                  .ref_to_out_max = 6,
                                  .out_to_ref_rms = 7,
                                  .ref_to_out_rms = 8,
                                  .hausdorff = 9,
                                  .chamfer = 10,
                                  .d1_mse = 11,
                                  .d1_psnr = 12,
                                  .d2_mse = 13,
                                  .d2_psnr = (double)INFINITY,
                                  .peak = 15};
    struct vor_document document = {"measure", &vor_measure_members, &measure};

    vor_text_init(&text, 0);
    vor_json_document(&text, &document);
    expect("{\"n\":3,\"delta\":0.1,\"sigma\":0.2,\"epsilon\":0.3,\"mean_nn\":0.4,"
           "\"min_over_mean\":0.5,\"max_over_mean\":0.6,\"invalid\":0,\"coincident\":2}");
    measure.has_reference = 1;
    vor_text_init(&text, 0);
    vor_json_document(&text, &document);
    expect("{\"n\":3,\"delta\":0.1,\"sigma\":0.2,\"epsilon\":0.3,\"mean_nn\":0.4,"
           "\"min_over_mean\":0.5,\"max_over_mean\":0.6,\"invalid\":0,\"coincident\":2,\"input\":{"
           "\"far_over_knn6_mean\":1,\"far_over_knn6_p999\":2,\"out_to_ref_mean\":3,"
           "\"out_to_ref_rms\":7,\"out_to_ref_max\":4,\"ref_to_out_mean\":5,"
           "\"ref_to_out_rms\":8,\"ref_to_out_max\":6,\"hausdorff\":9,\"chamfer\":10,"
           "\"d1_mse\":11,\"d1_psnr\":12,\"d2_mse\":13,\"d2_psnr\":null,\"peak\":15}}");
}
END_TEST

START_TEST(a_problem_has_its_shape)
{
    static const struct vor_problem_error errors[] = {
        {"/inputs/points", NULL, "is 0"},
        {NULL, "seed", "is \"x\""},
    };
    struct vor_problem_doc problem = VOR_PROBLEM_DOC_INIT;

    problem.type = "http://h/problems/invalid-parameter";
    problem.title = "A parameter is invalid";
    problem.status = 400;
    vor_text_init(&text, 0);
    vor_json_problem(&text, &problem);
    expect("{\"type\":\"http://h/problems/invalid-parameter\",\"title\":\"A parameter is invalid\","
           "\"status\":400,\"retryable\":false}");
    problem.detail = "d";
    problem.instance = "/v1/jobs/1";
    problem.retryable = 1;
    problem.request_id = "r";
    problem.job_id = "j";
    problem.errors = errors;
    problem.error_count = 2;
    problem.has_limit = 1;
    problem.got = 5;
    problem.byte_offset = 0;
    problem.queue_depth = 256;
    problem.attempt = 2;
    vor_text_init(&text, 0);
    vor_json_problem(&text, &problem);
    expect("{\"type\":\"http://h/problems/invalid-parameter\",\"title\":\"A parameter is invalid\","
           "\"status\":400,\"detail\":\"d\",\"instance\":\"/v1/jobs/1\",\"retryable\":true,"
           "\"requestId\":\"r\",\"jobID\":\"j\",\"attempt\":2,\"limit\":0,\"got\":5,"
           "\"byteOffset\":0,\"queueDepth\":256,\"errors\":[{\"pointer\":\"/inputs/points\","
           "\"detail\":\"is 0\"},{\"parameter\":\"seed\",\"detail\":\"is \\\"x\\\"\"}]}");
}
END_TEST

START_TEST(a_status_has_its_shape)
{
    static const struct vor_link links[] = {
        {"self", "application/json", NULL, "http://h/v1/jobs/1", -1},
        {"item", "application/ply", "cloud", "http://h/v1/jobs/1/results/cloud", 60},
    };
    static const struct vor_input_info inputs[] = {{"cloud", "draco", 2, 3, "ab"},
                                                   {"reference", "ply", 5, 7, NULL}};
    struct vor_status_info info = VOR_STATUS_INFO_INIT;
    struct vor_problem_doc problem = VOR_PROBLEM_DOC_INIT;

    info.job_id = "1";
    info.process_id = "resample";
    info.status = "accepted";
    info.created = "2026-11-21T03:15:34.537Z";
    info.finished = "";
    vor_text_init(&text, 0);
    vor_json_status_info(&text, &info);
    expect("{\"jobID\":\"1\",\"id\":\"1\",\"type\":\"process\",\"processID\":\"resample\","
           "\"status\":\"accepted\",\"created\":\"2026-11-21T03:15:34.537Z\",\"voronoid\":{"
           "\"attempt\":0,\"stage\":null,\"queuePosition\":null,\"eta\":null,\"metrics\":null},"
           "\"links\":[]}");
    problem.status = 500;
    info.status = "failed";
    info.message = "m";
    info.progress = 0;
    info.started = info.updated = info.finished = info.created;
    info.attempt = 1;
    info.stage = "optimize";
    info.queue_position = 0;
    info.eta = 9.5;
    info.inputs = inputs;
    info.input_count = 1;
    info.target_points = 4;
    info.target_format = "ply";
    info.metrics = &record;
    info.exception = &problem;
    info.links = links;
    info.link_count = 2;
    vor_text_init(&text, 0);
    vor_json_status_info(&text, &info);
    expect("{\"jobID\":\"1\",\"id\":\"1\",\"type\":\"process\",\"processID\":\"resample\","
           "\"status\":\"failed\",\"message\":\"m\",\"progress\":0,"
           "\"created\":\"2026-11-21T03:15:34.537Z\",\"started\":\"2026-11-21T03:15:34.537Z\","
           "\"updated\":\"2026-11-21T03:15:34.537Z\",\"finished\":\"2026-11-21T03:15:34.537Z\","
           "\"voronoid\":{\"attempt\":1,\"stage\":\"optimize\",\"queuePosition\":0,\"eta\":9.5,"
           "\"input\":{\"format\":\"draco\",\"points\":2,\"bytes\":3,\"sha256\":\"ab\"},"
           "\"target\":{\"points\":4,\"format\":\"ply\"},\"metrics\":" RECORD "},"
           "\"exception\":{\"status\":500,\"retryable\":false},"
           "\"links\":[{\"rel\":\"self\",\"type\":\"application/json\","
           "\"href\":\"http://h/v1/jobs/1\"},{\"rel\":\"item\",\"type\":\"application/ply\","
           "\"title\":\"cloud\",\"href\":\"http://h/v1/jobs/1/results/cloud\",\"length\":60}]}");
    info.exception_json = "{\"x\":1}";
    info.input_count = 2;
    vor_text_init(&text, 0);
    vor_json_status_info(&text, &info);
    ck_assert_ptr_nonnull(strstr(text.data, "\"exception\":{\"x\":1},\"links\""));
    ck_assert_ptr_nonnull(strstr(
        text.data, "\"input\":{\"format\":\"draco\",\"points\":2,\"bytes\":3,\"sha256\":\"ab\"},"
                   "\"inputs\":{\"cloud\":{\"format\":\"draco\",\"points\":2,\"bytes\":3,"
                   "\"sha256\":\"ab\"},\"reference\":{\"format\":\"ply\",\"points\":5,"
                   "\"bytes\":7}},\"target\""));
    vor_text_free(&text);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("json_values");

    vt_add(suite, a_record_has_its_shape);
    vt_add(suite, a_record_comes_back);
    vt_add(suite, a_stage_of_another_build_is_none_of_ours);
    vt_add(suite, a_report_has_its_shape);
    vt_add(suite, a_measure_is_written_in_this_shape);
    vt_add(suite, a_problem_has_its_shape);
    vt_add(suite, a_status_has_its_shape);
    return vt_run(suite);
}
