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

const char *vor_stopped_word(enum vor_stopped stopped)
{
    assert((unsigned)stopped < VOR_STOPPED_COUNT);
    return stopped_words[stopped];
}

static const char *const oriented_words[VOR_ORIENTED_COUNT] = {
#define ORIENTED_WORD(id, word) (word),
    VOR_ORIENTED_TABLE(ORIENTED_WORD)
#undef ORIENTED_WORD
};

static const char *const warning_abouts[VOR_WARNING_COUNT] = {
#define WARNING_ABOUT(id, about, sentence) (about),
    VOR_WARNING_KIND_TABLE(WARNING_ABOUT)
#undef WARNING_ABOUT
};

static const char *const warning_sentences[VOR_WARNING_COUNT] = {
#define WARNING_SENTENCE(id, about, sentence) (sentence),
    VOR_WARNING_KIND_TABLE(WARNING_SENTENCE)
#undef WARNING_SENTENCE
};

static const char *const answered_words[] = {"no", "yes"};

/* The kinds of members that these tables use besides those of members.h. */
#define VOR_KIND_OF_RUN_STAGE(type, field)                                                         \
    .kind = VOR_MEMBER_WORD, .words = stage_words, .word_count = VOR_RUN_STAGE_COUNT
#define VOR_KIND_OF_STOPPED(type, field)                                                           \
    .kind = VOR_MEMBER_WORD, .words = stopped_words, .word_count = VOR_STOPPED_COUNT
#define VOR_KIND_OF_APART(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &apart_members
#define VOR_KIND_OF_BASELINE(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &baseline_members
#define VOR_KIND_OF_FITTED(type, field)                                                            \
    .kind = VOR_MEMBER_LIST, .inner = &fitted_members, .count_offset = offsetof(type, field##_count)
#define VOR_KIND_OF_STAGES(type, field)                                                            \
    .kind = VOR_MEMBER_LIST, .inner = &stage_done_members,                                         \
    .count_offset = offsetof(type, field##_count)
#define VOR_KIND_OF_SPEC(type, field) .kind = VOR_MEMBER_REQUEST
#define VOR_KIND_OF_DROPPED(type, field)                                                           \
    .kind = VOR_MEMBER_LIST, .inner = &dropped_members,                                            \
    .count_offset = offsetof(type, field##_count)
#define VOR_KIND_OF_ORIENTED(type, field)                                                          \
    .kind = VOR_MEMBER_WORD, .words = oriented_words, .word_count = VOR_ORIENTED_COUNT
#define VOR_KIND_OF_WARNING_ABOUT(type, field)                                                     \
    .kind = VOR_MEMBER_WORD, .words = warning_abouts, .word_count = VOR_WARNING_COUNT
#define VOR_KIND_OF_WARNING_SAYS(type, field)                                                      \
    .kind = VOR_MEMBER_WORD, .words = warning_sentences, .word_count = VOR_WARNING_COUNT
#define VOR_KIND_OF_WARNINGS(type, field)                                                          \
    .kind = VOR_MEMBER_LIST, .inner = &warning_members,                                            \
    .count_offset = offsetof(type, field##_count)
#define VOR_KIND_OF_ANSWERED(type, field)                                                          \
    .kind = VOR_MEMBER_WORD, .words = answered_words, .word_count = 2
#define VOR_KIND_OF_MESH_LOOPS(type, field)                                                        \
    .kind = VOR_MEMBER_LIST, .inner = &mesh_loop_members,                                          \
    .count_offset = offsetof(type, field##_count)
#define VOR_KIND_OF_LOOP_KIND(type, field)                                                         \
    .kind = VOR_MEMBER_WORD, .words = loop_kind_words, .word_count = 2
#define VOR_KIND_OF_HOLE_OUTCOME(type, field)                                                      \
    .kind = VOR_MEMBER_WORD, .words = hole_outcome_words, .word_count = 5
#define VOR_KIND_OF_HOLES(type, field)                                                             \
    .kind = VOR_MEMBER_LIST, .inner = &hole_members, .count_offset = offsetof(type, field##_count)
#define VOR_KIND_OF_BOX(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &box_members
#define VOR_KIND_OF_COLUMNS(type, field)                                                           \
    .kind = VOR_MEMBER_LIST, .inner = &column_members, .count_offset = offsetof(type, field##_count)

static const struct vor_member apart_rows[] = {
#define APART_ROW(...) VOR_MEMBER(struct vor_apart, __VA_ARGS__)
    VOR_APART_TABLE(APART_ROW)
#undef APART_ROW
};

static const struct vor_members apart_members = VOR_MEMBERS(struct vor_apart, apart_rows);

static const struct vor_member baseline_rows[] = {
#define BASELINE_ROW(...) VOR_MEMBER(struct vor_baseline, __VA_ARGS__)
    VOR_BASELINE_TABLE(BASELINE_ROW)
#undef BASELINE_ROW
};

static const struct vor_members baseline_members = VOR_MEMBERS(struct vor_baseline, baseline_rows);

static const struct vor_member fitted_rows[] = {
#define FITTED_ROW(...) VOR_MEMBER(struct vor_fitted, __VA_ARGS__)
    VOR_FITTED_TABLE(FITTED_ROW)
#undef FITTED_ROW
};

static const struct vor_members fitted_members = VOR_MEMBERS(struct vor_fitted, fitted_rows);

static const struct vor_member stage_done_rows[] = {
#define STAGE_DONE_ROW(...) VOR_MEMBER(struct vor_stage_done, __VA_ARGS__)
    VOR_STAGE_DONE_TABLE(STAGE_DONE_ROW)
#undef STAGE_DONE_ROW
};

static const struct vor_members stage_done_members =
    VOR_MEMBERS(struct vor_stage_done, stage_done_rows);

static const struct vor_member dropped_rows[] = {
#define DROPPED_ROW(...) VOR_MEMBER(struct vor_dropped, __VA_ARGS__)
    VOR_DROPPED_TABLE(DROPPED_ROW)
#undef DROPPED_ROW
};

static const struct vor_members dropped_members = VOR_MEMBERS(struct vor_dropped, dropped_rows);

static const struct vor_member warning_rows[] = {
#define WARNING_ROW(...) VOR_MEMBER(struct vor_warning, __VA_ARGS__)
    VOR_WARNING_TABLE(WARNING_ROW)
#undef WARNING_ROW
};

static const struct vor_members warning_members = VOR_MEMBERS(struct vor_warning, warning_rows);

static const struct vor_member mesh_loop_rows[] = {
#define MESH_LOOP_ROW(...) VOR_MEMBER(struct vor_mesh_loop, __VA_ARGS__)
    VOR_MESH_LOOP_TABLE(MESH_LOOP_ROW)
#undef MESH_LOOP_ROW
};

static const struct vor_members mesh_loop_members =
    VOR_MEMBERS(struct vor_mesh_loop, mesh_loop_rows);

static const char *const loop_kind_words[] = {"hole", "rim"};
static const char *const hole_outcome_words[] = {"filled", "rim", "too-long", "not-chosen",
                                                 "not-closed"};

static const struct vor_member hole_rows[] = {
#define HOLE_ROW(...) VOR_MEMBER(struct vor_hole_told, __VA_ARGS__)
    VOR_HOLE_TABLE(HOLE_ROW)
#undef HOLE_ROW
};

static const struct vor_members hole_members = VOR_MEMBERS(struct vor_hole_told, hole_rows);

static const struct vor_member box_rows[] = {
#define BOX_ROW(...) VOR_MEMBER(struct vor_corners, __VA_ARGS__)
    VOR_BOX_TABLE(BOX_ROW)
#undef BOX_ROW
};

static const struct vor_members box_members = VOR_MEMBERS(struct vor_corners, box_rows);

static const struct vor_member column_rows[] = {
#define COLUMN_ROW(...) VOR_MEMBER(struct vor_column, __VA_ARGS__)
    VOR_COLUMN_TABLE(COLUMN_ROW)
#undef COLUMN_ROW
};

static const struct vor_members column_members = VOR_MEMBERS(struct vor_column, column_rows);

static const struct vor_member record_rows[] = {
#define RECORD_ROW(...) VOR_MEMBER(struct vor_record, __VA_ARGS__)
    VOR_RECORD_TABLE(RECORD_ROW)
#undef RECORD_ROW
};

const struct vor_members vor_record_members = VOR_MEMBERS(struct vor_record, record_rows);

static const struct vor_member report_rows[] = {
#define REPORT_ROW(...) VOR_MEMBER(struct vor_report, __VA_ARGS__)
    VOR_REPORT_TABLE(REPORT_ROW)
#undef REPORT_ROW
};

const struct vor_members vor_report_members = VOR_MEMBERS(struct vor_report, report_rows);

static const struct vor_member measure_rows[] = {
#define MEASURE_ROW(...) VOR_MEMBER(struct vor_measure, __VA_ARGS__)
    VOR_MEASURE_TABLE(MEASURE_ROW)
#undef MEASURE_ROW
};

const struct vor_members vor_measure_members = VOR_MEMBERS(struct vor_measure, measure_rows);

static const char *const loop_why_words[] = {
    "the surface lies around it",
    "the surface lies to one side, as at the end of a tube",
    "the surface lies within it",
};

#define VOR_KIND_OF_LOOP_WHY(type, field)                                                          \
    .kind = VOR_MEMBER_WORD, .words = loop_why_words, .word_count = 3
#define VOR_KIND_OF_LOOPS(type, field)                                                             \
    .kind = VOR_MEMBER_LIST, .inner = &loop_members, .count_offset = offsetof(type, field##_count)

static const struct vor_member loop_rows[] = {
#define LOOP_ROW(...) VOR_MEMBER(struct vor_loop_told, __VA_ARGS__)
    VOR_LOOP_TABLE(LOOP_ROW)
#undef LOOP_ROW
};

static const struct vor_members loop_members = VOR_MEMBERS(struct vor_loop_told, loop_rows);

static const struct vor_member inspect_rows[] = {
#define INSPECT_ROW(...) VOR_MEMBER(struct vor_inspect, __VA_ARGS__)
    VOR_INSPECT_TABLE(INSPECT_ROW)
#undef INSPECT_ROW
};

const struct vor_members vor_inspect_members = VOR_MEMBERS(struct vor_inspect, inspect_rows);

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
        if (list[i].about == kind)
            return;
    list[(*list_count)++] = (struct vor_warning){kind, value, limit, kind};
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
