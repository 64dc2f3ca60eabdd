// The project's own scenes in assets/scenes: what they are, and that the files are up to date. And
// real models, made by other people's programs: their triangle counts were taken from the files'
// JSON by a separate script, index counts of the primitives, summed over the nodes of the default
// scene.
#include "assets/scenes/gltf_writer.h"
#include "assets/scenes/shapes.h"
#include "engine/scene/gltf.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/scene/gltf_builder.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

namespace springdrive::scene {
namespace {

constexpr double kSinglePrecision = 1e-6; // relative, of coordinates that were stored as floats

std::filesystem::path scene_file(const std::string &name) {
    return std::filesystem::path(SPRINGDRIVE_ASSET_DIR) / "scenes" / (name + ".gltf");
}

device::Workspace phantom_1_0_workspace() {
    return {Vector3(0.0, 0.030, -0.015), Vector3(0.254, 0.178, 0.127)};
}

Scene load_own(const std::string &name) {
    return load_gltf(scene_file(name), phantom_1_0_workspace());
}

/// Corners as values that compare: vertices at the same place are one.
std::vector<std::array<testing::PlaceKey, 3>> places_of(const contact::TriangleSoup &surface) {
    std::vector<std::array<testing::PlaceKey, 3>> places;
    for (const auto &[a, b, c] : corners_of(surface)) {
        places.push_back({testing::place_key(a), testing::place_key(b), testing::place_key(c)});
    }
    return places;
}

/// V − E + F of the welded surface: 2 for each closed surface without handles.
long euler_characteristic(const std::vector<std::array<testing::PlaceKey, 3>> &triangles) {
    std::set<testing::PlaceKey> points;
    for (const auto &triangle : triangles) {
        points.insert(triangle.begin(), triangle.end());
    }
    return static_cast<long>(points.size()) -
           static_cast<long>(testing::edge_counts(triangles).size()) +
           static_cast<long>(triangles.size());
}

TEST(OwnScenes, FilesAreWhatTheGeneratorWrites) {
    std::uintmax_t total = 0;
    for (const scenes::SceneDescription &scene : scenes::all_scenes()) {
        const std::filesystem::path file = scene_file(scene.name);
        std::ifstream stream(file, std::ios::binary);
        std::ostringstream text;
        text << stream.rdbuf();
        EXPECT_TRUE(text.str() == scenes::to_gltf(scene))
            << file << " is out of date; run generate_scenes assets/scenes";
        EXPECT_LT(text.str().size(), 1'500'000U);
        total += text.str().size();
    }
    EXPECT_LT(total, 3'000'000U);
}

TEST(OwnScenes, EveryOneIsClosedWoundOutwardsAndWithinTheWorkspace) {
    for (const scenes::SceneDescription &description : scenes::all_scenes()) {
        SCOPED_TRACE(description.name);
        const Scene scene = load_own(description.name);
        EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
        EXPECT_EQ(scene.in_metres, description.in_metres);
        EXPECT_EQ(scene.planar, description.planar);
        EXPECT_EQ(scene.tolerance.force_N, description.tolerance.force_N);
        EXPECT_EQ(scene.lesson.feel, description.lesson.feel);
        EXPECT_TRUE(testing::is_watertight(places_of(scene.surface)));
        EXPECT_GT(volume_of(scene.surface), 0.0);
        EXPECT_EQ(euler_characteristic(places_of(scene.surface)),
                  2 * static_cast<long>(description.parts.size()));
    }
}

TEST(OwnScenes, NormalsPointOutOfTheTrianglesThatTheyLight) {
    for (const scenes::SceneDescription &description : scenes::all_scenes()) {
        for (const scenes::Part &part : description.parts) {
            for (const auto &[a, b, c] : part.triangles) {
                const Vector3 face = (part.positions_m[b] - part.positions_m[a])
                                         .cross(part.positions_m[c] - part.positions_m[a]);
                for (const std::uint32_t corner : {a, b, c}) {
                    ASSERT_NEAR(part.normals[corner].norm(), 1.0, 1e-12);
                    ASSERT_GT(part.normals[corner].dot(face), 0.0) << description.name;
                }
            }
        }
    }
}

TEST(OwnScenes, HaveTheVolumesOfTheirParts) {
    struct Case {
        const char *name;
        double expected_mm3;
    };
    const double steps_mm3 = 40.0 * 80.0 * (15.0 + 33.0 + 51.0); // less a pocket and a groove
    // The area between profile and floor by hand, trapezium by trapezium.
    const double profile_mm2 = 10 * 15.0 + 15 * 20.0 + 8 * 23.5 + 14 * 22.0 + 2 * 19.0 + 10 * 16.0 +
                               4 * 14.0 + 4 * 14.0 + 13 * 16.0;
    for (const Case &one :
         std::vector<Case>{{"plate", 120.0 * 10.0 * 80.0},
                           {"stepped_block", steps_mm3 - 20.0 * 12.0 * 20.0 - 40.0 * 12.0 * 10.0},
                           {"slope", 110.0 * 12.0 * 70.0}, // shearing changes no volume
                           {"wrong_direction", 70.0 * 9.0 * 48.0},
                           {"profile", 60.0 * profile_mm2}}) {
        EXPECT_NEAR(1e9 * volume_of(load_own(one.name).surface), one.expected_mm3,
                    10 * kSinglePrecision * one.expected_mm3)
            << one.name;
    }
    const Scene thin = load_own("thin_plate");
    EXPECT_NEAR(thin.upper_m.y() - thin.lower_m.y(), 0.001, kSinglePrecision);
    const Scene slope = load_own("slope");
    EXPECT_NEAR(slope.upper_m.y() - slope.lower_m.y(), 0.012 + 0.4 * 0.110, kSinglePrecision);
    EXPECT_NEAR(load_own("profile").upper_m.x(), 0.030, kSinglePrecision);
}

TEST(OwnScenes, SphereFallsShortOfItsVolumeByNoMoreThanItsFacetsAllow) {
    const Scene scene = load_own("sphere");
    const double r = scenes::kSphereRadius_m;
    EXPECT_EQ(scene.surface.triangles.size(), 20'480U);
    const Vector3 centre_m = 0.5 * (scene.lower_m + scene.upper_m);
    double longest_m = 0.0;
    for (const auto &corners : corners_of(scene.surface)) {
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_NEAR((corners[i] - centre_m).norm(), r, kSinglePrecision * r);
            longest_m = std::max(longest_m, (corners[i] - corners[(i + 1) % 3]).norm());
        }
    }
    // A triangle with edges up to a has a circumradius up to a/√3, so its plane is at least
    // √(r² − a²/3) from the centre: the solid contains that ball and lies within the sphere.
    const double inner_m = std::sqrt(r * r - longest_m * longest_m / 3.0);
    const double ball = 4.0 / 3.0 * M_PI;
    EXPECT_LT(volume_of(scene.surface), ball * r * r * r);
    EXPECT_GT(volume_of(scene.surface), ball * inner_m * inner_m * inner_m);
    EXPECT_GT(inner_m / r, 0.999); // so the bracket means something: 0.3 % of the volume
}

TEST(OwnScenes, CompliancePadsAreAsSoftAsTheirCaptionsSay) {
    const Scene scene = load_own("compliance");
    ASSERT_EQ(scene.surface.materials.size(), scenes::kPadEta.size());
    ASSERT_EQ(scene.captions.size(), scenes::kPadEta.size());
    EXPECT_EQ(scene.surface.materials.front().eta, 0.0);
    EXPECT_EQ(scene.surface.materials.back().eta, 0.9);
    for (std::size_t i = 0; i < scenes::kPadEta.size(); ++i) {
        std::ostringstream caption;
        caption << "η " << scene.surface.materials[i].eta;
        EXPECT_EQ(scene.captions[i].text, caption.str());
        const Vector3 &at_m = scene.captions[i].at_m; // on the pad's upper side
        EXPECT_NEAR(at_m.x(), 0.025 * (static_cast<double>(i) - 2.0), kSinglePrecision);
        EXPECT_NEAR(at_m.y(), -0.005, kSinglePrecision);
    }
}

TEST(OwnScenes, TheSpotOfTheWrongDirectionLiesOnItsOrangeSquare) {
    const Scene scene = load_own("wrong_direction");
    ASSERT_TRUE(scene.lesson.spot);
    const TouchSpot &spot = *scene.lesson.spot;
    EXPECT_NEAR(spot.normal.norm(), 1.0, 1e-12);
    std::size_t orange = 0;
    for (const VisualVertex &vertex : scene.meshes.front().vertices) {
        if (vertex.colour[0] > 2.0F * vertex.colour[2]) {
            const Vector3 off_m =
                Vector3(vertex.position_m[0], vertex.position_m[1], vertex.position_m[2]) -
                spot.point_m;
            EXPECT_NEAR(off_m.dot(spot.normal), 0.0, kSinglePrecision);
            EXPECT_NEAR(off_m.x() * off_m.x(), 0.006 * 0.006, kSinglePrecision);
            EXPECT_NEAR(off_m.z() * off_m.z(), 0.006 * 0.006, kSinglePrecision);
            ++orange;
        }
    }
    EXPECT_EQ(orange, 4U);
    for (const scenes::SceneDescription &other : scenes::all_scenes()) {
        EXPECT_EQ(load_own(other.name).lesson.spot.has_value(), other.name == "wrong_direction");
    }
}

/// Both spheres are of the same triangles; the right one's are bent.
TEST(OwnScenes, OfThePairOneIsCoarseAndOneIsRound) {
    const Scene scene = load_own("spheres");
    const auto roughness = [&](double side) { // largest share of the radius that is missing
        const Vector3 centre_m(side * 0.033, -0.0315, -0.015);
        double largest = 0.0;
        for (const auto &[a, b, c] : corners_of(scene.surface)) {
            const Vector3 middle_m = (a + b + c) / 3.0;
            if (side * middle_m.x() > 0.0) {
                largest = std::max(
                    largest, std::abs(1.0 - (middle_m - centre_m).norm() / scenes::kPairRadius_m));
            }
        }
        return largest;
    };
    // With edges a of the radius, the middle of a facet is 1 − √(1 − a²/3) below the sphere: of 80
    // triangles a is up to 0.62.
    EXPECT_NEAR(roughness(-1.0), 1.0 - std::sqrt(1.0 - 0.62 * 0.62 / 3.0), 0.01);
    EXPECT_LT(roughness(1.0), 0.01);
    EXPECT_GT(scene.surface.triangles.size(), 2000U);
    EXPECT_EQ(scene.flat_surface.triangles.size(), 160U);
}

TEST(OwnScenes, TheZeroPoseStartsOutsideWhatIsInMetres) {
    for (const scenes::SceneDescription &description : scenes::all_scenes()) {
        if (description.in_metres) {
            EXPECT_NEAR(
                testing::winding_number(load_own(description.name).surface, Vector3::Zero()), 0.0,
                1e-6)
                << description.name;
        }
    }
}

TEST(GltfModels, LoadWhole) {
    if (!std::filesystem::is_directory(SPRINGDRIVE_MODELS_DIR)) {
        GTEST_SKIP() << "no models to load: there is no folder " << SPRINGDRIVE_MODELS_DIR;
    }
    struct Case {
        const char *name;
        std::size_t triangles;
        std::size_t materials;
        std::size_t textures;
    };
    // Of the engine's meshes, 75,730 triangles, several stand in more than one place.
    for (const Case &one : std::vector<Case>{{"Box.glb", 12, 1, 0},
                                             {"2CylinderEngine.glb", 121'496, 67, 0},
                                             {"chr_knight.glb", 1460, 1, 1},
                                             {"ShapeCollection.glb", 3542, 7, 0},
                                             {"DenseSphere.glb", 30'720, 1, 0}}) {
        SCOPED_TRACE(one.name);
        const Scene scene =
            load_gltf(std::filesystem::path(SPRINGDRIVE_MODELS_DIR) / one.name, small_workspace());
        EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
        const Vector3 extent_m = scene.upper_m - scene.lower_m;
        EXPECT_NEAR(extent_m.cwiseQuotient(small_workspace().size_m).maxCoeff(), 0.6, 1e-12);
        EXPECT_EQ(scene.surface.triangles.size(), one.triangles);
        EXPECT_EQ(scene.surface.material_of_triangle.size(), one.triangles);
        EXPECT_EQ(scene.surface.materials.size(), one.materials);
        EXPECT_EQ(scene.textures.size(), one.textures);
        std::size_t drawn = 0;
        for (const VisualMesh &mesh : scene.meshes) {
            drawn += mesh.indices.size() / 3;
            EXPECT_EQ(mesh.texture, static_cast<int>(one.textures) - 1);
        }
        EXPECT_EQ(drawn, one.triangles);
        if (std::string(one.name) != "DenseSphere.glb") {
            continue;
        }
        // Once decompressed, its vertices lie about 1 % within the sphere of its farthest ones at
        // most. Its uncompressed bounds stand in the file: ±32555 by ±32767 by ±32575; Draco
        // rounded to 14 bits.
        const auto radius_m = [](const Vector3 &vertex) {
            return (vertex - small_workspace().centre_m).norm();
        };
        const auto [nearest, farthest] =
            std::ranges::minmax(scene.surface.vertices_m, {}, radius_m);
        EXPECT_GT(radius_m(nearest), 0.989 * radius_m(farthest));
        EXPECT_NEAR(extent_m.x() / extent_m.y(), 32555.0 / 32767.0, 2.0 / 16384.0);
        EXPECT_NEAR(extent_m.z() / extent_m.y(), 32575.0 / 32767.0, 2.0 / 16384.0);
    }
}

} // namespace
} // namespace springdrive::scene
