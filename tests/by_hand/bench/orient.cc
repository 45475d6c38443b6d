/* CGAL's orientation of normals by a minimum spanning tree, the peer of the benchmark: reads a PLY,
 * fits normals, orients them, writes points and normals as PLY, prints the CPU seconds of both
 * steps and how many normals it left unoriented. One thread.
 *
 * usage: orient IN.ply NEIGHBORS OUT.ply */
#include <CGAL/IO/read_ply_points.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/mst_orient_normals.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

using kernel = CGAL::Simple_cartesian<double>;
using oriented = std::pair<kernel::Point_3, kernel::Vector_3>;
using point_map = CGAL::First_of_pair_property_map<oriented>;
using normal_map = CGAL::Second_of_pair_property_map<oriented>;

static double cpu_seconds()
{
    timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

static bool write_ply(const char *path, const std::vector<oriented> &cloud)
{
    std::ofstream out(path, std::ios::binary);

    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << cloud.size();
    for (const char *name : {"x", "y", "z", "nx", "ny", "nz"})
        out << "\nproperty float " << name;
    out << "\nend_header\n";
    for (const auto &[p, n] : cloud) {
        const float row[6] = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                              static_cast<float>(p.z()), static_cast<float>(n.x()),
                              static_cast<float>(n.y()), static_cast<float>(n.z())};

        out.write(reinterpret_cast<const char *>(row), sizeof row);
    }
    return out.flush().good();
}

int main(int argc, char **argv)
{
    std::vector<oriented> cloud;

    if (argc != 4) {
        std::fprintf(stderr, "usage: orient IN.ply NEIGHBORS OUT.ply\n");
        return 2;
    }
    std::ifstream in(argv[1], std::ios::binary);
    if (!in ||
        !CGAL::IO::read_PLY(in, std::back_inserter(cloud),
                            CGAL::parameters::point_map(point_map())) ||
        cloud.empty()) {
        std::fprintf(stderr, "%s is no PLY that CGAL reads\n", argv[1]);
        return 1;
    }
    const unsigned k = static_cast<unsigned>(std::atoi(argv[2]));
    const auto maps = CGAL::parameters::point_map(point_map()).normal_map(normal_map());
    const double from = cpu_seconds();

    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(cloud, k, maps);
    const double fitted = cpu_seconds();
    const auto left = cloud.end() - CGAL::mst_orient_normals(cloud, k, maps);
    const double done = cpu_seconds();

    if (!write_ply(argv[3], cloud)) {
        std::fprintf(stderr, "%s cannot be written\n", argv[3]);
        return 1;
    }
    std::printf("{\"points\":%zu,\"fit\":%.6f,\"orient\":%.6f,\"left\":%td}\n", cloud.size(),
                fitted - from, done - fitted, left);
    return 0;
}
