/* PCL's registration without a first guess, the peer of the benchmark: both clouds are thinned to a
 * voxel grid of a sixtieth of the reference's diagonal, FPFH features are matched by SAC-IA, and
 * ICP refines. Other parameters are those of PCL's tutorials, as multiples of the voxel. Prints the
 * CPU seconds and the 4 x 4 matrix, row by row. One thread.
 *
 * usage: register CLOUD REFERENCE, each raw float32 x, y, z. */
#include <pcl/common/common.h>
#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/ia_ransac.h>
#include <pcl/registration/icp.h>

#include <cstdio>
#include <ctime>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Features = pcl::PointCloud<pcl::FPFHSignature33>;

static Cloud::Ptr read(const char *path)
{
    Cloud::Ptr cloud(new Cloud);
    std::FILE *in = std::fopen(path, "rb");
    float x[3];

    while (in != nullptr && std::fread(x, sizeof *x, 3, in) == 3)
        cloud->push_back({x[0], x[1], x[2]});
    if (in != nullptr)
        std::fclose(in);
    return cloud;
}

static Cloud::Ptr thinned(const Cloud::Ptr &cloud, float voxel)
{
    Cloud::Ptr out(new Cloud);
    pcl::VoxelGrid<pcl::PointXYZ> grid;

    grid.setInputCloud(cloud);
    grid.setLeafSize(voxel, voxel, voxel);
    grid.filter(*out);
    return out;
}

static Features::Ptr features_of(const Cloud::Ptr &cloud, float voxel)
{
    pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
    Features::Ptr out(new Features);
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> normal;
    pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> feature;

    normal.setInputCloud(cloud);
    normal.setRadiusSearch(2 * voxel);
    normal.compute(*normals);
    feature.setInputCloud(cloud);
    feature.setInputNormals(normals);
    feature.setRadiusSearch(5 * voxel);
    feature.compute(*out);
    return out;
}

int main(int argc, char **argv)
{
    if (argc != 3)
        return 2;
    Cloud::Ptr cloud = read(argv[1]), reference = read(argv[2]);
    std::clock_t began = std::clock();
    pcl::PointXYZ low, high;
    pcl::getMinMax3D(*reference, low, high);
    const float diagonal = (high.getVector3fMap() - low.getVector3fMap()).norm(),
                voxel = diagonal / 60;
    cloud = thinned(cloud, voxel);
    reference = thinned(reference, voxel);
    pcl::SampleConsensusInitialAlignment<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> first;
    Cloud moved;
    first.setInputSource(cloud);
    first.setSourceFeatures(features_of(cloud, voxel));
    first.setInputTarget(reference);
    first.setTargetFeatures(features_of(reference, voxel));
    first.setMinSampleDistance(10 * voxel);
    first.setMaxCorrespondenceDistance(4 * voxel);
    first.setMaximumIterations(500);
    first.align(moved);
    pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
    icp.setInputSource(cloud);
    icp.setInputTarget(reference);
    icp.setMaxCorrespondenceDistance(3 * voxel);
    icp.setMaximumIterations(100);
    icp.align(moved, first.getFinalTransformation());
    const Eigen::Matrix4f m = icp.getFinalTransformation();
    std::printf("%.3f", double(std::clock() - began) / CLOCKS_PER_SEC);
    for (int i = 0; i < 16; i++)
        std::printf(" %.9g", double(m(i / 4, i % 4)));
    std::printf("\n");
    return 0;
}
