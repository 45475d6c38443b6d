// usage: embed CLOUD.drc >POINTS: decodes a Draco cloud, restores it in this process, and writes
// its positions, three floats a point. c++ embed.cc $(pkg-config --cflags --libs voronoid draco)
#include <draco/compression/decode.h>
#include <voronoid.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

static int fail(const std::string &why)
{
    std::fprintf(stderr, "embed: %s\n", why.c_str());
    return 1;
}

// The positions of a coded cloud, in its order; none if it cannot be read.
static std::vector<float> decode(const std::vector<char> &bytes)
{
    std::vector<float> xyz;
    draco::DecoderBuffer buffer;
    draco::Decoder decoder;

    buffer.Init(bytes.data(), bytes.size());
    auto cloud = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!cloud.ok())
        return xyz;
    const draco::PointAttribute *position =
        cloud.value()->GetNamedAttribute(draco::GeometryAttribute::POSITION);
    if (position == nullptr)
        return xyz;
    xyz.resize(3 * cloud.value()->num_points());
    for (draco::PointIndex i(0); i < cloud.value()->num_points(); ++i)
        position->ConvertValue<float, 3>(position->mapped_index(i), &xyz[3 * i.value()]);
    return xyz;
}

int main(int argc, char **argv)
{
    if (argc != 2)
        return fail("usage: embed CLOUD.drc >POINTS");
    std::ifstream file(argv[1], std::ios::binary);
    std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
    std::vector<float> xyz = decode(bytes);
    vor_failure failure;
    vor_call call = {};
    vor_points points = {};

    if (xyz.empty())
        return fail(std::string(argv[1]) + " is no Draco cloud");
    call.threads = vor_threads_start(2, &failure);
    points.n = xyz.size() / 3;
    points.xyz = xyz.data();
    if (call.threads == nullptr || vor_restore(&points, &call, &failure) != 0)
        return fail(failure.message);
    vor_threads_end(call.threads);
    return std::fwrite(xyz.data(), sizeof(float), xyz.size(), stdout) == xyz.size() ? 0 : 1;
}
