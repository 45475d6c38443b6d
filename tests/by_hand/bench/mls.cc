/* PCL's upsampling by moving least squares, the peer of the benchmark: SAMPLE_LOCAL_PLANE, by which
 * each point becomes the four corners of a square on the quadric around it. Lengths are in mean
 * distances to the nearest point. Of 20,000 points of armadillo_vox120k the delta at SIDE .5 / .6 /
 * .7 is .38 / .49 / .52, and at RADIUS 4 / 5 / 8 the result is .21 / .24 / .57 thousandths of the
 * diagonal off the surface (rms); at 4 some of its points in a room are 3.7 spacings off, at 3 some
 * of the armadillo's 500. Prints the CPU seconds. One thread.
 *
 * usage: mls IN OUT, each raw float32 x, y, z. */
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/impl/mls.hpp>
#include <pcl/surface/impl/processing.hpp>

#include <cstdio>
#include <ctime>

#define SIDE 0.5
#define RADIUS 5.0

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

int main(int argc, char **argv)
{
    if (argc != 3)
        return 2;
    Cloud::Ptr cloud(new Cloud);
    Cloud out;
    std::FILE *file = std::fopen(argv[1], "rb");
    float x[3];
    while (file != nullptr && std::fread(x, sizeof *x, 3, file) == 3)
        cloud->push_back({x[0], x[1], x[2]});
    std::clock_t began = std::clock();
    pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
    tree->setInputCloud(cloud);
    double spacing = 0;
    for (const pcl::PointXYZ &point : *cloud) {
        pcl::Indices index;
        std::vector<float> distance2;
        tree->nearestKSearch(point, 2, index, distance2);
        spacing += std::sqrt(distance2[1]) / cloud->size();
    }
    pcl::MovingLeastSquares<pcl::PointXYZ, pcl::PointXYZ> mls;
    mls.setInputCloud(cloud);
    mls.setSearchMethod(tree);
    mls.setPolynomialOrder(2);
    mls.setSearchRadius(RADIUS * spacing);
    mls.setUpsamplingMethod(mls.SAMPLE_LOCAL_PLANE);
    mls.setUpsamplingRadius(1.5 * SIDE * spacing); /* within it four corners of the grid */
    mls.setUpsamplingStepSize(SIDE * spacing);
    mls.process(out);
    std::printf("%.3f\n", double(std::clock() - began) / CLOCKS_PER_SEC);
    file = std::fopen(argv[2], "wb");
    for (const pcl::PointXYZ &point : out)
        std::fwrite(&point.x, sizeof(float), 3, file);
    return std::fclose(file);
}
