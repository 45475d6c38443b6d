/* CGAL's advancing front, the peer of the benchmark of meshes: reads a PLY, joins its points by
 * triangles, writes both as PLY, prints the CPU seconds of the algorithm alone. One thread.
 *
 * usage: front IN.ply OUT.ply */
#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/read_ply_points.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <vector>

using kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using points = std::vector<kernel::Point_3>;
using faces = std::vector<std::array<std::size_t, 3>>;

static double cpu_seconds()
{
    timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

static bool write_ply(const char *path, const points &cloud, const faces &joined)
{
    std::ofstream out(path, std::ios::binary);

    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << cloud.size()
        << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << joined.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const auto &p : cloud) {
        const float xyz[3] = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                              static_cast<float>(p.z())};

        out.write(reinterpret_cast<const char *>(xyz), sizeof xyz);
    }
    for (const auto &f : joined) {
        const std::int32_t corner[3] = {static_cast<std::int32_t>(f[0]),
                                        static_cast<std::int32_t>(f[1]),
                                        static_cast<std::int32_t>(f[2])};

        out.put(3);
        out.write(reinterpret_cast<const char *>(corner), sizeof corner);
    }
    return out.flush().good();
}

int main(int argc, char **argv)
{
    points cloud;
    faces joined;

    if (argc != 3) {
        std::fprintf(stderr, "usage: front IN.ply OUT.ply\n");
        return 2;
    }
    std::ifstream in(argv[1], std::ios::binary);
    if (!in || !CGAL::IO::read_PLY(in, std::back_inserter(cloud)) || cloud.empty()) {
        std::fprintf(stderr, "%s is no PLY that CGAL reads\n", argv[1]);
        return 1;
    }
    const double from = cpu_seconds();
    CGAL::advancing_front_surface_reconstruction(cloud.begin(), cloud.end(),
                                                 std::back_inserter(joined));
    const double cpu = cpu_seconds() - from;

    if (!write_ply(argv[2], cloud, joined)) {
        std::fprintf(stderr, "%s cannot be written\n", argv[2]);
        return 1;
    }
    std::printf("{\"faces\":%zu,\"cpu\":%.6f}\n", joined.size(), cpu);
    return 0;
}
