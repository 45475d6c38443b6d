#include "core/report.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

_Static_assert(sizeof(enum vor_run_stage) == sizeof(unsigned) &&
                   sizeof(enum vor_stopped) == sizeof(unsigned),
               "VOR_MEMBER_WORD reads an enum as unsigned");

static const struct vor_run_stage_info stages[VOR_RUN_STAGE_COUNT] = {
#define STAGE_ROW(id, stage_name, step_name, text)                                                 \
    {.name = (stage_name), .step = (step_name), .sentence = (text)},
    VOR_RUN_STAGE_TABLE(STAGE_ROW)
#undef STAGE_ROW
};

static const char *const stage_words[VOR_RUN_STAGE_COUNT] = {
#define STAGE_WORD(id, name, step, sentence) (name),
    VOR_RUN_STAGE_TABLE(STAGE_WORD)
#undef STAGE_WORD
};

const struct vor_run_stage_info *vor_run_stage_info(enum vor_run_stage stage)
{
    static const struct vor_run_stage_info other = {"step", "step", "A stage of another version"};

    return (unsigned)stage < VOR_RUN_STAGE_COUNT ? &stages[stage] : &other;
}

enum vor_run_stage vor_run_stage_find(const char *name)
{
    int i = 0;

    while (i < VOR_RUN_STAGE_COUNT && strcmp(stage_words[i], name) != 0)
        i++;
    return (enum vor_run_stage)i;
}

static const char *const stopped_words[VOR_STOPPED_COUNT] = {
#define STOPPED_WORD(id, word) (word),
    VOR_STOPPED_TABLE(STOPPED_WORD)
#undef STOPPED_WORD
};

static const char *const oriented_words[VOR_ORIENTED_COUNT] = {
#define ORIENTED_WORD(id, word) (word),
    VOR_ORIENTED_TABLE(ORIENTED_WORD)
#undef ORIENTED_WORD
};

static const char *const warning_abouts[VOR_WARNING_COUNT] = {
#define WARNING_ABOUT(id, about, sentence) (about),
    VOR_WARNING_KIND_TABLE(WARNING_ABOUT)
#undef WARNING_ABOUT
#define UNUSED_ABOUT(parameter, name, other, words, when) #name,
        VOR_WHEN_TABLE(UNUSED_ABOUT)
#undef UNUSED_ABOUT
};

static const char *const warning_sentences[VOR_WARNING_COUNT] = {
#define WARNING_SENTENCE(id, about, sentence) (sentence),
    VOR_WARNING_KIND_TABLE(WARNING_SENTENCE)
#undef WARNING_SENTENCE
#define UNUSED_SENTENCE(parameter, name, other, words, when) #name " has an effect only " when,
        VOR_WHEN_TABLE(UNUSED_SENTENCE)
#undef UNUSED_SENTENCE
};

static const char *const doubt_words[VOR_DOUBT_COUNT] = {
#define DOUBT_WORD(id, word) (word),
    VOR_DOUBT_TABLE(DOUBT_WORD)
#undef DOUBT_WORD
};

static const char *const answered_words[] = {"no", "yes"};
static const char *const loop_kind_words[] = {"hole", "rim"};
static const char *const hole_outcome_words[] = {"filled", "rim", "too-long", "not-chosen",
                                                 "not-closed"};
static const char *const loop_why_words[] = {
    "enclosed by the surface",
    "at the end of a surface like a tube",
    "encloses the surface",
};

/* The kinds of members that these tables use besides those of members.h. */
#define WORD_OF(list, count) .kind = VOR_MEMBER_WORD, .words = (list), .word_count = (count)
#define LIST_OF(type, field, members)                                                              \
    .kind = VOR_MEMBER_LIST, .inner = &(members), .count_offset = offsetof(type, field##_count)
#define VOR_KIND_OF_RUN_STAGE(type, field) WORD_OF(stage_words, VOR_RUN_STAGE_COUNT)
#define VOR_KIND_OF_STOPPED(type, field) WORD_OF(stopped_words, VOR_STOPPED_COUNT)
#define VOR_KIND_OF_ORIENTED(type, field) WORD_OF(oriented_words, VOR_ORIENTED_COUNT)
#define VOR_KIND_OF_WARNING_SAYS(type, field) WORD_OF(warning_sentences, VOR_WARNING_COUNT)
#define VOR_KIND_OF_ANSWERED(type, field) WORD_OF(answered_words, 2)
#define VOR_KIND_OF_LOOP_KIND(type, field) WORD_OF(loop_kind_words, 2)
#define VOR_KIND_OF_LOOP_WHY(type, field) WORD_OF(loop_why_words, 3)
#define VOR_KIND_OF_HOLE_OUTCOME(type, field) WORD_OF(hole_outcome_words, 5)
#define VOR_KIND_OF_DOUBT(type, field) WORD_OF(doubt_words, VOR_DOUBT_COUNT)
#define VOR_KIND_OF_MATRIX(type, field) .kind = VOR_MEMBER_NUMBERS, .word_count = 16
#define VOR_KIND_OF_AXIS(type, field) .kind = VOR_MEMBER_NUMBERS, .word_count = 3
#define VOR_KIND_OF_RUNNER_UP(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &runner_up_members
#define VOR_KIND_OF_APART(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &apart_members
#define VOR_KIND_OF_BASELINE(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &baseline_members
#define VOR_KIND_OF_BOX(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &box_members
#define VOR_KIND_OF_FITTED(type, field) LIST_OF(type, field, fitted_members)
#define VOR_KIND_OF_STAGES(type, field) LIST_OF(type, field, stage_done_members)
#define VOR_KIND_OF_DROPPED(type, field) LIST_OF(type, field, dropped_members)
#define VOR_KIND_OF_WARNINGS(type, field) LIST_OF(type, field, warning_members)
#define VOR_KIND_OF_MESH_LOOPS(type, field) LIST_OF(type, field, mesh_loop_members)
#define VOR_KIND_OF_HOLES(type, field) LIST_OF(type, field, hole_members)
#define VOR_KIND_OF_COLUMNS(type, field) LIST_OF(type, field, column_members)
#define VOR_KIND_OF_LOOPS(type, field) LIST_OF(type, field, loop_members)
#define VOR_KIND_OF_SPEC(type, field) .kind = VOR_MEMBER_REQUEST

/* The members of a struct, by the rows of its table. */
#define DESCRIBE(name, type, ...)                                                                  \
    const struct vor_members name = {.rows = (const struct vor_member[]){__VA_ARGS__},             \
                                     .count = sizeof((const struct vor_member[]){__VA_ARGS__}) /   \
                                              sizeof(struct vor_member),                           \
                                     .size = sizeof(type)}

#define APART_ROW(...) VOR_MEMBER(struct vor_apart, __VA_ARGS__)
static DESCRIBE(apart_members, struct vor_apart, VOR_APART_TABLE(APART_ROW));
#define RUNNER_UP_ROW(...) VOR_MEMBER(struct vor_runner_up, __VA_ARGS__)
static DESCRIBE(runner_up_members, struct vor_runner_up, VOR_RUNNER_UP_TABLE(RUNNER_UP_ROW));
#define BASELINE_ROW(...) VOR_MEMBER(struct vor_baseline, __VA_ARGS__)
static DESCRIBE(baseline_members, struct vor_baseline, VOR_BASELINE_TABLE(BASELINE_ROW));
#define FITTED_ROW(...) VOR_MEMBER(struct vor_fitted, __VA_ARGS__)
static DESCRIBE(fitted_members, struct vor_fitted, VOR_FITTED_TABLE(FITTED_ROW));
#define STAGE_DONE_ROW(...) VOR_MEMBER(struct vor_stage_done, __VA_ARGS__)
static DESCRIBE(stage_done_members, struct vor_stage_done, VOR_STAGE_DONE_TABLE(STAGE_DONE_ROW));
#define DROPPED_ROW(...) VOR_MEMBER(struct vor_dropped, __VA_ARGS__)
static DESCRIBE(dropped_members, struct vor_dropped, VOR_DROPPED_TABLE(DROPPED_ROW));
#define WARNING_ROW(...) VOR_MEMBER(struct vor_warning, __VA_ARGS__)
static DESCRIBE(warning_members, struct vor_warning, VOR_WARNING_TABLE(WARNING_ROW));
#define MESH_LOOP_ROW(...) VOR_MEMBER(struct vor_mesh_loop, __VA_ARGS__)
static DESCRIBE(mesh_loop_members, struct vor_mesh_loop, VOR_MESH_LOOP_TABLE(MESH_LOOP_ROW));
#define HOLE_ROW(...) VOR_MEMBER(struct vor_hole_told, __VA_ARGS__)
static DESCRIBE(hole_members, struct vor_hole_told, VOR_HOLE_TABLE(HOLE_ROW));
#define BOX_ROW(...) VOR_MEMBER(struct vor_corners, __VA_ARGS__)
static DESCRIBE(box_members, struct vor_corners, VOR_BOX_TABLE(BOX_ROW));
#define COLUMN_ROW(...) VOR_MEMBER(struct vor_column, __VA_ARGS__)
static DESCRIBE(column_members, struct vor_column, VOR_COLUMN_TABLE(COLUMN_ROW));
#define RECORD_ROW(...) VOR_MEMBER(struct vor_record, __VA_ARGS__)
DESCRIBE(vor_record_members, struct vor_record, VOR_RECORD_TABLE(RECORD_ROW));
#define REPORT_ROW(...) VOR_MEMBER(struct vor_report, __VA_ARGS__)
DESCRIBE(vor_report_members, struct vor_report, VOR_REPORT_TABLE(REPORT_ROW));
#define MEASURE_ROW(...) VOR_MEMBER(struct vor_measure, __VA_ARGS__)
DESCRIBE(vor_measure_members, struct vor_measure, VOR_MEASURE_TABLE(MEASURE_ROW));
#define LOOP_ROW(...) VOR_MEMBER(struct vor_loop_told, __VA_ARGS__)
static DESCRIBE(loop_members, struct vor_loop_told, VOR_LOOP_TABLE(LOOP_ROW));
#define INSPECT_ROW(...) VOR_MEMBER(struct vor_inspect, __VA_ARGS__)
DESCRIBE(vor_inspect_members, struct vor_inspect, VOR_INSPECT_TABLE(INSPECT_ROW));

const struct vor_members *vor_document_members(const char *name)
{
    static const struct {
        const char *name;
        const struct vor_members *members;
    } documents[] = {
#define DOCUMENT_ROW(word, description) {(word), &(description)},
        VOR_DOCUMENT_TABLE(DOCUMENT_ROW)
#undef DOCUMENT_ROW
    };

    for (size_t i = 0; i < sizeof documents / sizeof documents[0]; i++)
        if (strcmp(documents[i].name, name) == 0)
            return documents[i].members;
    return NULL;
}

void vor_record_unknown_best(struct vor_record *record)
{
    record->best_iteration = record->best_polish = 0;
    record->best_delta = record->best_sigma = record->best_epsilon = (double)NAN;
}

void vor_warn(struct vor_warning list[VOR_WARNING_COUNT], unsigned *list_count,
              enum vor_warning_kind kind, double value, double limit)
{
    for (unsigned i = 0; i < *list_count; i++)
        if (list[i].says == kind)
            return;
    list[*list_count] = (struct vor_warning){"", value, limit, kind};
    (void)snprintf(list[*list_count].about, sizeof list->about, "%s", warning_abouts[kind]);
    (*list_count)++;
}

void vor_warn_unused(struct vor_report *report, const struct vor_spec *spec)
{
#define UNUSED_PARAMETER(parameter, name, other, words, when) VOR_PARAM_##parameter,
    static const enum vor_parameter parameters[] = {VOR_WHEN_TABLE(UNUSED_PARAMETER)};
#undef UNUSED_PARAMETER
    enum { COUNT = sizeof parameters / sizeof parameters[0], FIRST = VOR_WARNING_COUNT - COUNT };

    for (int i = 0; i < COUNT; i++)
        if (!vor_spec_is_default(spec, parameters[i]) && !vor_spec_counts(spec, parameters[i]))
            vor_warn(report->warnings, &report->warnings_count, (enum vor_warning_kind)(FIRST + i),
                     (double)NAN, (double)NAN);
}

void vor_report_stage(struct vor_report *report, enum vor_run_stage stage, uint32_t steps,
                      double seconds)
{
    unsigned at = 0;

    assert((unsigned)stage < VOR_RUN_STAGE_COUNT);
    while (at < report->stages_count && report->stages[at].stage != stage)
        at++;
    if (at == report->stages_count)
        report->stages[report->stages_count++] = (struct vor_stage_done){.stage = stage};
    report->stages[at].steps += steps;
    report->stages[at].seconds += seconds;
}

const char *vor_report_steps(const struct vor_report *report, char *out, size_t size)
{
    size_t at = 0;

    assert(size > 0);
    (void)snprintf(out, size, "%s", report->stages_count == 0 ? "no steps" : "");
    for (unsigned i = 0; i < report->stages_count && at < size; i++) {
        const struct vor_stage_done *done = &report->stages[i];
        const char *before = i == 0 ? "" : i + 1 < report->stages_count ? ", " : " and ";

        at += (size_t)snprintf(out + at, size - at, "%s%u %s%s", before, (unsigned)done->steps,
                               vor_run_stage_info(done->stage)->step, done->steps == 1 ? "" : "s");
    }
    return out;
}
