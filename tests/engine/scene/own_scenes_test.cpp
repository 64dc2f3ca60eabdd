// The project's own scenes in assets/scenes: what they are, and that the files are up to date.
#include "assets/scenes/gltf_writer.h"
#include "assets/scenes/shapes.h"
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

double volume_of(const contact::TriangleSoup &surface) {
    double six_volumes = 0.0;
    for (const auto &[a, b, c] : corners_of(surface)) {
        six_volumes += a.dot(b.cross(c));
    }
    return six_volumes / 6.0;
}

using ExactPoint = std::array<double, 3>;

/// How often each directed edge is used, vertices at the same place being one.
std::map<std::pair<ExactPoint, ExactPoint>, int>
directed_edges(const contact::TriangleSoup &surface) {
    std::map<std::pair<ExactPoint, ExactPoint>, int> edges;
    const auto point = [](const Vector3 &v) { return ExactPoint{v.x(), v.y(), v.z()}; };
    for (const auto &corners : corners_of(surface)) {
        for (std::size_t i = 0; i < 3; ++i) {
            ++edges[{point(corners[i]), point(corners[(i + 1) % 3])}];
        }
    }
    return edges;
}

void expect_closed_and_consistently_wound(const contact::TriangleSoup &surface) {
    const auto edges = directed_edges(surface);
    for (const auto &[edge, uses] : edges) {
        ASSERT_NE(edge.first, edge.second);
        ASSERT_EQ(uses, 1); // manifold, and neighbours run along it in opposite directions
        ASSERT_EQ(edges.count({edge.second, edge.first}), 1U);
    }
}

/// V − E + F of the welded surface: 2 for each closed surface without handles.
long euler_characteristic(const contact::TriangleSoup &surface) {
    std::set<ExactPoint> points;
    for (const auto &corners : corners_of(surface)) {
        for (const Vector3 &corner : corners) {
            points.insert({corner.x(), corner.y(), corner.z()});
        }
    }
    return static_cast<long>(points.size()) -
           static_cast<long>(directed_edges(surface).size() / 2) +
           static_cast<long>(surface.triangles.size());
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
        expect_closed_and_consistently_wound(scene.surface);
        EXPECT_GT(volume_of(scene.surface), 0.0);
        EXPECT_EQ(euler_characteristic(scene.surface),
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

TEST(OwnScenes, PlateIsTheSlabItSays) {
    const Scene scene = load_own("plate");
    EXPECT_EQ(scene.surface.triangles.size(), 12U);
    const double expected_m3 = 0.120 * 0.010 * 0.080;
    EXPECT_NEAR(volume_of(scene.surface), expected_m3, 10 * kSinglePrecision * expected_m3);
    EXPECT_NEAR(scene.upper_m.y(), -0.005, kSinglePrecision);
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

TEST(OwnScenes, SteppedBlockIsThreeStepsLessPocketAndGroove) {
    const Scene scene = load_own("stepped_block");
    const double steps_mm3 = 40.0 * 80.0 * (15.0 + 33.0 + 51.0);
    const double pocket_mm3 = 20.0 * 12.0 * 20.0;
    const double groove_mm3 = 40.0 * 12.0 * 10.0;
    const double expected_m3 = 1e-9 * (steps_mm3 - pocket_mm3 - groove_mm3);
    EXPECT_NEAR(volume_of(scene.surface), expected_m3, 10 * kSinglePrecision * expected_m3);
}

TEST(OwnScenes, OrganicLiesOnItsBlobsLevelAndIsStarShaped) {
    const std::vector<scenes::SceneDescription> all = scenes::all_scenes();
    const auto organic = std::find_if(all.begin(), all.end(),
                                      [](const auto &scene) { return scene.name == "organic"; });
    ASSERT_NE(organic, all.end());
    const scenes::Part &part = organic->parts.front();
    EXPECT_EQ(part.triangles.size(), 30'420U);
    EXPECT_EQ(part.colours.size(), part.positions_m.size());
    const auto field = [](const Vector3 &p) {
        double sum = 0.0;
        for (const rig::Blob &blob : rig::organic_shape().blobs) {
            const double d = (p - blob.centre).norm() / blob.radius;
            sum += d < 1.0 ? std::pow(1.0 - d * d, 3) : 0.0;
        }
        return sum;
    };
    for (std::size_t i = 0; i < part.positions_m.size(); ++i) {
        const Vector3 &p = part.positions_m[i];
        ASSERT_NEAR(field(p), rig::organic_shape().level, 1e-12);
        // The normal agrees with the field's steepest descent, by central differences.
        constexpr double kStep = 1e-5;
        Vector3 descent;
        for (int axis = 0; axis < 3; ++axis) {
            const Vector3 step = kStep * Vector3::Unit(axis);
            descent[axis] = (field(p - step) - field(p + step)) / (2.0 * kStep);
        }
        ASSERT_LT((descent.normalized() - part.normals[i]).norm(), 1e-6);
        // Along the ray from the origin it stays above the level before, below it after.
        for (const double share : {0.25, 0.5, 0.75, 0.95}) {
            ASSERT_GT(field(share * p), rig::organic_shape().level);
        }
        for (const double share : {1.05, 1.25, 1.5, 2.0}) {
            ASSERT_LT(field(share * p), rig::organic_shape().level);
        }
    }
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

TEST(OwnScenes, EachSaysInOneSentenceWhatToFeel) {
    std::set<std::string> titles;
    for (const scenes::SceneDescription &description : scenes::all_scenes()) {
        const Lesson lesson = load_own(description.name).lesson;
        EXPECT_TRUE(titles.insert(lesson.title).second) << lesson.title;
        EXPECT_EQ(lesson.title, description.lesson.title);
        EXPECT_EQ(lesson.feel, description.lesson.feel);
        EXPECT_EQ(std::ranges::count(lesson.feel, '.'), 1) << lesson.feel;
        EXPECT_TRUE(lesson.feel.ends_with('.')) << lesson.feel;
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

TEST(OwnScenes, SlopesAreAsSteepAsTheyAreMade) {
    const auto volume_m3 = [](const std::string &name) {
        return volume_of(load_own(name).surface);
    };
    // Shearing changes no volume.
    EXPECT_NEAR(volume_m3("slope"), 0.110 * 0.012 * 0.070, 10 * kSinglePrecision * 1e-4);
    EXPECT_NEAR(volume_m3("wrong_direction"), 0.070 * 0.009 * 0.048, 10 * kSinglePrecision * 1e-4);
    const Scene slope = load_own("slope");
    EXPECT_NEAR(slope.upper_m.y() - slope.lower_m.y(), 0.012 + 0.4 * 0.110, kSinglePrecision);
}

TEST(OwnScenes, TheThinPlateIsAsThinAsItSays) {
    const Scene scene = load_own("thin_plate");
    EXPECT_NEAR(scene.upper_m.y() - scene.lower_m.y(), 0.001, kSinglePrecision);
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

TEST(OwnScenes, ProfileIsARailInTheLinkagesPlane) {
    const Scene scene = load_own("profile");
    EXPECT_TRUE(scene.planar);
    EXPECT_NEAR(scene.lower_m.x(), -0.030, kSinglePrecision);
    EXPECT_NEAR(scene.upper_m.x(), 0.030, kSinglePrecision);
    // The area between profile and floor by hand, trapezium by trapezium [mm²].
    const double area_mm2 = 10 * 15.0 + 15 * 20.0 + 8 * 23.5 + 14 * 22.0 + 2 * 19.0 + 10 * 16.0 +
                            4 * 14.0 + 4 * 14.0 + 13 * 16.0;
    const double expected_m3 = 60.0 * area_mm2 * 1e-9;
    EXPECT_NEAR(volume_of(scene.surface), expected_m3, 10 * kSinglePrecision * expected_m3);
}

TEST(OwnScenes, EachSaysWhatACheaperModelMayBeOff) {
    for (const scenes::SceneDescription &description : scenes::all_scenes()) {
        const Scene scene = load_own(description.name);
        EXPECT_EQ(scene.tolerance.force_N, description.tolerance.force_N);
        EXPECT_NEAR(scene.tolerance.direction_rad,
                    description.tolerance.direction_deg * M_PI / 180.0, 1e-15);
        EXPECT_EQ(scene.tolerance.bandwidth_hz, description.tolerance.bandwidth_hz);
        EXPECT_EQ(scene.planar, description.planar);
    }
}

TEST(OwnScenes, TheZeroPoseStartsOutsideWhatIsInMetres) {
    for (const scenes::SceneDescription &description : scenes::all_scenes()) {
        const std::string &name = description.name;
        if (!description.in_metres) {
            continue;
        }
        // The solid angle of a closed surface around the origin is 0 from outside, 4π from inside.
        double solid_angle = 0.0;
        for (const auto &[a, b, c] : corners_of(load_own(name).surface)) {
            const double product = a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                   b.dot(c) * a.norm() + c.dot(a) * b.norm();
            solid_angle += 2.0 * std::atan2(a.dot(b.cross(c)), product);
        }
        EXPECT_NEAR(solid_angle, 0.0, 1e-6) << name;
    }
}

TEST(OwnScenes, GeodesicSphereHasTheVerticesThatEulerAsksFor) {
    for (const int f : {1, 2, 5, 9}) {
        const scenes::Part sphere = scenes::geodesic_sphere(f);
        EXPECT_EQ(sphere.triangles.size(), static_cast<std::size_t>(20 * f * f));
        EXPECT_EQ(sphere.positions_m.size(), static_cast<std::size_t>(10 * f * f + 2));
    }
}

} // namespace
} // namespace springdrive::scene
