/* CGAL's advancing front, the peer of the benchmark of meshes: reads a PLY, joins its points by
 * triangles, writes both as PLY, prints the CPU seconds of the algorithm alone. One thread.
 *
 * usage: front IN.ply OUT.ply */
#include "tests/by_hand/bench/peer.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <vector>

using kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using points = std::vector<kernel::Point_3>;
using faces = std::vector<std::array<std::size_t, 3>>;

static bool write_ply(const char *path, const points &cloud, const faces &joined)
{
    std::ofstream out = begin_ply(path, cloud.size(), {"x", "y", "z"});

    out << "\nelement face " << joined.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const auto &p : cloud)
        put_vertex(out, {p.x(), p.y(), p.z()});
    for (const auto &f : joined) {
        const std::int32_t corner[3] = {static_cast<std::int32_t>(f[0]),
                                        static_cast<std::int32_t>(f[1]),
                                        static_cast<std::int32_t>(f[2])};

        out.put(3);
        out.write(reinterpret_cast<const char *>(corner), sizeof corner);
    }
    return end_ply(out, path);
}

int main(int argc, char **argv)
{
    points cloud;
    faces joined;

    if (argc != 3) {
        std::fprintf(stderr, "usage: front IN.ply OUT.ply\n");
        return 2;
    }
    if (!read_ply(argv[1], cloud))
        return 1;
    const double from = cpu_seconds();
    CGAL::advancing_front_surface_reconstruction(cloud.begin(), cloud.end(),
                                                 std::back_inserter(joined));
    const double cpu = cpu_seconds() - from;

    if (!write_ply(argv[2], cloud, joined))
        return 1;
    std::printf("{\"faces\":%zu,\"cpu\":%.6f}\n", joined.size(), cpu);
    return 0;
}
