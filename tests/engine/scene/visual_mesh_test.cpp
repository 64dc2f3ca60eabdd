// Covers engine/scene/visual_mesh.cpp and texture_scaling.cpp: how a scene is drawn.
#include "engine/scene/texture_scaling.h"
#include "engine/scene/visual_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::scene {
namespace {

using Point = std::array<float, 3>;

void add_triangle(VisualMesh &mesh, const std::array<Point, 3> &corners,
                  const std::array<Point, 3> &normals) {
    for (std::size_t i = 0; i < 3; ++i) {
        mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
        mesh.vertices.push_back({corners[i], normals[i], {}, {}});
    }
}

/// Two triangles.
void add_quad(VisualMesh &mesh, const std::array<Point, 4> &corners,
              const std::array<Point, 4> &normals) {
    add_triangle(mesh, {corners[0], corners[1], corners[2]}, {normals[0], normals[1], normals[2]});
    add_triangle(mesh, {corners[0], corners[2], corners[3]}, {normals[0], normals[2], normals[3]});
}

/// The closed wall and both ends of a prism over a regular polygon.
/// @param smooth  whether the wall's normals are those of a cylinder, or of its faces
VisualMesh prism(int sides, bool smooth) {
    VisualMesh mesh;
    const auto at = [&](double turn, float height) {
        const double angle = 2.0 * std::numbers::pi * std::fmod(turn, sides) / sides;
        return Point{static_cast<float>(std::cos(angle)), height,
                     static_cast<float>(std::sin(angle))};
    };
    for (int i = 0; i < sides; ++i) {
        const Point facing = at(i + 0.5, 0.0F);
        const Point from = smooth ? at(i, 0.0F) : facing;
        const Point to = smooth ? at(i + 1, 0.0F) : facing;
        add_quad(mesh, {at(i, 0.0F), at(i + 1, 0.0F), at(i + 1, 1.0F), at(i, 1.0F)},
                 {from, to, to, from});
        for (const float height : {0.0F, 1.0F}) {
            const Point up{0.0F, height > 0.5F ? 1.0F : -1.0F, 0.0F};
            add_triangle(mesh, {Point{0.0F, height, 0.0F}, at(i, height), at(i + 1, height)},
                         {up, up, up});
        }
    }
    return mesh;
}

std::vector<LineSegment> creases(const VisualMesh &mesh) { return creases_of({&mesh, 1}); }

/// Neighbouring faces of a prism over n sides meet at 360°/n, wall and ends at 90°.
TEST(Creases, OfPrismsAreTheEdgesThatTurnByMoreThanTheirAngle) {
    for (int sides = 3; sides <= 40; ++sides) {
        const bool has_edges = 360.0 / sides > kCrease_deg;
        if (360.0 / sides == kCrease_deg) {
            continue; // round-off decides
        }
        const auto rims = 2 * static_cast<std::size_t>(sides);
        EXPECT_EQ(creases(prism(sides, false)).size(),
                  rims + (has_edges ? static_cast<std::size_t>(sides) : 0))
            << sides;
        EXPECT_EQ(creases(prism(sides, true)).size(), rims) << sides; // drawn round
    }
}

TEST(Creases, AreTheBorderOfAQuadButNotItsDiagonal) {
    const Point up{0.0F, 1.0F, 0.0F};
    VisualMesh mesh;
    add_quad(mesh, {Point{0, 0, 0}, Point{0, 0, 1}, Point{1, 0, 1}, Point{1, 0, 0}},
             {up, up, up, up});
    const std::vector<LineSegment> found = creases(mesh);
    EXPECT_EQ(found.size(), 4U);
    EXPECT_EQ(std::ranges::count(found, LineSegment{Point{0, 0, 0}, Point{1, 0, 1}}), 0);
}

TEST(Creases, AreNotOfWhatHasATextureAMaskOrIsSeenThrough) {
    const VisualMesh plain = prism(4, false);
    EXPECT_EQ(creases(plain).size(), 12U);
    VisualMesh textured = plain;
    textured.texture = 0;
    EXPECT_TRUE(creases(textured).empty());
    VisualMesh bumped = plain;
    bumped.finish.normal_texture = 0;
    EXPECT_TRUE(creases(bumped).empty());
    VisualMesh glass = plain;
    glass.translucent = true;
    EXPECT_TRUE(creases(glass).empty());
    VisualMesh masked = plain;
    masked.alpha_cutoff = 0.5F;
    EXPECT_TRUE(creases(masked).empty());
}

/// Neither the order of the triangles nor the meshes that they are in matter.
TEST(Creases, AreTheSameOfAMeshInPieces) {
    std::mt19937_64 dice(7);
    VisualMesh mesh = prism(24, false);
    const std::vector<LineSegment> whole = creases(mesh);
    ASSERT_EQ(whole.size(), 48U);
    for (const std::size_t vertices : {3U, 9U, 30U, 100U}) {
        std::vector<std::size_t> order(mesh.indices.size() / 3);
        for (std::size_t i = 0; i < order.size(); ++i) {
            order[i] = i;
        }
        std::ranges::shuffle(order, dice);
        VisualMesh shuffled = mesh;
        for (std::size_t i = 0; i < order.size(); ++i) {
            std::copy_n(mesh.indices.begin() + static_cast<std::ptrdiff_t>(3 * order[i]), 3,
                        shuffled.indices.begin() + static_cast<std::ptrdiff_t>(3 * i));
        }
        EXPECT_EQ(creases_of(in_pieces(shuffled, vertices)), whole) << vertices;
    }
}

TEST(Creases, AreLeftOutWhereTheyAreTooMany) {
    const auto open_triangles = [](std::size_t count) { // of three creases each
        VisualMesh mesh;
        const Point up{0.0F, 1.0F, 0.0F};
        for (std::size_t i = 0; i < count; ++i) {
            const auto x = static_cast<float>(2 * i);
            add_triangle(mesh, {Point{x, 0, 0}, Point{x, 0, 1}, Point{x + 1.0F, 0, 0}},
                         {up, up, up});
        }
        return mesh;
    };
    constexpr std::size_t kMax = kMaxCreases / 3;
    EXPECT_EQ(creases(open_triangles(kMax)).size(), 3 * kMax);
    EXPECT_TRUE(creases(open_triangles(kMax + 1)).empty());
    VisualMesh closed = prism(4, false);
    const std::vector<std::uint32_t> once = closed.indices;
    while (closed.indices.size() <= 3 * kMaxCreasedTriangles - once.size()) {
        closed.indices.insert(closed.indices.end(), once.begin(), once.end());
    }
    EXPECT_EQ(creases(closed).size(), 12U);
    closed.indices.insert(closed.indices.end(), once.begin(), once.end());
    EXPECT_TRUE(creases(closed).empty());
}

/// Vertices that carry their number as x; triangles between random ones.
VisualMesh random_mesh(std::size_t vertices, std::size_t triangles) {
    std::mt19937_64 dice(20260733);
    std::uniform_int_distribution<std::uint32_t> any(0, static_cast<std::uint32_t>(vertices) - 1);
    VisualMesh mesh;
    mesh.name = "mesh";
    mesh.texture = 3;
    mesh.double_sided = true;
    mesh.finish.normal_texture = 5;
    for (std::size_t i = 0; i < vertices; ++i) {
        mesh.vertices.push_back({{static_cast<float>(i), 0.0F, 0.0F}, {}, {}, {}});
        mesh.tangents.push_back({0.0F, static_cast<float>(i), 0.0F, 1.0F});
    }
    for (std::size_t i = 0; i < 3 * triangles; ++i) {
        mesh.indices.push_back(any(dice));
    }
    return mesh;
}

/// The numbers of all corners, triangle by triangle.
std::vector<float> corners(const std::vector<VisualMesh> &meshes) {
    std::vector<float> numbers;
    for (const VisualMesh &mesh : meshes) {
        for (const std::uint32_t index : mesh.indices) {
            numbers.push_back(mesh.vertices.at(index).position_m[0]);
        }
    }
    return numbers;
}

TEST(VisualPieces, HoldTheSameTrianglesInTheSameOrder) {
    const VisualMesh mesh = random_mesh(1000, 3000);
    const std::vector<float> wanted = corners({mesh});
    for (const std::size_t maximum : {3U, 4U, 10U, 100U, 999U}) {
        const std::vector<VisualMesh> pieces = in_pieces(mesh, maximum);
        EXPECT_GT(pieces.size(), 1U);
        EXPECT_EQ(corners(pieces), wanted) << maximum;
        for (const VisualMesh &piece : pieces) {
            EXPECT_LE(piece.vertices.size(), maximum);
            EXPECT_LE(piece.indices.size(), 6 * maximum);
            EXPECT_FALSE(piece.indices.empty());
            EXPECT_EQ(piece.name, "mesh");
            EXPECT_EQ(piece.texture, 3);
            EXPECT_EQ(piece.finish.normal_texture, 5);
            ASSERT_EQ(piece.tangents.size(), piece.vertices.size());
            for (std::size_t i = 0; i < piece.vertices.size(); ++i) {
                ASSERT_EQ(piece.tangents[i][1], piece.vertices[i].position_m[0]);
            }
            EXPECT_TRUE(piece.double_sided);
        }
    }
}

TEST(VisualPieces, ASmallMeshStaysAsItIs) {
    const VisualMesh mesh = random_mesh(100, 200);
    const std::vector<VisualMesh> pieces = in_pieces(mesh, 100);
    ASSERT_EQ(pieces.size(), 1U);
    EXPECT_EQ(pieces[0].indices, mesh.indices);
    EXPECT_EQ(pieces[0].vertices.size(), mesh.vertices.size());
    EXPECT_EQ(in_pieces(random_mesh(100, 201), 100).size(), 2U); // few vertices, many triangles
    EXPECT_EQ(in_pieces(random_mesh(3, 0), 100).size(), 1U);
}

/// Grey values in rows of `width`; alpha is the grey value less one.
Texture grey(int width, const std::vector<int> &values) {
    Texture texture;
    texture.width = width;
    texture.height = static_cast<int>(values.size()) / width;
    for (const int value : values) {
        const auto byte = static_cast<std::uint8_t>(value);
        texture.rgba.insert(texture.rgba.end(),
                            {byte, byte, byte, static_cast<std::uint8_t>(byte - 1)});
    }
    return texture;
}

TEST(TextureScaling, SmallTexturesStayAsTheyAre) {
    const Texture texture = grey(3, {1, 2, 3, 4, 5, 6});
    EXPECT_EQ(scaled_down(texture, 3).rgba, texture.rgba);
}

TEST(TextureScaling, EachPixelIsTheMeanOfThoseThatItCovers) {
    Texture texture = grey(4, {10, 20, 30, 50, 30, 40, 50, 70});
    texture.wrap_s = Texture::Wrap::mirror;
    texture.has_alpha = true;
    texture.holds_numbers = true;
    const Texture half = scaled_down(texture, 2);
    EXPECT_EQ(half.rgba, grey(2, {15, 40, 35, 60}).rgba);
    EXPECT_EQ(half.wrap_s, Texture::Wrap::mirror);
    EXPECT_TRUE(half.has_alpha);
    EXPECT_TRUE(half.holds_numbers);
    EXPECT_EQ(scaled_down(texture, 1).rgba, grey(1, {38}).rgba); // 37.5
}

TEST(TextureScaling, OnlyTheSideThatIsTooLongIsScaled) {
    // Three pixels on two: the middle one is covered by both.
    const Texture scaled = scaled_down(grey(3, {10, 20, 50}), 2);
    EXPECT_EQ(scaled.width, 2);
    EXPECT_EQ(scaled.height, 1);
    EXPECT_EQ(scaled.rgba, grey(2, {15, 35}).rgba);
}

} // namespace
} // namespace springdrive::scene
