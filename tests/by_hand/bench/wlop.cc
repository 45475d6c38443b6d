/* CGAL's weighted locally optimal projection, the peer of the benchmark: reads a PLY, writes the
 * result as PLY, prints the CPU seconds of the algorithm alone. One thread.
 *
 * usage: wlop IN.ply POINTS ITERATIONS RADIUS UNIFORM OUT.ply; RADIUS 0 is CGAL's own choice. */
#include "tests/by_hand/bench/peer.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/wlop_simplify_and_regularize_point_set.h>

#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <vector>

using kernel = CGAL::Simple_cartesian<double>;
using points = std::vector<kernel::Point_3>;

static bool write_ply(const char *path, const points &cloud)
{
    std::ofstream out = begin_ply(path, cloud.size(), {"x", "y", "z"});

    out << "\nend_header\n";
    for (const auto &p : cloud)
        put_vertex(out, {p.x(), p.y(), p.z()});
    return end_ply(out, path);
}

/* radius below 0: eight times the input's mean spacing to six neighbours. */
static points simplify(points &cloud, double percentage, unsigned iterations, double radius,
                       bool uniform)
{
    points result;

    CGAL::wlop_simplify_and_regularize_point_set<CGAL::Sequential_tag>(
        cloud, std::back_inserter(result),
        CGAL::parameters::select_percentage(percentage)
            .neighbor_radius(radius)
            .number_of_iterations(iterations)
            .require_uniform_sampling(uniform));
    return result;
}

int main(int argc, char **argv)
{
    points cloud;

    if (argc != 7) {
        std::fprintf(stderr, "usage: wlop IN.ply POINTS ITERATIONS RADIUS UNIFORM OUT.ply\n");
        return 2;
    }
    if (!read_ply(argv[1], cloud))
        return 1;
    /* The library rounds down; half a point keeps n from becoming n - 1. */
    const double percentage = 100 * (std::atof(argv[2]) + 0.5) / static_cast<double>(cloud.size());
    const unsigned iterations = static_cast<unsigned>(std::atoi(argv[3]));
    const double radius = std::atof(argv[4]) > 0 ? std::atof(argv[4]) : -1;
    const double from = cpu_seconds();
    const points result = simplify(cloud, percentage, iterations, radius, argv[5][0] == '1');
    const double cpu = cpu_seconds() - from;

    if (!write_ply(argv[6], result))
        return 1;
    std::printf("{\"points\":%zu,\"cpu\":%.6f}\n", result.size(), cpu);
    return 0;
}
