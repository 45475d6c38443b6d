#include "tests/support/vt_methods.h"

#include "tests/support/vt_filter.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

/* Adds a column of float32 of which value gives the scalars. */
static void carry(struct vor_cloud *cloud, const char *name, float (*value)(const float *x))
{
    struct vor_attribute *a;

    vt_assert_ok(vor_cloud_add_attribute(cloud, name, VOR_GENERIC, VOR_FLOAT32, 1, &a, &vt_err));
    for (size_t i = 0; i < cloud->n; i++)
        ((float *)a->data)[i] = value(&cloud->xyz[3 * i]);
}

static float one(const float *x)
{
    (void)x;
    return 1;
}

static float none(const float *x)
{
    (void)x;
    return 0;
}

static float ramp(const float *x)
{
    return 2 + x[0];
}

/* A box with a weight, a tensor and numbers. */
static void make_carrying(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    static const char *const across[3] = {"shape_xy", "shape_xz", "shape_yz"};

    vt_cloud_box(cloud, seed, n);
    vt_number(cloud);
    carry(cloud, "weight", ramp);
    carry(cloud, "shape_xx", ramp);
    carry(cloud, "shape_yy", one);
    carry(cloud, "shape_zz", one);
    for (int c = 0; c < 3; c++)
        carry(cloud, across[c], none);
}

/* A sphere with normals, of which every tenth looks inward. */
static void make_oriented(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    struct vor_attribute *a;

    vt_cloud_sphere(cloud, seed, n);
    vt_assert_ok(vor_cloud_add_attribute(cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3, &a, &vt_err));
    for (size_t i = 0; i < 3 * n; i++)
        ((float *)a->data)[i] = i / 3 % 10 == 0 ? -cloud->xyz[i] : cloud->xyz[i];
}

void vt_cloud_island(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_sphere(cloud, seed, n);
    for (size_t i = 0; i < 90; i++)
        cloud->xyz[i] = 5 + 0.02F * cloud->xyz[i];
}

/* A rough sphere and strays around it. */
static void make_rough(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_sphere(cloud, seed, n);
    vt_noise_radial(cloud, seed, 0.01, 1);
    for (size_t i = 0; i < 3 * n; i++)
        if (i < 3 * n / 50)
            cloud->xyz[i] *= (float)(1.1 + 0.9 * vt_unit(seed, i / 3));
    vt_number(cloud);
}

/* Half a sphere with a round hole beside its top. */
static void make_punched(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    size_t left = 0;

    vt_cloud_dome(cloud, seed, n);
    for (size_t i = 0; i < n; i++)
        if (cloud->xyz[3 * i] < 0.5F || cloud->xyz[3 * i + 2] < 0.5F)
            memmove(&cloud->xyz[3 * left++], &cloud->xyz[3 * i], 3 * sizeof(float));
    cloud->n = left;
}

/* Two wavy sheets, two fifths of a spacing apart. */
static void make_waves(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_sheets(cloud, seed, n, 0.4 * sqrt(2.0 / (double)n));
    for (size_t i = 0; i < n; i++) {
        float *x = &cloud->xyz[3 * i];

        x[2] += (float)(0.03 * sin(7 * (double)x[0]) * sin(7 * (double)x[1]));
    }
}

/* Two sheets that cross at four degrees. */
static void make_crossing(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_square(cloud, seed, n);
    for (size_t i = 0; i < n; i++)
        cloud->xyz[3 * i + 2] = i % 2 ? 0.07F * (cloud->xyz[3 * i] - 0.5F) : 0;
}

/* A torus rounded to cells of 1.2 spacings. */
static void make_voxels(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    float cell = (float)(1.2 * sqrt(vt_shapes[VT_TORUS].area / (double)n));

    vt_cloud_torus(cloud, seed, n);
    for (size_t i = 0; i < 3 * n; i++)
        cloud->xyz[i] = cell * (floorf(cloud->xyz[i] / cell) + 0.5F);
}

/* A strip of triangles over the first points of a sphere. */
static void make_faces(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    vt_cloud_sphere(cloud, seed, n);
    vt_number(cloud);
    cloud->triangle_count = n < 100 ? n - 2 : 98;
    cloud->triangles = vor_malloc(&vt_memory, cloud->triangle_count, 3 * sizeof(uint32_t));
    ck_assert_ptr_nonnull(cloud->triangles);
    for (size_t i = 0; i < 3 * cloud->triangle_count; i++)
        cloud->triangles[i] = (uint32_t)(i / 3 + i % 3);
}

#define SHORT " ratio=0.2 iterations=2 polish=2"
#define FILTERED " filters=mls,outliers,thin"

#define ROW(title, maker, most, least, request)                                                    \
    {                                                                                              \
        .name = (title), .call = vt_call_request, .make = (maker), .many = (most), .few = (least), \
        .options = (request)                                                                       \
    }

/* The quickest come first: an allocation fails in the first row that makes it. */
const struct vt_row vt_methods[VT_METHODS_MAX] = {
    ROW("measure", make_carrying, 1200, 400, "measure"),
    ROW("border free", make_punched, 1200, 200, "resample boundary=free" SHORT),
    ROW("spacing", vt_cloud_sphere, 1200, 200, "resample spacing=0.4 iterations=2 polish=2"),
    ROW("momentum", vt_cloud_sphere, 1200, 200, "resample anderson=4" SHORT),
    ROW("curvature", vt_cloud_dome, 1200, 200, "resample density=curvature" SHORT),
    ROW("baselines", vt_cloud_dome, 1500, 200, "resample baselines=true" SHORT),
    ROW("oriented normals", make_oriented, 1200, 200, "resample normals=oriented" SHORT),
    ROW("wlop", make_rough, 1500, 200, "resample method=wlop ratio=0.2 polish=2 steps=2"),
    ROW("defaults", vt_cloud_dome, 1200, 0, "resample points=800"),
    ROW("more than there are", make_carrying, 250, 0, "resample ratio=3 normals=fit"),
    ROW("cvt", make_carrying, 1200, 200, "resample normals=fit" SHORT),
    ROW("planes", make_waves, 1200, 200, "resample patch=plane" SHORT),
    ROW("thinned input", vt_cloud_torus, 45000, 0, "resample points=300 iterations=4 polish=4"),
    ROW("polish", make_rough, 1200, 200, "resample ratio=1.25 iterations=1 polish=12"),
    ROW("progressive order", make_carrying, 1200, 200, "resample order=progressive" SHORT),
    ROW("normals made", vt_cloud_torus, 1200, 200, "resample normals=oriented" SHORT),
    ROW("k-means", make_carrying, 1200, 200, "resample method=kmeans ratio=0.2 iterations=3"),
    ROW("isotropic", make_punched, 1200, 200, "resample method=isotropic" SHORT),
    ROW("ear, one phase", make_oriented, 1000, 150,
        "resample method=ear ratio=3 phases=insert gaps=fill polish=2"),
    ROW("ear", make_carrying, 1000, 150,
        "resample method=ear ratio=2 samples=100 polish=2 steps=2 rounds=1"),
    ROW("lp", vt_cloud_torus, 1500, 100, "resample metric=lp ratio=0.4 iterations=3"),
    ROW("Euclidean cells", vt_cloud_torus, 1500, 100,
        "resample metric=anisotropic cells=euclid ratio=0.4 iterations=3"),
    ROW("anisotropic", vt_cloud_torus, 1200, 200, "resample metric=anisotropic" SHORT),
    ROW("metric carried", make_carrying, 1200, 200, "resample metric=attribute:shape" SHORT),
    ROW("density carried", make_carrying, 1200, 200, "resample density=attribute:weight" SHORT),
    ROW("dense edges", vt_cloud_box, 2400, 250, "resample density=edges" SHORT),
    ROW("sites on edges", vt_cloud_box, 2400, 250, "resample edges=sites" SHORT),
    ROW("sites on borders", make_punched, 1200, 300, "resample boundary=sites" SHORT),
    ROW("holes filled", make_punched, 1200, 300, "resample boundary=fill holeMax=10" SHORT),
    ROW("sheets", make_waves, 1200, 300, "resample" SHORT),
    ROW("sheets by satellites", make_waves, 1200, 300, "resample intrinsic=satellites" SHORT),
    ROW("sheets ignored", make_waves, 1200, 0, "resample intrinsic=none" SHORT),
    ROW("lattice", make_voxels, 1200, 300, "resample" SHORT),
    ROW("islands", vt_cloud_island, 1200, 300, "resample" SHORT),
    ROW("outliers dropped", make_rough, 1200, 300, "resample outliers=drop" SHORT),
    ROW("outliers pulled", make_rough, 1200, 300, "resample outliers=pull" SHORT),
    ROW("faces", make_faces, 1500, 0, "resample sample=faces points=60 iterations=1 polish=1"),
    ROW("sequence", vt_cloud_dome, 1200, 200, "resample coherence=0.9" SHORT),
    ROW("sequence with fixed points", vt_cloud_island, 1200, 300,
        "resample coherence=0.9 edges=sites" SHORT),
    ROW("denoise", make_rough, 600, 0, "denoise"),
    ROW("denoise by mls", make_rough, 1200, 300, "denoise filters=mls"),
    ROW("denoise by outliers", make_rough, 1200, 300, "denoise filters=outliers"),
    ROW("denoise by thinning", make_rough, 1200, 300, "denoise filters=thin" SHORT),
    ROW("denoise by all", make_rough, 1200, 300, "denoise outliers=pull" FILTERED),
    ROW("upsample", make_carrying, 600, 100, "upsample"),
    ROW("insert", make_carrying, 600, 100, "upsample method=insert normals=fit"),
    ROW("simplify", make_carrying, 1500, 0, "simplify ratio=0.25"),
    ROW("mesh", vt_cloud_torus, 2000, 300, "mesh" SHORT),
    ROW("mesh, repaired", vt_cloud_torus, 2000, 300, "mesh repair=auto" SHORT),
    ROW("mesh, anisotropic", vt_cloud_torus, 1200, 300, "mesh metric=anisotropic" SHORT),
    ROW("mesh of sheets", make_waves, 1500, 250, "mesh" SHORT),
    ROW("mesh of sheets that cross", make_crossing, 1000, 400, "mesh" SHORT),
    ROW("mesh with a border", make_punched, 2000, 0, "mesh boundary=fill holeMax=10" SHORT),
    ROW("soup", make_carrying, 2000, 300, "mesh soup=true" SHORT),
    ROW("mesh by ear", make_oriented, 1000, 0, "mesh method=ear ratio=2 samples=100 polish=2"),
    ROW("inspect", make_rough, 1500, 300, "inspect vcm=true"),
    ROW("inspect holes", make_punched, 1200, 300, "inspect"),
    ROW("inspect sheets", make_waves, 1200, 300, "inspect outliers=keep intrinsic=satellites"),
    ROW("restore", make_voxels, 4000, 300, "restore"),
    ROW("register", make_oriented, 4000, 300, "register scale=free"),
    {.name = "convert",
     .call = vt_call_request,
     .make = make_carrying,
     .many = 4000,
     .few = 200,
     .options = "convert",
     .silent = 1},
};

int vt_methods_count(void)
{
    int count = 0;

    while (vt_methods[count].name != NULL)
        count++;
    return count;
}
