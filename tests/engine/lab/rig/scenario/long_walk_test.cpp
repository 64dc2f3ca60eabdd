// A million steps at random over every scene that we have, ours and others': nothing is crossed.
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/rig/plain_triangles.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/scene_surface.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace springdrive::rig {
namespace {

std::vector<std::string> scene_files() {
    std::vector<std::string> files;
    for (const char *folder : {SPRINGDRIVE_ASSET_DIR "/scenes", SPRINGDRIVE_MODELS_DIR}) {
        if (std::filesystem::is_directory(folder)) {
            for (const auto &entry : std::filesystem::directory_iterator(folder)) {
                const std::string extension = entry.path().extension();
                if (extension == ".gltf" || extension == ".glb") {
                    files.push_back(entry.path());
                }
            }
        }
    }
    std::ranges::sort(files);
    return files;
}

std::string name_of(const ::testing::TestParamInfo<std::string> &info) {
    std::string name = std::filesystem::path(info.param).stem();
    std::ranges::replace_if(
        name, [](char c) { return std::isalnum(c) == 0; }, '_');
    return name;
}

class LongWalk : public ::testing::TestWithParam<std::string> {};

TEST_P(LongWalk, CrossesNothing) {
    const int steps = testing::cases(20'000, 1'000'000);
    const scene::Scene scene = touch_scene(GetParam(), testing::phantom_1_0().workspace);
    const contact::HapticSurface surface = scene::haptic_surface_of(scene);
    const std::vector<PlainTriangle> triangles =
        plain_triangles(contact::prepare_mesh(scene.surface).facets);
    const NearbyTriangles finder(triangles);
    const Vector3 middle_m = 0.5 * (scene.lower_m + scene.upper_m);
    const Vector3 half_m = 0.6 * (scene.upper_m - scene.lower_m) + Vector3::Constant(2e-3);
    std::mt19937_64 random(1);
    Vector3 tip_m = middle_m + half_m;
    Vector3 heading = -half_m.normalized();
    contact::Proxy proxy;
    proxy.reset(tip_m);
    int touching = 0;
    for (int step = 0; step < steps; ++step) {
        // 0.2 m/s at 1 kHz.
        heading = (heading + 0.2 * testing::random_direction(random)).normalized();
        tip_m += 2e-4 * heading;
        for (int axis = 0; axis < 3; ++axis) {
            if (std::abs(tip_m[axis] - middle_m[axis]) > half_m[axis]) {
                heading[axis] = std::copysign(heading[axis], middle_m[axis] - tip_m[axis]);
            }
        }
        const contact::Contact contact = proxy.update(surface, tip_m);
        touching += contact.touching ? 1 : 0;
        const contact::ProxyPath &path = proxy.path();
        for (std::size_t piece = 0; piece + 1 < path.size(); ++piece) {
            ASSERT_FALSE(finder.crossed(path[piece], path[piece + 1])) << "step " << step;
        }
    }
    EXPECT_GT(touching, steps / 10); // not vacuous
}

INSTANTIATE_TEST_SUITE_P(EveryScene, LongWalk, ::testing::ValuesIn(scene_files()), name_of);

} // namespace
} // namespace springdrive::rig
