/** What the peers out of CGAL share: the clock, and PLY files in and out. */
#ifndef BENCH_PEER_H
#define BENCH_PEER_H

#include <CGAL/IO/read_ply_points.h>

#include <cstddef>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <utility>
#include <vector>

static inline double cpu_seconds()
{
    timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

/** Reads the points of a PLY, by CGAL's named parameters if there are any; says so if it cannot. */
template <typename point, typename... named>
bool read_ply(const char *path, std::vector<point> &cloud, const named &...how)
{
    std::ifstream in(path, std::ios::binary);

    if (in && CGAL::IO::read_PLY(in, std::back_inserter(cloud), how...) && !cloud.empty())
        return true;
    std::fprintf(stderr, "%s is no PLY that CGAL reads\n", path);
    return false;
}

/** Begins a PLY of n vertices with these properties; the header is left open. */
static inline std::ofstream begin_ply(const char *path, std::size_t n,
                                      std::initializer_list<const char *> names)
{
    std::ofstream out(path, std::ios::binary);

    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << n;
    for (const char *name : names)
        out << "\nproperty float " << name;
    return out;
}

static inline void put_vertex(std::ofstream &out, std::initializer_list<double> row)
{
    for (const double number : row) {
        const float value = static_cast<float>(number);

        out.write(reinterpret_cast<const char *>(&value), sizeof value);
    }
}

/** Ends a PLY; says so if it cannot be written. */
static inline bool end_ply(std::ofstream &out, const char *path)
{
    if (out.flush().good())
        return true;
    std::fprintf(stderr, "%s cannot be written\n", path);
    return false;
}

/** Writes pairs of a point and its normal. */
template <typename oriented>
bool write_oriented(const char *path, const std::vector<oriented> &cloud)
{
    std::ofstream out = begin_ply(path, cloud.size(), {"x", "y", "z", "nx", "ny", "nz"});

    out << "\nend_header\n";
    for (const auto &[p, n] : cloud)
        put_vertex(out, {p.x(), p.y(), p.z(), n.x(), n.y(), n.z()});
    return end_ply(out, path);
}

#endif
