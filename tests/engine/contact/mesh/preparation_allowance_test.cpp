// Covers engine/contact/mesh/preparation_allowance.cpp, and that no stage of preparation exceeds
// what it allows.
#include "engine/contact/mesh/preparation_allowance.h"

#include "engine/contact/mesh/boundary_stitching.h"
#include "engine/contact/mesh/t_junction_removal.h"
#include "engine/contact/mesh/vertex_welding.h"
#include "tests/engine/contact/mesh/dense_soups.h"
#include "tests/engine/contact/mesh/meshes.h"
#include "tests/support/error_text.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

namespace springdrive::contact {
namespace {

using testing::add_triangle;
using testing::error_text_of;
using testing::scattered_soup;
using testing::shaken;
using testing::soup_in_a_line;

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

TriangleSoup cloud(std::mt19937_64 &random, int triangles) {
    return scattered_soup(random, triangles, {1e-5, 1e-5, 1e-5});
}

/// Sheets one above the other, so that each vertex is within the tolerance of several.
TriangleSoup stack(std::mt19937_64 &random, int sheets) {
    TriangleSoup soup;
    for (int i = 0; i < sheets; ++i) {
        Eigen::Isometry3d up = Eigen::Isometry3d::Identity();
        up.translation().y() = 1e-6 * i;
        soup = testing::joined(soup, testing::moved(testing::sheet(8, 0.05), up));
    }
    return shaken(testing::unshared(soup), 1e-6, random);
}

Vector3 on_circle(int i, int of) {
    const double angle = 2.0 * 3.14159265358979323846 * i / of;
    return {0.05 * std::cos(angle), 0.0, 0.05 * std::sin(angle)};
}

TriangleSoup fan(std::mt19937_64 &random, int triangles) {
    TriangleSoup soup;
    for (int i = 0; i < triangles; ++i) {
        add_triangle(
            soup, {Vector3(0.0, 0.01, 0.0), on_circle(i, triangles), on_circle(i + 1, triangles)});
    }
    return shaken(soup, 1e-6, random);
}

TriangleSoup book(std::mt19937_64 &random, int triangles) {
    TriangleSoup soup;
    for (int i = 0; i < triangles; ++i) {
        add_triangle(soup,
                     {Vector3(0.0, -0.05, 0.0), Vector3(0.0, 0.05, 0.0), on_circle(i, triangles)});
    }
    return shaken(soup, 1e-6, random);
}

/// The corners replaced, without the triangles that collapse.
std::vector<MeshTriangle> replaced(const std::vector<MeshTriangle> &triangles,
                                   const std::vector<std::uint32_t> &stands_for) {
    std::vector<MeshTriangle> result;
    for (MeshTriangle triangle : triangles) {
        for (std::uint32_t &vertex : triangle.vertices) {
            vertex = stands_for[vertex];
        }
        const auto &[a, b, c] = triangle.vertices;
        if (a != b && b != c && c != a) {
            result.push_back(triangle);
        }
    }
    return result;
}

constexpr double kClosedGap_m = 5e-6;

/// The stages up to the closing of cracks.
std::vector<MeshTriangle> closed_mesh(const TriangleSoup &soup, PreparationAllowance &allowance,
                                      unsigned threads = 1) {
    const std::vector<MeshTriangle> triangles = replaced(
        testing::mesh_of(soup.triangles), weld_vertices(soup.vertices_m, 1e-7, allowance, threads));
    const EdgeTable edges(triangles, soup.vertices_m.size(), threads);
    return replaced(
        triangles, close_cracks(triangles, edges, soup.vertices_m, kClosedGap_m, allowance, threads)
                       .stands_for);
}

/// All stages that are bounded.
void run_stages(const TriangleSoup &soup, PreparationAllowance &allowance, unsigned threads = 1) {
    std::vector<MeshTriangle> triangles = closed_mesh(soup, allowance, threads);
    const EdgeTable edges(triangles, soup.vertices_m.size(), threads);
    static_cast<void>(
        split_edges(triangles, edges, soup.vertices_m, kClosedGap_m, allowance, threads));
}

std::uint64_t steps_for(const TriangleSoup &soup, unsigned threads = 1) {
    PreparationAllowance allowance(soup.triangles.size(), kUnlimited);
    run_stages(soup, allowance, threads);
    return allowance.taken();
}

std::string error_about(const TriangleSoup &soup, std::uint64_t allowed, unsigned threads = 1) {
    PreparationAllowance allowance(soup.triangles.size(), allowed);
    return error_text_of([&] { run_stages(soup, allowance, threads); });
}

TEST(PreparationAllowance, EndsWithTheLastStepAllowed) {
    PreparationAllowance allowance(1, 100);
    EXPECT_TRUE(allowance.take(100));
    EXPECT_FALSE(allowance.is_exceeded());
    EXPECT_FALSE(allowance.take(1));
    EXPECT_TRUE(allowance.is_exceeded());
}

TEST(PreparationAllowance, GrowsWithTheMeshUpToALimit) {
    const auto allows = [](std::size_t triangles, std::uint64_t steps) {
        return PreparationAllowance(triangles).take(steps);
    };
    EXPECT_TRUE(allows(0, 2'000'000'000));
    EXPECT_FALSE(allows(0, 2'000'000'001));
    EXPECT_TRUE(allows(1'000'000, 4'000'000'000));
    EXPECT_FALSE(allows(1'000'000, 4'000'000'001));
    EXPECT_TRUE(allows(kMaxTriangles, 10'000'000'000));
    EXPECT_FALSE(allows(kMaxTriangles, 10'000'000'001));
}

TEST(PreparationAllowance, RefusesWithBothNumbers) {
    const PreparationAllowance allowance(6000);
    EXPECT_EQ(error_text_of([&] { allowance.refuse("sort them", 54'321'000'000.0); }),
              "preparing its 6000 triangles for touch needs about 54321 million steps, most of "
              "them to sort them; at most 2012 million are allowed: join vertices that nearly "
              "coincide, remove triangles that lie on top of each other, or enlarge it");
    EXPECT_EQ(error_text_of([&] { allowance.refuse("sort them", 2'011'000'000.0); }),
              "preparing its 6000 triangles for touch needs more than 2012 million steps, most of "
              "them to sort them; at most 2012 million are allowed: join vertices that nearly "
              "coincide, remove triangles that lie on top of each other, or enlarge it");
}

TEST(PreparationAllowance, IsTakenFromAlikeByAnyNumberOfThreads) {
    std::mt19937_64 random(1);
    for (const TriangleSoup &soup :
         {soup_in_a_line(random, 100), cloud(random, 500), fan(random, 500)}) {
        const std::uint64_t needed = steps_for(soup);
        for (const unsigned threads : {1U, 2U, 3U}) {
            EXPECT_EQ(steps_for(soup, threads), needed);
            EXPECT_EQ(error_about(soup, needed, threads), "");
            EXPECT_EQ(error_about(soup, needed - 1, threads), error_about(soup, needed - 1));
            EXPECT_NE(error_about(soup, needed - 1, threads), "");
        }
    }
}

TEST(PreparationAllowance, IsRefusedInEveryStage) {
    std::mt19937_64 random(1);
    const TriangleSoup dense = cloud(random, 1000);
    const auto names = [](const std::string &error, const std::string &purpose) {
        return error.find("most of them to " + purpose + ";") != std::string::npos;
    };
    EXPECT_TRUE(names(error_about(dense, 1000), "find vertices at the same place"));
    PreparationAllowance welding(dense.triangles.size(), kUnlimited);
    static_cast<void>(weld_vertices(dense.vertices_m, 1e-7, welding));
    EXPECT_TRUE(
        names(error_about(dense, welding.taken() + 1000), "find vertices that nearly coincide"));
    PreparationAllowance closing(dense.triangles.size(), kUnlimited);
    static_cast<void>(closed_mesh(dense, closing)); // which ends with joining
    EXPECT_TRUE(
        names(error_about(dense, closing.taken() - 1), "join vertices that nearly coincide"));
    const TriangleSoup crossed = soup_in_a_line(random, 100);
    EXPECT_TRUE(names(error_about(crossed, steps_for(crossed) / 2),
                      "divide triangles where vertices of others touch their edges"));
}

TEST(PreparationAllowance, EstimatesWhatDividingNeeds) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 3; ++round) {
        const TriangleSoup soup = soup_in_a_line(random, 200);
        const auto needed = static_cast<double>(steps_for(soup));
        const std::string error = error_about(soup, 2'000'000);
        const std::string before = "needs about ";
        const double said = 1e6 * std::stod(error.substr(error.find(before) + before.size()));
        EXPECT_GT(said, 0.8 * needed) << error;
        EXPECT_LT(said, 1.25 * needed) << error;
    }
}

/// Beyond an allowance go the portions of the threads, and the last item that each looked at.
std::uint64_t max_beyond(const TriangleSoup &soup, unsigned threads) {
    return threads * ((1 << 20) + (kStepsPerPiece + kStepsPerNode) * soup.vertices_m.size());
}

TEST(PreparationAllowance, BoundsTheWorkForAnySoup) {
    using Make = std::function<TriangleSoup(std::mt19937_64 &, int)>;
    std::mt19937_64 random(1);
    constexpr std::uint64_t kAllowed = 5'000'000;
    int refused = 0;
    for (const auto &[make, size] : std::vector<std::pair<Make, int>>{
             {soup_in_a_line, 3000}, {cloud, 3000}, {stack, 20}, {fan, 3000}, {book, 3000}}) {
        for (const int share : {1, 10, 100}) {
            for (const unsigned threads : {1U, 2U}) {
                const TriangleSoup soup = make(random, std::max(2, size / share));
                PreparationAllowance allowance(soup.triangles.size(), kAllowed);
                const std::string error =
                    error_text_of([&] { run_stages(soup, allowance, threads); });
                refused += error.empty() ? 0 : 1;
                EXPECT_EQ(error.empty(), allowance.taken() <= kAllowed) << error;
                EXPECT_LE(allowance.taken(), kAllowed + max_beyond(soup, threads));
            }
        }
    }
    EXPECT_GT(refused, 0);
}

TEST(PreparationAllowance, IsHardlyTouchedByFansAndBooksHoweverMany) {
    std::mt19937_64 random(1);
    for (const int triangles : {1000, 10'000}) {
        EXPECT_LT(steps_for(fan(random, triangles)), kAllowedSteps / 10);
        EXPECT_LT(steps_for(book(random, triangles)), kAllowedSteps / 10);
    }
}

} // namespace
} // namespace springdrive::contact
