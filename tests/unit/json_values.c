/* The values the product speaks: their exact shape. */
#include "proto/json/json.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

static struct vor_text text;

static void expect(const char *wanted)
{
    vt_assert_ok(vor_text_status(&text, &vt_err));
    ck_assert_str_eq(text.data, wanted);
    vt_assert_ok(vor_json_scan(text.data, text.size, &vt_err));
    vor_text_free(&text);
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
                                         .best_epsilon = 0.9968,
                                         .quality = 0.93,
                                         .angle = 51.5,
                                         .mse = 0.25};

#define RECORD                                                                                     \
    "{\"iteration\":37,\"polish\":30,\"delta\":0.0813,\"sigma\":0.000211,\"epsilon\":0.9967,"      \
    "\"energy\":1.9e-05,\"max_move\":0.5,\"held\":2,\"seconds\":1.25,\"run_stage\":\"polish\","    \
    "\"step\":30,\"of\":100,\"ahead\":5,\"best\":{\"iteration\":36,\"polish\":20,"                 \
    "\"delta\":0.08,\"sigma\":0.0002,\"epsilon\":0.9968},\"quality\":0.93,\"angle\":51.5,\"mse\":" \
    "0.25}"

VT_TEST(a_record_has_its_shape)
{
    vor_text_init(&text, 0);
    vor_json_record(&text, &record);
    expect(RECORD);
}

VT_TEST(a_record_comes_back)
{
    struct vor_json *json = vt_json(RECORD);
    struct vor_record back;

    ck_assert(vor_json_record_read(&back, json));
    ck_assert_mem_eq(&back, &record, sizeof record);
    vor_json_free(json);
    json = vt_json("{\"delta\":1}");
    ck_assert(!vor_json_record_read(&back, json));
    vor_json_free(json);
    json = vt_json("{\"iteration\":-1,\"polish\":4294967296,\"held\":1e300,\"delta\":null}");
    ck_assert(vor_json_record_read(&back, json));
    ck_assert(back.iteration == 0 && back.polish == 0 && back.held == 0 && isnan(back.delta));
    vor_json_free(json);
}

VT_TEST(a_stage_of_another_build_is_none_of_ours)
{
    struct vor_json *json =
        vt_json("{\"iteration\":0,\"run_stage\":\"melt\",\"step\":3,\"of\":7,\"ahead\":9}");
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

static void holds(const char *part)
{
    ck_assert_msg(strstr(text.data, part) != NULL, "no %s in %s", part, text.data);
}

/* What is more than a row of its table (json_members): parts, lists, vectors, and the request. */
VT_TEST(a_report_tells_of_its_stages_warnings_and_request)
{
    struct vor_report report = {
        .points_in = 35947,
        .points_out = 5000,
        .stopped = VOR_STOPPED_ITERATIONS,
        .stages = {{VOR_RUN_STAGE_ITERATE, 50, 4}, {VOR_RUN_STAGE_POLISH, 40, 4.5}},
        .stages_count = 2,
        .lattice = {0.5, 0.25, 0},
        .off_lattice = 12,
        .orientation = VOR_ORIENTED_ONE_SIDED,
        .warnings = {{"orientation", 3, 0, VOR_WARNING_ONE_SIDED}},
        .warnings_count = 1,
        .ref_to_out = {0.125, 0.25, 0.375, 35000},
        .fitted = {{12, 700}, {20, 4300}},
        .fitted_count = 2};
    struct vor_document document = {"report", &vor_report_members, &report};
    struct vor_text request;

    vor_spec_init(&report.parameters);
    vt_assert_ok(vor_spec_set(&report.parameters, "points", "5000", &vt_err));
    vor_text_init(&request, 0);
    vor_text_puts(&request, "\"parameters\":");
    vor_json_spec(&request, &report.parameters);
    vor_text_init(&text, 0);
    vor_json_document(&text, &document);
    vt_assert_ok(vor_json_scan(text.data, text.size, &vt_err));
    holds("{\"points\":{\"in\":35947,\"out\":5000},");
    holds("\"stopped\":\"iterations\",");
    holds("\"warnings\":[{\"about\":\"orientation\",\"value\":3,\"limit\":0,\"says\":\"Some "
          "connected parts of the input have only one side, so their normals cannot be "
          "consistent\"}],");
    holds("\"stages\":[{\"stage\":\"iterate\",\"steps\":50,\"seconds\":4},"
          "{\"stage\":\"polish\",\"steps\":40,\"seconds\":4.5}],");
    holds("\"dropped\":[],");
    holds("\"lattice\":{\"x\":0.5,\"y\":0.25,\"z\":0,\"moved\":12},");
    holds("\"ref_to_out\":{\"mean\":0.125,\"rms\":0.25,\"max\":0.375,\"points\":35000},");
    holds("\"neighbors_histogram\":[{\"neighbors\":12,\"points\":700},"
          "{\"neighbors\":20,\"points\":4300}],");
    holds(request.data);
    vor_text_free(&request);
    vor_text_free(&text);
}

VT_TEST(a_measure_has_an_input_where_it_has_a_reference)
{
    struct vor_measure measure = {.n = 3, .d1_mse = 11, .d2_psnr = (double)INFINITY};
    struct vor_document document = {"measure", &vor_measure_members, &measure};

    for (measure.has_reference = 0; measure.has_reference < 2; measure.has_reference++) {
        vor_text_init(&text, 0);
        vor_json_document(&text, &document);
        vt_assert_ok(vor_json_scan(text.data, text.size, &vt_err));
        holds("{\"n\":3,\"delta\":0,");
        ck_assert_int_eq(strstr(text.data, "\"input\":{") != NULL, measure.has_reference);
        if (measure.has_reference)
            holds("\"d1_mse\":11,\"d1_psnr\":0,\"d2_mse\":0,\"d2_psnr\":null,");
        vor_text_free(&text);
    }
}
