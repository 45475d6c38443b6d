#include "tests/support/toy/points.h"

void toy_box_add(struct toy_box *box, const double x[3])
{
    for (int c = 0; c < 3; c++) {
        box->low[c] = fmin(box->low[c], x[c]);
        box->high[c] = fmax(box->high[c], x[c]);
    }
}

vor_status toy_find_among(const struct vor_attribute **out, const struct vor_cloud *cloud,
                          const struct vor_spec *spec, struct vor_error *err)
{
    const char *name = vor_spec_name(spec, VOR_PARAM_AMONG);

    *out = name != NULL ? vor_cloud_find_name(cloud, name) : NULL;
    if (name == NULL || *out != NULL)
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, "among",
                          "among is attribute:%s, want all or an attribute that the cloud has",
                          name);
}

int toy_counts(const struct vor_attribute *among, size_t i)
{
    size_t size = among != NULL ? among->components * vor_type_size(among->type) : 0;
    const unsigned char *value = among != NULL ? (unsigned char *)among->data + i * size : NULL;

    for (size_t b = 0; b < size; b++)
        if (value[b] != 0)
            return 1;
    return among == NULL;
}

int toy_has_axis(const struct vor_spec *spec, const struct toy_box *box, unsigned c)
{
    if (vor_spec_form(spec, VOR_PARAM_AXES) == VOR_FORM_AUTO)
        return box->high[c] > box->low[c];
    return vor_list_has(spec->value[VOR_PARAM_AXES], c);
}

int toy_is_near(const struct vor_spec *spec, double distance, double nearby)
{
    return spec->value[VOR_PARAM_STRICT] != 0 ? distance < nearby : distance <= nearby;
}

double toy_nearby(const struct vor_spec *spec, double usual)
{
    int is_auto = vor_spec_form(spec, VOR_PARAM_NEARBY) == VOR_FORM_AUTO;

    return is_auto ? usual : spec->value[VOR_PARAM_NEARBY];
}
