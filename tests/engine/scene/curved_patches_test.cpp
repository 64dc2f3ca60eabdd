#include "engine/scene/curved_patches.h"

#include "tests/engine/contact/mesh/soups.h"

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

/// Around the y axis, closed by flat ends; as SmoothMesh without normals.
SmoothMesh prism(int sides, double radius_m, double half_height_m) {
    SmoothMesh mesh;
    mesh.positions = {{0.0, -half_height_m, 0.0}, {0.0, half_height_m, 0.0}};
    const auto vertex = [&](int side, int end) {
        return static_cast<std::uint32_t>(2 + 2 * (side % sides) + end);
    };
    for (int i = 0; i < sides; ++i) {
        const double turn = 2.0 * std::numbers::pi * i / sides;
        for (const double y_m : {-half_height_m, half_height_m}) {
            mesh.positions.emplace_back(radius_m * std::sin(turn), y_m, radius_m * std::cos(turn));
        }
        mesh.triangles.push_back({vertex(i, 0), vertex(i + 1, 0), vertex(i + 1, 1)});
        mesh.triangles.push_back({vertex(i, 0), vertex(i + 1, 1), vertex(i, 1)});
        mesh.triangles.push_back({0, vertex(i + 1, 0), vertex(i, 0)});
        mesh.triangles.push_back({1, vertex(i, 1), vertex(i + 1, 1)});
    }
    return mesh;
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

TEST(CurvedPatches, AnIcosahedronIsRoundWithinAThousandth) {
    for (const Vector3 &point : cut_all(sphere(0), 20).positions) {
        EXPECT_NEAR(point.norm() / kRadius_m, 1.0, 1e-3); // measured: 7.7e-4
    }
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

TEST(CurvedPatches, WhatIsFlatStaysFlatAndIsNotCut) {
    std::mt19937_64 dice(20260731);
    std::uniform_real_distribution<double> jitter(-0.3, 0.3);
    SmoothMesh plate;
    const Vector3 normal = Vector3(1, 2, 3).normalized();
    const Vector3 across = normal.cross(Vector3::UnitX()).normalized();
    for (int row = 0; row < 6; ++row) {
        for (int column = 0; column < 6; ++column) {
            plate.positions.emplace_back(0.01 * (row + jitter(dice)) * across +
                                         0.01 * (column + jitter(dice)) * normal.cross(across));
        }
    }
    plate.normals.assign(plate.positions.size(), normal);
    for (std::uint32_t row = 0; row < 5; ++row) {
        for (std::uint32_t corner = 6 * row; corner < 6 * row + 5; ++corner) {
            plate.triangles.push_back({corner, corner + 6, corner + 7});
            plate.triangles.push_back({corner, corner + 7, corner + 1});
        }
    }
    const CurvedPatches patches(plate);
    EXPECT_EQ(patches.cuts_for(0.5 / kRadian, 128), 1U);
    const auto area = [](const SmoothMesh &mesh) {
        double twice = 0.0;
        for (const auto &[a, b, c] : mesh.triangles) {
            twice += (mesh.positions[b] - mesh.positions[a])
                         .cross(mesh.positions[c] - mesh.positions[a])
                         .norm();
        }
        return 0.5 * twice;
    };
    const SmoothMesh fine = patches.cut(4, 0, plate.triangles.size());
    for (const Vector3 &point : fine.positions) {
        EXPECT_LT(std::abs(normal.dot(point)), kSumRounding_m);
    }
    EXPECT_NEAR(area(fine), area(plate), 1e-15); // no fold, no overlap
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

} // namespace
} // namespace springdrive::scene
