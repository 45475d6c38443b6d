#include "tests/support/vt_mesh.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* As the meshes of ../shared/data begin. */
#define HEADER                                                                                     \
    "ply format binary_little_endian 1.0 element vertex %zu property float x property float y "    \
    "property float z element face %zu property list uchar int vertex_indices end_header%n"

enum { HEADER_MAX = 400, ROW = 13 /* bytes of a face: count and three indices */ };

static int read_body(struct vt_mesh *mesh, FILE *in)
{
    unsigned char row[ROW];
    float x[3];

    for (size_t i = 0; i < mesh->vertices; i++) {
        if (fread(x, sizeof x, 1, in) != 1)
            return -1;
        for (size_t c = 0; c < 3; c++)
            mesh->xyz[3 * i + c] = (double)x[c];
    }
    for (size_t i = 0; i < mesh->faces; i++) {
        if (fread(row, ROW, 1, in) != 1 || row[0] != 3)
            return -1;
        memcpy(&mesh->face[3 * i], row + 1, ROW - 1);
        for (size_t c = 0; c < 3; c++)
            if (mesh->face[3 * i + c] >= mesh->vertices)
                return -1;
    }
    return 0;
}

int vt_mesh_read(struct vt_mesh *out, const char *path)
{
    struct vt_mesh mesh = {0};
    char header[HEADER_MAX + 1] = {0};
    FILE *in = fopen(path, "rb");
    int length = 0, result = -1;

    if (in != NULL && fread(header, 1, HEADER_MAX, in) > 0 &&
        sscanf(header, HEADER, &mesh.vertices, &mesh.faces, &length) == 2 && length > 0 &&
        fseek(in, length + 1, SEEK_SET) == 0) {
        mesh.xyz = malloc(mesh.vertices * 3 * sizeof *mesh.xyz);
        mesh.face = malloc(mesh.faces * 3 * sizeof *mesh.face);
        if (mesh.xyz != NULL && mesh.face != NULL)
            result = read_body(&mesh, in);
    }
    if (in != NULL)
        (void)fclose(in);
    if (result != 0)
        vt_mesh_free(&mesh);
    *out = mesh;
    return result;
}

void vt_mesh_free(struct vt_mesh *mesh)
{
    free(mesh->xyz);
    free(mesh->face);
    memset(mesh, 0, sizeof *mesh);
}

/* Normal of a face, twice its area long. */
static void face_normal(double normal[3], const struct vt_mesh *mesh, size_t i)
{
    const double *a = &mesh->xyz[3 * (size_t)mesh->face[3 * i]],
                 *b = &mesh->xyz[3 * (size_t)mesh->face[3 * i + 1]],
                 *c = &mesh->xyz[3 * (size_t)mesh->face[3 * i + 2]];
    double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]},
           v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};

    vor_cross(normal, u, v);
}

static double face_area(const struct vt_mesh *mesh, size_t i)
{
    double normal[3];

    face_normal(normal, mesh, i);
    return sqrt(vor_dot(normal, normal)) / 2;
}

double vt_mesh_area(const struct vt_mesh *mesh)
{
    double area = 0;

    for (size_t i = 0; i < mesh->faces; i++)
        area += face_area(mesh, i);
    return area;
}

/* Puts a point anywhere on a face: two numbers in the unit square, folded into the triangle. */
static void put(float x[3], const struct vt_mesh *mesh, size_t i, double s, double t)
{
    const uint32_t *face = &mesh->face[3 * i];

    if (s + t > 1) {
        s = 1 - s;
        t = 1 - t;
    }
    for (size_t c = 0; c < 3; c++)
        x[c] = (float)((1 - s - t) * mesh->xyz[3 * (size_t)face[0] + c] +
                       s * mesh->xyz[3 * (size_t)face[1] + c] +
                       t * mesh->xyz[3 * (size_t)face[2] + c]);
}

static void unit_normal(float out[3], const struct vt_mesh *mesh, size_t i)
{
    double normal[3], length;

    face_normal(normal, mesh, i);
    length = fmax(sqrt(vor_dot(normal, normal)), 1e-300);
    for (size_t c = 0; c < 3; c++)
        out[c] = (float)(normal[c] / length);
}

void vt_mesh_sample(float *xyz, float *normal, const struct vt_mesh *mesh, uint64_t seed, size_t n)
{
    double area = vt_mesh_area(mesh), passed = 0;
    size_t at = 0;

    /* One point in each n-th of the area would be too even: places are sorted as spacings of an
     * exponential law are. */
    double *place = malloc((n + 1) * sizeof *place), sum = 0;

    if (place == NULL)
        abort();
    for (size_t i = 0; i <= n; i++)
        place[i] = sum -= log(1 - vor_rng_unit(seed, 0, i));
    for (size_t i = 0; i < mesh->faces && at < n; i++) {
        passed += face_area(mesh, i) / area * sum;
        for (; at < n && (place[at] < passed || i + 1 == mesh->faces); at++) {
            put(&xyz[3 * at], mesh, i, vor_rng_unit(seed, 1, at), vor_rng_unit(seed, 2, at));
            if (normal != NULL)
                unit_normal(&normal[3 * at], mesh, i);
        }
    }
    free(place);
}

/* A side of a face: its vertices, the lesser first. */
struct side {
    uint32_t a, b, face;
};

static int by_vertices(const void *left, const void *right)
{
    const struct side *x = left, *y = right;

    if (x->a != y->a)
        return x->a < y->a ? -1 : 1;
    return x->b < y->b ? -1 : x->b > y->b;
}

static int is_sharp(const struct vt_mesh *mesh, size_t i, size_t j, double cosine)
{
    double a[3], b[3], length;

    face_normal(a, mesh, i);
    face_normal(b, mesh, j);
    length = sqrt(vor_dot(a, a) * vor_dot(b, b));
    return length > 0 && vor_dot(a, b) < cosine * length;
}

int vt_mesh_sharp(struct vt_segments *out, const struct vt_mesh *mesh, double degrees)
{
    double cosine = cos(degrees * M_PI / 180);
    size_t sides = 3 * mesh->faces;
    struct side *side = malloc(sides * sizeof *side);

    out->n = 0;
    out->end = malloc(sides * 6 * sizeof *out->end);
    if (side == NULL || out->end == NULL) {
        free(side);
        vt_segments_free(out);
        return -1;
    }
    for (size_t i = 0; i < sides; i++) {
        uint32_t a = mesh->face[i], b = mesh->face[i % 3 == 2 ? i - 2 : i + 1];

        side[i] = (struct side){a < b ? a : b, a < b ? b : a, (uint32_t)(i / 3)};
    }
    qsort(side, sides, sizeof *side, by_vertices);
    for (size_t i = 1; i < sides; i++) {
        double *end = &out->end[6 * out->n];

        if (by_vertices(&side[i - 1], &side[i]) != 0 ||
            !is_sharp(mesh, side[i - 1].face, side[i].face, cosine))
            continue;
        memcpy(end, &mesh->xyz[3 * (size_t)side[i].a], 3 * sizeof *end);
        memcpy(end + 3, &mesh->xyz[3 * (size_t)side[i].b], 3 * sizeof *end);
        out->n++;
    }
    free(side);
    return 0;
}

void vt_segments_free(struct vt_segments *segments)
{
    free(segments->end);
    memset(segments, 0, sizeof *segments);
}

static double length_of(const double end[6])
{
    double d[3] = {end[3] - end[0], end[4] - end[1], end[5] - end[2]};

    return sqrt(vor_dot(d, d));
}

double vt_segments_length(const struct vt_segments *segments)
{
    double length = 0;

    for (size_t i = 0; i < segments->n; i++)
        length += length_of(&segments->end[6 * i]);
    return length;
}

static double distance2(const double end[6], const double x[3])
{
    double d[3], to[3], along = 0, dd;

    for (int c = 0; c < 3; c++) {
        d[c] = end[3 + c] - end[c];
        to[c] = x[c] - end[c];
    }
    dd = vor_dot(d, d);
    if (dd > 0)
        along = fmin(1, fmax(0, vor_dot(d, to) / dd));
    for (int c = 0; c < 3; c++)
        to[c] -= along * d[c];
    return vor_dot(to, to);
}

static int near_segment(const struct vt_segments *truth, const double x[3], double reach2)
{
    for (size_t i = 0; i < truth->n; i++)
        if (distance2(&truth->end[6 * i], x) <= reach2)
            return 1;
    return 0;
}

static int near_flagged(const double *flagged, size_t n, const double x[3], double reach2)
{
    for (size_t i = 0; i < n; i++) {
        double d[3] = {flagged[3 * i] - x[0], flagged[3 * i + 1] - x[1], flagged[3 * i + 2] - x[2]};

        if (vor_dot(d, d) <= reach2)
            return 1;
    }
    return 0;
}

/* Share of places along the segments, `step` apart, with a flagged point within reach. */
static double recall(const struct vt_segments *truth, const double *flagged, size_t n, double step,
                     double reach2)
{
    size_t places = 0, found = 0;
    double next = step / 2;

    for (size_t i = 0; i < truth->n; i++) {
        const double *end = &truth->end[6 * i];
        double length = length_of(end), x[3];

        for (; next < length; next += step, places++) {
            for (int c = 0; c < 3; c++)
                x[c] = end[c] + next / length * (end[3 + c] - end[c]);
            found += (size_t)near_flagged(flagged, n, x, reach2);
        }
        next -= length;
    }
    return places > 0 ? (double)found / (double)places : 1;
}

struct vt_judged vt_segments_judge(const struct vt_segments *truth, const double *xyz,
                                   const unsigned char *flag, size_t n, double spacing)
{
    struct vt_judged judged = {.precision = 1};
    double reach2 = VT_EDGE_REACH * spacing * VT_EDGE_REACH * spacing;
    double *flagged = malloc((n + 1) * 3 * sizeof *flagged);
    size_t count = 0, right = 0;

    if (flagged == NULL)
        abort();
    for (size_t i = 0; i < n; i++) {
        if (!flag[i])
            continue;
        memcpy(&flagged[3 * count++], &xyz[3 * i], 3 * sizeof *flagged);
        right += (size_t)near_segment(truth, &xyz[3 * i], reach2);
    }
    if (count > 0)
        judged.precision = (double)right / (double)count;
    judged.recall = recall(truth, flagged, count, spacing / 2, reach2);
    judged.share = (double)count / (double)n;
    free(flagged);
    return judged;
}
