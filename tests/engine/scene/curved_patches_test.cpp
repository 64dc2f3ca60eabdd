// Covers engine/scene/curved_patches.cpp and gltf_mesh.cpp, also as it is felt: 80 triangles,
// smoothed, under a proxy.
#include "base/degrees.h"
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/scene/curved_patches.h"
#include "engine/scene/gltf_mesh.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/scene/gltf_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <tuple>

namespace springdrive::scene {
namespace {

constexpr double kRadius_m = 0.04;
constexpr double kRadian = 180.0 / std::numbers::pi;
constexpr double kSumRounding_m = 1e-16; // of a sum of a few coordinates of 0.04 m

SmoothMesh sphere(int level) {
    const contact::TriangleSoup soup = testing::icosphere(level, kRadius_m);
    SmoothMesh mesh{soup.vertices_m, {}, soup.triangles};
    for (const Vector3 &vertex : mesh.positions) {
        mesh.normals.push_back(vertex.normalized());
    }
    return mesh;
}

/// Three vertices for each triangle, all with the normal that `normal_at(corner, facet normal)`
/// gives.
template <typename NormalAt> SmoothMesh split(const SmoothMesh &mesh, NormalAt &&normal_at) {
    SmoothMesh result;
    for (const auto &[a, b, c] : mesh.triangles) {
        const Vector3 &corner = mesh.positions[a];
        const Vector3 facet =
            (mesh.positions[b] - corner).cross(mesh.positions[c] - corner).normalized();
        const auto first = static_cast<std::uint32_t>(result.positions.size());
        for (const std::uint32_t vertex : {a, b, c}) {
            result.positions.push_back(mesh.positions[vertex]);
            result.normals.push_back(normal_at(mesh.positions[vertex], facet));
        }
        result.triangles.push_back({first, first + 1, first + 2});
    }
    return result;
}

/// Around the y axis, closed by flat ends; without normals.
SmoothMesh prism(int sides, double radius_m, double half_height_m) {
    const contact::TriangleSoup soup = testing::lathed({{0.0, -half_height_m},
                                                        {radius_m, -half_height_m},
                                                        {radius_m, half_height_m},
                                                        {0.0, half_height_m}},
                                                       sides);
    return {soup.vertices_m, {}, soup.triangles};
}

/// A prism with a cylinder's normals: radial on the mantle, axial on the ends.
SmoothMesh cylinder(int sides, double radius_m, double half_height_m) {
    return split(prism(sides, radius_m, half_height_m), [](const Vector3 &p, const Vector3 &facet) {
        return std::abs(facet.y()) > 0.5 ? facet : Vector3(p.x(), 0.0, p.z()).normalized();
    });
}

Vector3 facet_normal(const SmoothMesh &mesh, std::size_t triangle) {
    const auto &[a, b, c] = mesh.triangles[triangle];
    const Vector3 &corner = mesh.positions[a];
    return (mesh.positions[b] - corner).cross(mesh.positions[c] - corner).normalized();
}

using Place = std::tuple<double, double, double>; // to the last bit
Place place(const Vector3 &p) { return {p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}; }

/// The triangles at each edge, and by how much those that run it backwards outnumber the others.
struct EdgeUse {
    std::vector<std::size_t> triangles;
    int balance = 0;
};

std::map<std::pair<Place, Place>, EdgeUse> edges_of(const SmoothMesh &mesh) {
    std::map<std::pair<Place, Place>, EdgeUse> edges;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::size_t e = 0; e < 3; ++e) {
            const Place from = place(mesh.positions[mesh.triangles[t][e]]);
            const Place to = place(mesh.positions[mesh.triangles[t][(e + 1) % 3]]);
            EdgeUse &use = edges[std::minmax(from, to)];
            use.triangles.push_back(t);
            use.balance += from < to ? 1 : -1;
        }
    }
    return edges;
}

/// Every edge has two triangles, which run it in opposite ways: no crack, nothing turned over.
void expect_closed(const SmoothMesh &mesh) {
    std::size_t open = 0;
    for (const auto &[edge, use] : edges_of(mesh)) {
        open += use.triangles.size() == 2 && use.balance == 0 ? 0 : 1;
    }
    EXPECT_EQ(open, 0U);
}

double max_dihedral_deg(const SmoothMesh &mesh) {
    double maximum = 0.0;
    for (const auto &[edge, use] : edges_of(mesh)) {
        const Vector3 a = facet_normal(mesh, use.triangles.front());
        const Vector3 b = facet_normal(mesh, use.triangles.back());
        maximum = std::max(maximum, std::atan2(a.cross(b).norm(), a.dot(b)) * kRadian);
    }
    return maximum;
}

SmoothMesh cut_all(const SmoothMesh &mesh, std::size_t cuts) {
    return CurvedPatches(mesh).cut(cuts, 0, mesh.triangles.size());
}

TEST(CurvedPatches, EightyTrianglesWithRadialNormalsBecomeASphere) {
    const SmoothMesh coarse = sphere(1);
    const std::size_t cuts = CurvedPatches(coarse).cuts_for(0.5 / kRadian, 128);
    const SmoothMesh fine = cut_all(coarse, cuts);
    for (std::size_t i = 0; i < fine.positions.size(); ++i) {
        // Measured: from −4.0e-6 to +1.4e-5 of the radius, 0.6 µm. The paper's patches: −6.4e-3.
        EXPECT_NEAR(fine.positions[i].norm() / kRadius_m, 1.0, 2e-5);
        // Measured: 0.084°.
        const Vector3 radial = fine.positions[i].normalized();
        EXPECT_LT(std::acos(std::min(1.0, fine.normals[i].dot(radial))) * kRadian, 0.1);
        EXPECT_NEAR(fine.normals[i].norm(), 1.0, 1e-15);
    }
    for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
        EXPECT_GT(facet_normal(fine, t).dot(fine.positions[fine.triangles[t][0]]), 0.0);
    }
    EXPECT_LE(max_dihedral_deg(fine), 0.75); // also across the old edges; measured: 0.51°
    EXPECT_LT(fine.triangles.size(), 200'000U);
}

TEST(CurvedPatches, ThePatchPassesThroughTheCornersOfItsTriangleWithTheirNormals) {
    const SmoothMesh coarse = sphere(1);
    constexpr std::size_t kCuts = 5;
    const SmoothMesh fine = cut_all(coarse, kCuts);
    constexpr std::size_t kEach = (kCuts + 1) * (kCuts + 2) / 2;
    ASSERT_EQ(fine.positions.size(), kEach * coarse.triangles.size());
    ASSERT_EQ(fine.triangles.size(), kCuts * kCuts * coarse.triangles.size());
    for (std::size_t t = 0; t < coarse.triangles.size(); ++t) {
        const std::array<std::size_t, 3> corners{t * kEach, (t + 1) * kEach - 1, t * kEach + kCuts};
        for (const auto &[corner, at] : {std::pair{0, 0}, {1, 1}, {2, 2}}) {
            const std::uint32_t vertex = coarse.triangles[t][static_cast<std::size_t>(corner)];
            const std::size_t fine_vertex = corners[static_cast<std::size_t>(at)];
            EXPECT_EQ(fine.positions[fine_vertex], coarse.positions[vertex]);
            EXPECT_LT((fine.normals[fine_vertex] - coarse.normals[vertex]).norm(), 1e-15);
        }
    }
}

TEST(CurvedPatches, ACubeWithSplitNormalsStaysACube) {
    SmoothMesh corners = prism(4, kRadius_m, 0.5 * std::numbers::sqrt2 * kRadius_m); // a cube
    const SmoothMesh cube =
        split(corners, [](const Vector3 &, const Vector3 &facet) { return facet; });
    const CurvedPatches patches(cube);
    EXPECT_EQ(patches.cuts_for(0.5 / kRadian, 128), 1U);
    const SmoothMesh fine = patches.cut(6, 0, cube.triangles.size());
    expect_closed(fine);
    const Eigen::AngleAxisd upright(0.25 * std::numbers::pi, Vector3::UnitY());
    for (std::size_t i = 0; i < fine.positions.size(); ++i) {
        const Vector3 turned = upright * fine.positions[i];
        EXPECT_NEAR(turned.cwiseAbs().maxCoeff(), 0.5 * std::numbers::sqrt2 * kRadius_m,
                    kSumRounding_m);
        const Vector3 normal = upright * fine.normals[i];
        EXPECT_NEAR(normal.cwiseAbs().maxCoeff(), 1.0, 1e-14);
    }
}

TEST(CurvedPatches, TheRimOfACylinderIsSharpAndRound) {
    const SmoothMesh fine = cut_all(cylinder(16, kRadius_m, 0.03), 8);
    expect_closed(fine);
    std::size_t on_rim = 0;
    for (const auto &[edge, use] : edges_of(fine)) { // those between an end and the mantle
        const Vector3 a = facet_normal(fine, use.triangles.front());
        const Vector3 b = facet_normal(fine, use.triangles.back());
        if (std::abs(a.y() - b.y()) > 0.9) {
            EXPECT_NEAR(std::hypot(std::get<0>(edge.first), std::get<2>(edge.first)) / kRadius_m,
                        1.0, 1e-7);
            ++on_rim;
        }
    }
    EXPECT_EQ(on_rim, 2U * 16U * 8U);
    for (const Vector3 &point : fine.positions) {
        const double from_axis_m = std::hypot(point.x(), point.z());
        EXPECT_LE(std::abs(point.y()), 0.03 + kSumRounding_m);
        if (std::abs(point.y()) < 0.03 - 1e-9) { // the mantle; measured: 5.2e-4, flat 1.9e-2
            EXPECT_NEAR(from_axis_m / kRadius_m, 1.0, 6e-4);
        } else { // a cubic's arc of 22.5° errs by 6.6e-8
            EXPECT_LT(from_axis_m / kRadius_m, 1.0 + 1e-7);
        }
    }
}

TEST(CurvedPatches, WhatIsClosedStaysClosedWhateverItsNormals) {
    std::mt19937_64 dice(20260732);
    std::normal_distribution<double> normal;
    const auto random = [&] { return Vector3(normal(dice), normal(dice), normal(dice)); };
    for (int i = 0; i < 30; ++i) {
        // From slightly to wildly off, shared by all triangles at a vertex, and not.
        const double disorder = std::pow(10.0, i % 5 - 3);
        SmoothMesh shared = sphere(1);
        for (std::size_t v = 0; v < shared.positions.size(); ++v) {
            shared.positions[v] += 0.1 * kRadius_m * disorder * random();
            shared.normals[v] = (shared.normals[v] + disorder * random()).normalized();
        }
        expect_closed(cut_all(shared, 5));
        const SmoothMesh apart = split(shared, [&](const Vector3 &p, const Vector3 &) {
            return Vector3(p.normalized() + disorder * random()).normalized();
        });
        expect_closed(cut_all(apart, 4));
    }
}

TEST(CurvedPatches, CutsAreAsManyAsTheAngleNeeds) {
    for (const SmoothMesh &mesh : {sphere(0), sphere(2), cylinder(6, 0.02, 0.05)}) {
        const CurvedPatches patches(mesh);
        for (const double angle_rad : {0.1, 0.02}) {
            const std::size_t cuts = patches.cuts_for(angle_rad, 1000);
            EXPECT_LE(patches.max_turn_rad(std::max<std::size_t>(cuts, 2)), angle_rad);
            EXPECT_EQ(patches.cuts_for(angle_rad, cuts), cuts);
            if (cuts > 5) { // not many more than needed
                EXPECT_GT(patches.max_turn_rad(cuts * 9 / 10), angle_rad);
                EXPECT_EQ(patches.cuts_for(angle_rad, cuts - 2), cuts - 2);
            }
        }
    }
}

TEST(CurvedPatches, TrianglesWithoutAreaDoNoHarm) {
    SmoothMesh mesh;
    mesh.positions = {{0, 0, 0}, {0.01, 0, 0}, {0, 0, 0}, {0.02, 0, 0}};
    mesh.normals.assign(4, Vector3::UnitZ());
    mesh.triangles = {{0, 1, 2}, {0, 0, 0}, {0, 1, 3}};
    for (const Vector3 &point : cut_all(mesh, 3).positions) {
        EXPECT_TRUE(point.allFinite());
    }
    EXPECT_EQ(CurvedPatches(mesh).cuts_for(0.01, 64), 1U);
}

std::vector<float> floats(const std::vector<Vector3> &vectors) {
    std::vector<float> numbers;
    for (const Vector3 &v : vectors) {
        for (const double number : {v.x(), v.y(), v.z()}) {
            numbers.push_back(static_cast<float>(number));
        }
    }
    return numbers;
}

/// An icosphere of radius 0.04 m in metres, accessors 0 and 1 its positions and normals, 2 its
/// indices; one node.
GltfBuilder ball(const std::string &node_members, int level = 1) {
    contact::TriangleSoup soup = springdrive::testing::icosphere(level, 0.04);
    GltfBuilder builder;
    builder.asset = kMetres;
    builder.add_positions(floats(soup.vertices_m));
    for (Vector3 &vertex : soup.vertices_m) {
        vertex.normalize();
    }
    builder.add_positions(floats(soup.vertices_m));
    std::vector<std::uint32_t> indices;
    for (const auto &triangle : soup.triangles) {
        indices.insert(indices.end(), triangle.begin(), triangle.end());
    }
    builder.add_accessor(indices, kUnsignedInt, "SCALAR");
    builder.add_mesh(R"("attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2)");
    builder.nodes = {R"({"mesh": 0)" + node_members + "}"};
    return builder;
}

const std::string kSmoothBall = R"(, "name": "ball", "extras": {"smooth": true})";

TEST(SmoothNodes, EyeAndHandGetTheSameCurvedSurface) {
    const Scene scene = load(ball(kSmoothBall));
    ASSERT_EQ(scene.meshes.size(), 1U);
    const VisualMesh &drawn = scene.meshes[0];
    const contact::TriangleSoup &touched = scene.surface;
    ASSERT_GT(touched.triangles.size(), 10'000U);
    ASSERT_EQ(drawn.indices.size(), 3 * touched.triangles.size());
    for (std::size_t i = 0; i < drawn.indices.size(); ++i) {
        const std::uint32_t corner = touched.triangles[i / 3][i % 3];
        const VisualVertex &vertex = drawn.vertices[drawn.indices[i]];
        for (int c = 0; c < 3; ++c) {
            ASSERT_EQ(vertex.position_m[static_cast<std::size_t>(c)],
                      static_cast<float>(touched.vertices_m[corner][c]));
        }
        const Vector3 point = touched.vertices_m[corner];
        ASSERT_NEAR(point.norm(), 0.04, 1e-6);
        const Vector3 normal(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
        ASSERT_GT(normal.dot(point.normalized()), 1.0 - 2e-6); // 0.1°
    }
    EXPECT_FALSE(has_warning(scene, "ball")); // as smooth as it should be
}

TEST(SmoothNodes, OthersKeepTheirTriangles) {
    EXPECT_EQ(load(ball("")).surface.triangles.size(), 80U);
    EXPECT_EQ(load(ball(R"(, "extras": {"smooth": false})")).surface.triangles.size(), 80U);
    GltfBuilder builder = ball(kSmoothBall);
    builder.nodes.emplace_back(R"({"mesh": 0, "name": "facets"})");
    const Scene scene = load(builder);
    EXPECT_EQ(scene.meshes[1].indices.size(), 240U);
    EXPECT_GT(scene.meshes[0].indices.size(), 30'000U);
}

TEST(SmoothNodes, AMirroredBallIsStillRoundAndFacesOutwards) {
    const Scene scene = load(ball(kSmoothBall + R"(, "scale": [1, 1, -1])"));
    for (const auto &[a, b, c] : corners_of(scene.surface)) {
        ASSERT_GT((b - a).cross(c - a).dot(a), 0.0);
    }
    for (const VisualVertex &vertex : scene.meshes[0].vertices) {
        ASSERT_GT(vertex.normal[0] * vertex.position_m[0] +
                      vertex.normal[1] * vertex.position_m[1] +
                      vertex.normal[2] * vertex.position_m[2],
                  0.0F);
    }
}

TEST(SmoothNodes, ColoursAndTextureCoordinatesRunLinearlyOverAPatch) {
    // On a ball, colour and texture coordinates that are linear in where the triangle's flat point
    // would be; a patch of one triangle shows it: (r, g) = (u, v) = weights of corners 1 and 2.
    GltfBuilder builder;
    builder.asset = kMetres;
    builder.add_positions({0.04F, 0, 0, 0, 0.04F, 0, 0, 0, 0.04F});
    builder.add_positions({1, 0, 0, 0, 1, 0, 0, 0, 1});
    builder.add_positions({0, 0, 1, 1, 0, 1, 0, 1, 1}); // colours
    builder.add_accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, kFloat, "VEC2");
    builder.add_mesh(
        R"("attributes": {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2, "TEXCOORD_0": 3})");
    builder.nodes = {R"({"mesh": 0, "extras": {"smooth": true}})"};
    const Scene scene = load(builder);
    const VisualMesh &mesh = scene.meshes[0];
    ASSERT_GT(mesh.vertices.size(), 100U);
    double sum = 0.0;
    for (const VisualVertex &vertex : mesh.vertices) {
        EXPECT_EQ(vertex.colour[0], vertex.texture_coordinate[0]);
        EXPECT_EQ(vertex.colour[1], vertex.texture_coordinate[1]);
        EXPECT_FLOAT_EQ(vertex.colour[2], 1.0F);
        // By symmetry the patch's weights order its coordinates: the heavier corner is nearer.
        const float w0 = 1.0F - vertex.colour[0] - vertex.colour[1];
        EXPECT_EQ(w0 > vertex.colour[0] + 1e-6F,
                  vertex.position_m[0] > vertex.position_m[1] + 1e-9F);
        sum += static_cast<double>(vertex.colour[0]);
    }
    EXPECT_NEAR(sum / static_cast<double>(mesh.vertices.size()), 1.0 / 3.0, 1e-6);
}

TEST(SmoothNodes, PrimitivesOfOneNodeStayJoined) {
    // The two halves of a ball, each a primitive with indices of its own: the northern one of 40
    // triangles is cut as the other is, and they meet point by point.
    GltfBuilder builder = ball(kSmoothBall);
    builder.accessors.pop_back();
    const std::string head =
        R"({"bufferView": 2, "componentType": 5125, "type": "SCALAR", "count": )";
    builder.accessors.push_back(head + "60}");
    builder.accessors.push_back(head + R"(180, "byteOffset": 240})");
    const std::string vertices = R"("attributes": {"POSITION": 0, "NORMAL": 1}, "indices": )";
    builder.meshes = {R"({"primitives": [{)" + vertices + "2}, {" + vertices + "3}]}"};
    const Scene parts = load(builder);
    const Scene whole = load(ball(kSmoothBall));
    ASSERT_EQ(parts.meshes.size(), 2U);
    ASSERT_EQ(parts.surface.triangles.size(), whole.surface.triangles.size());
    for (std::size_t i = 0; i < parts.surface.vertices_m.size(); ++i) {
        // Which end an edge is computed from depends on the numbering, and so do its last places.
        ASSERT_LT((parts.surface.vertices_m[i] - whole.surface.vertices_m[i]).norm(), 1e-16);
    }
    EXPECT_EQ(contact::prepare_mesh(parts.surface).report.open_edges, 0U);
}

TEST(SmoothNodes, MeshesWithoutNormalsStayFlatAndThoseOfLengthZeroAreRefused) {
    const Scene flat = load(one_triangle(R"("name": "X", "extras": {"smooth": true})"));
    EXPECT_EQ(flat.surface.triangles.size(), 1U);
    EXPECT_TRUE(has_warning(flat,
                            "node 'X': extras.smooth is left out: it needs normals; export it "
                            "with them"));
    GltfBuilder builder = ball(kSmoothBall);
    const std::string zeros(12, '\0'); // the normal of vertex 2
    builder.buffer.replace(42 * 12 + 24, 12, zeros);
    expect_failure(builder, "node 'ball': extras.smooth needs normals, but that of vertex 2 has no "
                            "direction");
}

TEST(SmoothNodes, ManyShareTheAllowanceAndSayHowFarTheyGot) {
    GltfBuilder builder = ball(kSmoothBall);
    builder.nodes.assign(30, builder.nodes[0]); // 30 × 177,000 triangles would be wanted
    const Scene scene = load(builder);
    EXPECT_LE(scene.surface.triangles.size(), gltf::kMaxCurvedTriangles);
    EXPECT_GT(scene.surface.triangles.size(), gltf::kMaxCurvedTriangles / 2);
    EXPECT_TRUE(has_warning(
        scene, "nodes 'ball', 'ball', 'ball' and 27 more: its 62720 curved facets still "
               "differ by up to 0.8"));
    EXPECT_TRUE(has_warning(scene, "degrees from their neighbours, instead of 0.5"));
}

TEST(SmoothNodes, WhatIsFineEnoughOrTooLargeStaysAsItIs) {
    EXPECT_EQ(load(ball(kSmoothBall, 6)).surface.triangles.size(), 81'920U * 4U); // 0.7° as it is
    GltfBuilder builder = one_triangle(R"("name": "large", "extras": {"smooth": true})");
    builder.add_accessor(std::vector<std::uint8_t>(1'500'003, 0), kUnsignedByte, "SCALAR");
    builder.meshes = {
        R"({"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}]})"};
    builder.nodes.emplace_back(one_triangle().nodes[0]);
    builder.meshes.emplace_back(R"({"primitives": [{"attributes": {"POSITION": 0}}]})");
    builder.nodes[1] = R"({"mesh": 1})";
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.triangles.size(), 500'002U);
    EXPECT_TRUE(
        has_warning(scene, "node 'large': is too large to be smoothed further; its 500001"));
}

} // namespace
} // namespace springdrive::scene
