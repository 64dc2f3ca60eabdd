#include "engine/scene/visual_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace springdrive::scene {
namespace {

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

TEST(VisualPieces, RepeatNoVertexWithinAPiece) {
    for (const VisualMesh &piece : in_pieces(random_mesh(1000, 3000), 100)) {
        std::vector<float> numbers;
        for (const VisualVertex &vertex : piece.vertices) {
            numbers.push_back(vertex.position_m[0]);
        }
        std::ranges::sort(numbers);
        EXPECT_EQ(std::ranges::adjacent_find(numbers), numbers.end());
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

} // namespace
} // namespace springdrive::scene
