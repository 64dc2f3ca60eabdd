#include "tests/bench/other_libraries.h"

#ifdef SPRINGDRIVE_HAS_FCL

#include "tests/bench/stopwatch.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cstddef>
#include <memory>

namespace springdrive::bench {

namespace {

constexpr double kBallRadius_m = 1e-4;

using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Model> build_model(const contact::TriangleSoup &soup) {
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(soup.triangles.size());
    for (const auto &[a, b, c] : soup.triangles) {
        triangles.emplace_back(a, b, c);
    }
    auto model = std::make_shared<Model>();
    model->beginModel();
    model->addSubModel(soup.vertices_m, triangles);
    model->endModel();
    return model;
}

} // namespace

std::optional<Answers> time_fcl(const contact::TriangleSoup &soup,
                                const std::vector<Vector3> &tips_m, std::size_t queries) {
    const fcl::CollisionObjectd surface(build_model(soup));
    fcl::CollisionObjectd ball(std::make_shared<fcl::Sphered>(kBallRadius_m));
    const fcl::DistanceRequestd request;
    Answers answers;
    answers.distances_m.resize(std::min(queries, tips_m.size()));
    std::vector<double> times_ns;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        for (std::size_t i = 0; i < answers.distances_m.size(); ++i) {
            times_ns.push_back(time_ns([&] {
                ball.setTranslation(tips_m[i]);
                ball.computeAABB();
                fcl::DistanceResultd result;
                answers.distances_m[i] =
                    fcl::distance(&surface, &ball, request, result) + kBallRadius_m;
            }));
        }
    }
    answers.floor_ns = min_of_repeats(times_ns);
    return answers;
}

} // namespace springdrive::bench

#else

namespace springdrive::bench {

std::optional<Answers> time_fcl(const contact::TriangleSoup & /*soup*/,
                                const std::vector<Vector3> & /*tips_m*/, std::size_t /*queries*/) {
    return std::nullopt;
}

} // namespace springdrive::bench

#endif
