/* The tables of what a run tells: their names make sense in JSON, and rows that others keep stay
 * where they are. */
#include "core/report.h"
#include "tests/support/vt.h"

#include <math.h>
#include <string.h>

static const struct vor_members *const all[] = {&vor_record_members, &vor_report_members,
                                                &vor_measure_members};
enum { TABLES = sizeof all / sizeof all[0] };

/* The name of the object that a row is in, "" for none. */
static void object_of(char out[64], const struct vor_member *row)
{
    const char *dot = strchr(row->name, '.');
    size_t length = dot != NULL ? (size_t)(dot - row->name) : 0;

    if (row->kind == VOR_MEMBER_VECTOR || row->kind == VOR_MEMBER_OPTIONAL)
        length = strlen(row->name);
    ck_assert_uint_lt(length, 64);
    memcpy(out, row->name, length);
    out[length] = '\0';
}

VT_TEST_LOOP(every_row_has_a_name_of_its_own_and_a_sentence, TABLES)
{
    const struct vor_members *members = all[_i];

    for (unsigned i = 0; i < members->count; i++) {
        const struct vor_member *row = &members->rows[i];
        const char *dot = strchr(row->name, '.');

        ck_assert_msg(row->sentence[0] != '\0', "%s", row->name);
        ck_assert_msg(dot == NULL || strchr(dot + 1, '.') == NULL, "%s", row->name);
        ck_assert_uint_lt(row->offset, members->size);
        for (unsigned j = 0; j < i; j++)
            ck_assert_msg(strcmp(members->rows[j].name, row->name) != 0, "%s", row->name);
    }
}

/* Else the object would be in the JSON twice. */
VT_TEST_LOOP(the_rows_of_an_object_stand_next_to_each_other, TABLES)
{
    const struct vor_members *members = all[_i];

    for (unsigned i = 1; i < members->count; i++) {
        char object[64], before[64], earlier[64];

        object_of(object, &members->rows[i]);
        object_of(before, &members->rows[i - 1]);
        if (object[0] == '\0' || strcmp(object, before) == 0)
            continue;
        for (unsigned j = 0; j + 1 < i; j++) {
            object_of(earlier, &members->rows[j]);
            ck_assert_msg(strcmp(object, earlier) != 0, "%s", members->rows[i].name);
        }
    }
}

/* CSV and traces take nothing else. */
VT_TEST(a_record_has_numbers_and_words_only)
{
    for (unsigned i = 0; i < vor_record_members.count; i++) {
        const struct vor_member *row = &vor_record_members.rows[i];

        ck_assert_msg(row->kind == VOR_MEMBER_U32 || row->kind == VOR_MEMBER_U64 ||
                          row->kind == VOR_MEMBER_REAL || row->kind == VOR_MEMBER_WORD,
                      "%s", row->name);
    }
}

VT_TEST(documents_are_found_by_their_names)
{
    ck_assert_ptr_eq(vor_document_members("report"), &vor_report_members);
    ck_assert_ptr_eq(vor_document_members("measure"), &vor_measure_members);
    ck_assert_ptr_null(vor_document_members("cloud"));
}

VT_TEST(stages_are_found_by_their_names)
{
    for (int i = 0; i < VOR_RUN_STAGE_COUNT; i++) {
        const struct vor_run_stage_info *info = vor_run_stage_info((enum vor_run_stage)i);

        ck_assert_int_eq(vor_run_stage_find(info->name), i);
        ck_assert(info->step[0] != '\0' && info->sentence[0] != '\0');
    }
    ck_assert_int_eq(vor_run_stage_find("melt"), VOR_RUN_STAGE_COUNT);
    ck_assert_str_eq(vor_run_stage_info(VOR_RUN_STAGE_COUNT)->step, "step");
    ck_assert_str_eq(vor_run_stage_info((enum vor_run_stage)1000)->step, "step");
}

VT_TEST(a_stage_that_is_gone_through_twice_is_told_once)
{
    struct vor_report report = {0};
    char text[64], little[10];

    ck_assert_str_eq(vor_report_steps(&report, text, sizeof text), "no steps");
    vor_report_stage(&report, VOR_RUN_STAGE_POLISH, 1, 0.125);
    ck_assert_str_eq(vor_report_steps(&report, text, sizeof text), "1 polish step");
    vor_report_stage(&report, VOR_RUN_STAGE_POLISH, 29, 0.375);
    ck_assert_str_eq(vor_report_steps(&report, text, sizeof text), "30 polish steps");
    vor_report_stage(&report, VOR_RUN_STAGE_ITERATE, 8, 2);
    vor_report_stage(&report, VOR_RUN_STAGE_POLISH, 12, 0.25);
    ck_assert_uint_eq(report.stages_count, 2);
    ck_assert_int_eq(report.stages[0].stage, VOR_RUN_STAGE_POLISH);
    ck_assert_uint_eq(report.stages[0].steps, 42);
    ck_assert_double_eq(report.stages[0].seconds, 0.75);
    ck_assert_int_eq(report.stages[1].stage, VOR_RUN_STAGE_ITERATE);
    ck_assert_uint_eq(report.stages[1].steps, 8);
    ck_assert_str_eq(vor_report_steps(&report, text, sizeof text),
                     "42 polish steps and 8 iterations");
    ck_assert_str_eq(vor_report_steps(&report, little, sizeof little), "42 polish");
}

VT_TEST(of_a_record_without_it_the_best_is_not_known)
{
    struct vor_record record = {.best_iteration = 3, .best_polish = 4};

    vor_record_unknown_best(&record);
    ck_assert(record.best_iteration == 0 && record.best_polish == 0);
    ck_assert(isnan(record.best_delta) && isnan(record.best_sigma) && isnan(record.best_epsilon));
}
