/* CGAL's orientation of normals by a minimum spanning tree, the peer of the benchmark: reads a PLY,
 * fits normals, orients them, writes points and normals as PLY, prints the CPU seconds of both
 * steps and how many normals it left unoriented. One thread.
 *
 * usage: orient IN.ply NEIGHBORS OUT.ply */
#include "tests/by_hand/bench/peer.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/mst_orient_normals.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

using kernel = CGAL::Simple_cartesian<double>;
using oriented = std::pair<kernel::Point_3, kernel::Vector_3>;
using point_map = CGAL::First_of_pair_property_map<oriented>;
using normal_map = CGAL::Second_of_pair_property_map<oriented>;

int main(int argc, char **argv)
{
    std::vector<oriented> cloud;

    if (argc != 4) {
        std::fprintf(stderr, "usage: orient IN.ply NEIGHBORS OUT.ply\n");
        return 2;
    }
    if (!read_ply(argv[1], cloud, CGAL::parameters::point_map(point_map())))
        return 1;
    const unsigned k = static_cast<unsigned>(std::atoi(argv[2]));
    const auto maps = CGAL::parameters::point_map(point_map()).normal_map(normal_map());
    const double from = cpu_seconds();

    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(cloud, k, maps);
    const double fitted = cpu_seconds();
    const auto left = cloud.end() - CGAL::mst_orient_normals(cloud, k, maps);
    const double done = cpu_seconds();

    if (!write_oriented(argv[3], cloud))
        return 1;
    std::printf("{\"points\":%zu,\"fit\":%.6f,\"orient\":%.6f,\"left\":%td}\n", cloud.size(),
                fitted - from, done - fitted, left);
    return 0;
}
