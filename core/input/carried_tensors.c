#include "core/input/carried_tensors.h"

#include "core/base/count.h"
#include "core/base/quote.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    QUOTED = 64, /* bytes of a name in a message */
    NAMES = 512, /* of all of them */
    SUFFIX = 3   /* bytes of "_xx" */
};

static const char *const suffixes[6] = {"_xx", "_xy", "_xz", "_yy", "_yz", "_zz"};

int vor_carried_tensors_find(struct vor_carried_tensors *out, const struct vor_cloud *in,
                             const char *name)
{
    const struct vor_attribute *whole = vor_cloud_find_name(in, name);
    char part[sizeof whole->name + SUFFIX];

    for (int c = 0; c < 6; c++)
        out->attribute[c] = whole;
    if (whole != NULL && whole->components == 6)
        return 1;
    for (int c = 0; c < 6; c++) {
        if ((size_t)snprintf(part, sizeof part, "%s%s", name, suffixes[c]) >= sizeof part)
            return 0;
        out->attribute[c] = vor_cloud_find_name(in, part);
        if (out->attribute[c] == NULL || out->attribute[c]->components != 1)
            return 0;
    }
    return 1;
}

void vor_carried_tensors_at(double tensor[6], const struct vor_carried_tensors *tensors, size_t i)
{
    for (size_t c = 0; c < 6; c++) {
        const struct vor_attribute *attribute = tensors->attribute[c];

        tensor[c] = vor_attribute_scalar(attribute, attribute->components == 6 ? 6 * i + c : i);
    }
}

/* Whether a tensor is finite and positive definite, by Sylvester's criterion, once its diagonal is
 * scaled to 1. */
static int is_positive(const double t[6])
{
    double x = sqrt(t[0]), y = sqrt(t[3]), z = sqrt(t[5]);
    double xy = t[1] / x / y, xz = t[2] / x / z, yz = t[4] / y / z;

    if (!(t[0] > 0 && t[3] > 0 && t[5] > 0) || !isfinite(x) || !isfinite(y) || !isfinite(z))
        return 0;
    return xy * xy < 1 && 1 + 2 * xy * xz * yz > xy * xy + xz * xz + yz * yz;
}

static int is_bad(const void *tensors, size_t i)
{
    double tensor[6];

    vor_carried_tensors_at(tensor, tensors, i);
    return !is_positive(tensor);
}

/* Whether an attribute is, or ends, a tensor; its name without the suffix goes to `name`. */
static int names_tensor(char name[QUOTED], const struct vor_cloud *in,
                        const struct vor_attribute *attribute)
{
    struct vor_carried_tensors tensors;
    size_t length = strlen(attribute->name);
    char base[sizeof attribute->name];

    memcpy(base, attribute->name, length + 1);
    if (attribute->components == 1 && length > SUFFIX &&
        strcmp(&base[length - SUFFIX], suffixes[0]) == 0)
        base[length - SUFFIX] = '\0';
    else if (attribute->components != 6)
        return 0;
    vor_quote(name, QUOTED, base, strlen(base));
    return vor_carried_tensors_find(&tensors, in, base);
}

/* Says which tensors could have been named. */
static vor_status refuse_name(const struct vor_cloud *in, const char *name, struct vor_error *err)
{
    char quoted[QUOTED], names[NAMES] = "none";
    size_t at = 0;

    for (size_t i = 0; i < in->attribute_count && at + 2 * QUOTED < sizeof names; i++)
        if (names_tensor(quoted, in, &in->attributes[i]))
            at +=
                (size_t)snprintf(names + at, sizeof names - at, "%s%s", at > 0 ? ", " : "", quoted);
    vor_quote(quoted, sizeof quoted, name, strlen(name));
    return vor_fail_param(err, VOR_E_METRIC, "metric",
                          "the input has no tensors %s, want six scalars NAME_xx, NAME_xy, "
                          "NAME_xz, NAME_yy, NAME_yz, NAME_zz, or one attribute NAME with six "
                          "components; its tensors are %s",
                          quoted, names);
}

vor_status vor_carried_tensors_check(const struct vor_cloud *in, const char *name,
                                     const struct vor_run *run, struct vor_error *err)
{
    struct vor_carried_tensors tensors;
    char quoted[QUOTED];
    size_t bad, first;
    double t[6];
    vor_status status;

    if (!vor_carried_tensors_find(&tensors, in, name))
        return refuse_name(in, name, err);
    status = vor_count(&bad, &first, in->n, is_bad, &tensors, run, err);
    if (status != VOR_OK || bad == 0)
        return status;
    vor_carried_tensors_at(t, &tensors, first);
    vor_quote(quoted, sizeof quoted, name, strlen(name));
    return vor_fail_param(err, VOR_E_METRIC, "metric",
                          "tensor %s is %g %g %g %g %g %g (xx xy xz yy yz zz) at point %zu, "
                          "want a positive definite tensor",
                          quoted, t[0], t[1], t[2], t[3], t[4], t[5], first);
}
