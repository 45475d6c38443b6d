/* CGAL's bilateral smoothing and edge-aware upsampling, the peers of the benchmark: reads a PLY,
 * fits normals and orients them, smooths, upsamples, writes points and normals as PLY, prints the
 * CPU seconds of each step. One thread.
 *
 * usage: ear IN.ply NEIGHBORS SMOOTHINGS SENSITIVITY RADIUS POINTS OUT.ply; SMOOTHINGS and POINTS
 * may be 0: not smoothed, not upsampled; RADIUS 0 is CGAL's own choice. */
#include "tests/by_hand/bench/peer.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/bilateral_smooth_point_set.h>
#include <CGAL/edge_aware_upsample_point_set.h>
#include <CGAL/mst_orient_normals.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <utility>
#include <vector>

using kernel = CGAL::Simple_cartesian<double>;
using oriented = std::pair<kernel::Point_3, kernel::Vector_3>;
using point_map = CGAL::First_of_pair_property_map<oriented>;
using normal_map = CGAL::Second_of_pair_property_map<oriented>;

/* Degrees within which two normals count as alike: the paper's, and our default. */
static const double sharp_degrees = 15;

static void normals(std::vector<oriented> &cloud, unsigned neighbors)
{
    const auto maps = CGAL::parameters::point_map(point_map()).normal_map(normal_map());

    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(cloud, neighbors, maps);
    (void)CGAL::mst_orient_normals(cloud, neighbors, maps);
}

static void smooth(std::vector<oriented> &cloud, unsigned neighbors)
{
    CGAL::bilateral_smooth_point_set<CGAL::Sequential_tag>(cloud, neighbors,
                                                           CGAL::parameters::point_map(point_map())
                                                               .normal_map(normal_map())
                                                               .sharpness_angle(sharp_degrees));
}

/* The input's points come first in the result. radius below 0: CGAL's own choice. */
static void upsample(std::vector<oriented> &cloud, double sensitivity, double radius, size_t points)
{
    std::vector<oriented> more;

    CGAL::edge_aware_upsample_point_set<CGAL::Sequential_tag>(
        cloud, std::back_inserter(more),
        CGAL::parameters::point_map(point_map())
            .normal_map(normal_map())
            .sharpness_angle(sharp_degrees)
            .edge_sensitivity(sensitivity)
            .neighbor_radius(radius)
            .number_of_output_points(points));
    cloud = std::move(more);
}

int main(int argc, char **argv)
{
    std::vector<oriented> cloud;

    if (argc != 8) {
        std::fprintf(stderr, "usage: ear IN.ply NEIGHBORS SMOOTHINGS SENSITIVITY RADIUS POINTS "
                             "OUT.ply\n");
        return 2;
    }
    if (!read_ply(argv[1], cloud, CGAL::parameters::point_map(point_map())))
        return 1;
    const unsigned neighbors = static_cast<unsigned>(std::atoi(argv[2]));
    const double radius = std::atof(argv[5]) > 0 ? std::atof(argv[5]) : -1;
    const size_t points = static_cast<size_t>(std::atoll(argv[6]));
    double at[4];

    at[0] = cpu_seconds();
    normals(cloud, neighbors);
    at[1] = cpu_seconds();
    for (int left = std::atoi(argv[3]); left > 0; left--)
        smooth(cloud, neighbors);
    at[2] = cpu_seconds();
    if (points > 0)
        upsample(cloud, std::atof(argv[4]), radius, points);
    at[3] = cpu_seconds();
    if (!write_oriented(argv[7], cloud))
        return 1;
    std::printf(
        "{\"points\":%zu,\"normals\":%.6f,\"smooth\":%.6f,\"upsample\":%.6f,\"cpu\":%.6f}\n",
        cloud.size(), at[1] - at[0], at[2] - at[1], at[3] - at[2], at[3] - at[0]);
    return 0;
}
