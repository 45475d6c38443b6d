#include "core/opt/lbfgs.h"

#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

static double dot(const double *a, const double *b, size_t n)
{
    double sum = 0;

    for (size_t i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

static void add(double *to, double times, const double *a, size_t n)
{
    for (size_t i = 0; i < n; i++)
        to[i] += times * a[i];
}

vor_status vor_lbfgs_init(struct vor_lbfgs *out, size_t length, struct vor_memory *memory,
                          struct vor_error *err)
{
    struct vor_lbfgs lbfgs = {.memory = memory, .length = length};
    double **vector[] = {&lbfgs.gradient, &lbfgs.direction, &lbfgs.place, &lbfgs.there};
    int ok = 1;

    for (unsigned i = 0; i < 4; i++)
        ok &= (*vector[i] = vor_malloc(memory, length, sizeof(double))) != NULL;
    for (unsigned i = 0; i < VOR_LBFGS_STEPS; i++) {
        lbfgs.step[i] = vor_malloc(memory, length, sizeof(double));
        lbfgs.change[i] = vor_malloc(memory, length, sizeof(double));
        ok &= lbfgs.step[i] != NULL && lbfgs.change[i] != NULL;
    }
    if (!ok) {
        vor_lbfgs_free(&lbfgs);
        return vor_fail(err, VOR_E_NOMEM, "%zu variables", length);
    }
    *out = lbfgs;
    return VOR_OK;
}

void vor_lbfgs_free(struct vor_lbfgs *lbfgs)
{
    if (lbfgs->memory == NULL)
        return;
    for (unsigned i = 0; i < VOR_LBFGS_STEPS; i++) {
        VOR_FREE_ALL(lbfgs->memory, lbfgs->change[i], lbfgs->step[i]);
    }
    VOR_FREE_ALL(lbfgs->memory, lbfgs->there, lbfgs->place, lbfgs->direction, lbfgs->gradient);
    memset(lbfgs, 0, sizeof *lbfgs);
}

/* Slot of the remembered step number k, the oldest first. */
static unsigned slot(const struct vor_lbfgs *lbfgs, unsigned k)
{
    return (lbfgs->begin + k) % VOR_LBFGS_STEPS;
}

/* Divides d by the bend, times that of the last step where there is one. */
static void scale(const struct vor_lbfgs *lbfgs, const double *bend, double *d)
{
    const double *change;
    double length2 = 0, by = 1;

    if (lbfgs->depth > 0) {
        change = lbfgs->change[slot(lbfgs, lbfgs->depth - 1)];
        for (size_t i = 0; i < lbfgs->length; i++)
            length2 += change[i] * change[i] / (bend != NULL ? bend[i] : 1);
        by = lbfgs->product[slot(lbfgs, lbfgs->depth - 1)] / length2;
    }
    for (size_t i = 0; i < lbfgs->length; i++)
        d[i] *= bend != NULL ? by / bend[i] : by;
}

/* The direction in which the function falls, by the two loops of Nocedal 1980. */
static void find_direction(struct vor_lbfgs *lbfgs, const double *bend)
{
    size_t n = lbfgs->length;
    double *d = lbfgs->direction;
    /* cppcheck cannot see that the first loop sets those used */
    double share[VOR_LBFGS_STEPS] = {0};

    for (size_t i = 0; i < n; i++)
        d[i] = -lbfgs->gradient[i];
    for (unsigned k = lbfgs->depth; k-- > 0;) {
        unsigned s = slot(lbfgs, k);

        share[k] = dot(lbfgs->step[s], d, n) / lbfgs->product[s];
        add(d, -share[k], lbfgs->change[s], n);
    }
    scale(lbfgs, bend, d);
    for (unsigned k = 0; k < lbfgs->depth; k++) {
        unsigned s = slot(lbfgs, k);

        add(d, share[k] - dot(lbfgs->change[s], d, n) / lbfgs->product[s], lbfgs->step[s], n);
    }
}

/* Remembers the way from x to place, unless it says nothing of the bend. */
static void remember(struct vor_lbfgs *lbfgs, const double *x)
{
    unsigned s = slot(lbfgs, lbfgs->depth);
    double *step = lbfgs->step[s], *change = lbfgs->change[s], product, lengths2;

    if (lbfgs->depth == VOR_LBFGS_STEPS) {
        lbfgs->begin = slot(lbfgs, 1);
        lbfgs->depth--;
    }
    for (size_t i = 0; i < lbfgs->length; i++) {
        step[i] = lbfgs->place[i] - x[i];
        change[i] = lbfgs->there[i] - lbfgs->gradient[i];
    }
    product = dot(step, change, lbfgs->length);
    lengths2 = dot(step, step, lbfgs->length) * dot(change, change, lbfgs->length);
    if (!(product > VOR_ROUNDED2 * sqrt(lengths2)))
        return;
    lbfgs->product[s] = product;
    lbfgs->depth++;
}

/* Finds the direction, within what the function allows. Returns how fast the function changes along
 * it: negative, or 0 where there is no way on. */
static double aim(struct vor_lbfgs *lbfgs, const double *x, const struct vor_lbfgs_function *f)
{
    double slope;

    for (;;) {
        find_direction(lbfgs, f->bend);
        if (f->shorten != NULL)
            f->shorten(f->ctx, x, lbfgs->direction);
        slope = dot(lbfgs->gradient, lbfgs->direction, lbfgs->length);
        if (slope < 0)
            return slope;
        if (lbfgs->depth == 0)
            return 0;
        lbfgs->depth = 0; /* without memory each component goes down */
    }
}

/* One step from x, where the function is told->after. *moved: there was one. */
static vor_status step_on(struct vor_lbfgs *lbfgs, double *x, const struct vor_lbfgs_function *f,
                          struct vor_lbfgs_told *told, int *moved, struct vor_error *err)
{
    size_t n = lbfgs->length;
    double slope = aim(lbfgs, x, f), t = 1, value;

    *moved = 0;
    while (slope < 0 && t > VOR_ROUNDED) {
        vor_status status;

        for (size_t i = 0; i < n; i++)
            lbfgs->place[i] = x[i] + t * lbfgs->direction[i];
        status = f->at(f->ctx, lbfgs->place, &value, lbfgs->there, err);
        if (status != VOR_OK)
            return status;
        told->evaluations++;
        if (value < told->after) {
            remember(lbfgs, x);
            memcpy(x, lbfgs->place, n * sizeof *x);
            memcpy(lbfgs->gradient, lbfgs->there, n * sizeof *x);
            told->after = value;
            *moved = 1;
            return VOR_OK;
        }
        t /= 2;
    }
    return VOR_OK;
}

vor_status vor_lbfgs_run(struct vor_lbfgs *lbfgs, double *x,
                         const struct vor_lbfgs_function *function, unsigned steps,
                         struct vor_lbfgs_told *told, struct vor_error *err)
{
    int moved = 1;
    vor_status status;

    memset(told, 0, sizeof *told);
    lbfgs->depth = lbfgs->begin = 0;
    status = function->at(function->ctx, x, &told->before, lbfgs->gradient, err);
    told->evaluations = 1;
    told->after = told->before;
    while (status == VOR_OK && moved && told->steps < steps) {
        status = step_on(lbfgs, x, function, told, &moved, err);
        told->steps += (unsigned)moved;
    }
    return status;
}
