// Covers engine/contact/mesh/mesh_topology.cpp and mesh_repair.cpp, and of mesh_preparation.cpp the
// last step.
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/mesh/mesh_repair.h"
#include "engine/contact/mesh/mesh_topology.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace springdrive::contact {
namespace {

using testing::box_soup;
using testing::bumpy_sphere;
using testing::edges_of;
using testing::mesh_of;

/// Three different vertices of `count`, at random.
VertexTriple random_triple(std::mt19937_64 &random, std::uint32_t count) {
    std::uniform_int_distribution<std::uint32_t> vertex(0, count - 1);
    VertexTriple triple{};
    do {
        triple = {vertex(random), vertex(random), vertex(random)};
    } while (triple[0] == triple[1] || triple[1] == triple[2] || triple[2] == triple[0]);
    return triple;
}

std::vector<MeshTriangle> random_mesh(std::mt19937_64 &random, int triangles,
                                      std::uint32_t vertices) {
    std::vector<VertexTriple> triples;
    triples.reserve(static_cast<std::size_t>(triangles));
    for (int i = 0; i < triangles; ++i) {
        triples.push_back(random_triple(random, vertices));
    }
    return mesh_of(triples);
}

TEST(EdgeTable, HoldsEveryUseOfEveryEdge) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 200; ++i) {
        const std::uint32_t vertices = 3 + static_cast<std::uint32_t>(random() % 20);
        const std::vector<MeshTriangle> mesh = random_mesh(random, 40, vertices);
        std::vector<VertexTriple> triples;
        triples.reserve(mesh.size());
        for (const MeshTriangle &triangle : mesh) {
            triples.push_back(triangle.vertices);
        }
        auto expected = testing::edge_counts(triples);
        std::size_t open = 0;
        const EdgeTable edges = edges_of(mesh);
        edges.for_each([&](const Edge &edge) {
            std::array<int, 2> counts{};
            for (const EdgeUse &use : edge.uses) {
                const VertexTriple &corners = mesh[use.triangle()].vertices;
                const std::uint32_t from = corners[use.side()];
                const std::uint32_t to = corners[(use.side() + 1) % 3];
                ASSERT_EQ(std::min(from, to), edge.lower);
                ASSERT_EQ(std::max(from, to), edge.upper());
                ASSERT_EQ(from < to, use.is_forward());
                ++counts[use.is_forward() ? 0 : 1];
            }
            ASSERT_EQ(counts, (expected.at({edge.lower, edge.upper()})));
            ASSERT_EQ(edges.uses_of(edge.upper(), edge.lower).data(), edge.uses.data());
            ASSERT_EQ(edges.uses_of(edge.lower, edge.upper()).size(), edge.uses.size());
            expected.erase({edge.lower, edge.upper()});
            open += edge.uses.size() == 1 ? 1 : 0;
        });
        EXPECT_TRUE(expected.empty());
        EXPECT_EQ(count_open(edges), open);
    }
}

/// Sets and turns as plain labels, all of them rewritten at each union.
class PlainSets {
public:
    explicit PlainSets(std::uint32_t count) {
        for (std::uint32_t i = 0; i < count; ++i) {
            label.push_back(i);
            is_turned.push_back(false);
        }
    }

    bool unite(std::uint32_t a, std::uint32_t b, bool are_opposite) {
        const bool is_odd = (is_turned[a] != is_turned[b]) != are_opposite;
        if (label[a] == label[b]) {
            return !is_odd;
        }
        const std::uint32_t from = label[b];
        for (std::uint32_t i = 0; i < label.size(); ++i) {
            if (label[i] == from) {
                label[i] = label[a];
                is_turned[i] = is_turned[i] != is_odd;
            }
        }
        return true;
    }

    std::vector<std::uint32_t> label;
    std::vector<bool> is_turned;
};

TEST(TriangleSets, AgreesWithPlainLabels) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 300; ++round) {
        constexpr std::uint32_t kCount = 30;
        TriangleSets sets(kCount);
        PlainSets plain(kCount);
        for (int i = 0; i < 40; ++i) {
            const auto a = static_cast<std::uint32_t>(random() % kCount);
            const auto b = static_cast<std::uint32_t>(random() % kCount);
            const bool are_opposite = random() % 2 == 0;
            ASSERT_EQ(sets.unite(a, b, are_opposite), plain.unite(a, b, are_opposite));
        }
        for (std::uint32_t a = 0; a < kCount; ++a) {
            ASSERT_LE(sets.root_of(a), a);
            for (std::uint32_t b = 0; b < kCount; ++b) {
                const bool are_together = sets.root_of(a) == sets.root_of(b);
                ASSERT_EQ(are_together, plain.label[a] == plain.label[b]);
                if (are_together) {
                    ASSERT_EQ(sets.place_of(a).is_opposite != sets.place_of(b).is_opposite,
                              plain.is_turned[a] != plain.is_turned[b]);
                }
            }
        }
    }
}

using Closed = std::vector<bool>;

Closed closed(const MeshTopology &topology) {
    Closed result;
    for (const MeshComponent &component : topology.components) {
        result.push_back(component.is_closed);
    }
    return result;
}

const std::vector<VertexTriple> kTetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

std::vector<VertexTriple> tetrahedron_and(const std::vector<VertexTriple> &more) {
    std::vector<VertexTriple> triples = kTetrahedron;
    triples.insert(triples.end(), more.begin(), more.end());
    return triples;
}

/// Triangles in a line, in any order.
std::vector<VertexTriple> strip_of(std::uint32_t count) {
    std::vector<VertexTriple> strip;
    for (std::uint32_t i = 0; i < count; ++i) {
        strip.push_back(i % 2 == 0 ? VertexTriple{i, i + 1, i + 2} : VertexTriple{i + 1, i, i + 2});
    }
    std::mt19937_64 random(1);
    std::ranges::shuffle(strip, random);
    return strip;
}

TEST(MeshTopology, FindsWhatIsConnectedClosedAndOrientable) {
    struct Case {
        const char *what;
        std::vector<VertexTriple> triples;
        std::vector<std::size_t> of_both_windings;
        Closed closed;
        std::size_t open_edges = 0;
        std::size_t non_manifold_edges = 0;
        bool has_sheets_apart = true; ///< these two of the first component
        bool is_orientable = true;
    };
    const std::vector<VertexTriple> open(kTetrahedron.begin(), kTetrahedron.end() - 1);
    for (const Case &one : std::vector<Case>{
             {"nothing", {}, {}, {}},
             {"a tetrahedron", kTetrahedron, {}, {true}},
             {"without one face", open, {}, {false}, 3, 0, false},
             {"with a turned face",
              {{0, 2, 1}, {0, 1, 3}, {2, 1, 3}, {2, 0, 3}},
              {},
              {false},
              0,
              0,
              false,
              false},
             {"another on the edge 0-1",
              tetrahedron_and({{0, 4, 1}, {0, 1, 5}, {1, 4, 5}, {4, 0, 5}}),
              {},
              {true},
              0,
              1},
             {"an open one on the vertex 0",
              tetrahedron_and({{0, 5, 4}, {0, 4, 6}, {4, 5, 6}}),
              {},
              {true, false},
              3},
             // Euler: a disc of n triangles has n + 2 border edges.
             {"a strip", strip_of(5000), {}, {false}, 5002, 0, false},
             {"a sphere", testing::icosphere(4, 1.0).triangles, {}, {true}},
             {"a Moebius strip", testing::twisted_strip(9, 1), {}, {false}, 18, 0, false, false},
             {"a strip of two half-turns", testing::twisted_strip(9, 2), {}, {false}, 18, 0, false},
             {"a sheet on a solid", tetrahedron_and({{0, 1, 4}}), {4}, {true}, 2, 1},
             {"the same of one winding", tetrahedron_and({{0, 1, 4}}), {}, {false}, 2, 1, false},
             {"a face of both windings", kTetrahedron, {2}, {true}, 0, 0, false},
             {"two that share a wall",
              {{0, 2, 1}, {0, 1, 3}, {2, 0, 3}, {4, 1, 2}, {4, 3, 1}, {4, 2, 3}, {1, 2, 3}},
              {6},
              {true},
              0,
              3},
             {"a sheet of both windings", {{0, 1, 2}, {0, 2, 3}}, {0, 1}, {false}, 4, 0, false}}) {
        SCOPED_TRACE(one.what);
        std::vector<MeshTriangle> triangles = mesh_of(one.triples);
        for (const std::size_t index : one.of_both_windings) {
            triangles[index].has_both_windings = true;
        }
        const MeshTopology topology = find_topology(triangles, edges_of(triangles));
        EXPECT_EQ(closed(topology), one.closed);
        EXPECT_EQ(topology.open_edges, one.open_edges);
        EXPECT_EQ(topology.non_manifold_edges, one.non_manifold_edges);
        ASSERT_EQ(topology.component_of_triangle.size(), triangles.size());
        for (std::size_t i = 0; i < triangles.size(); ++i) { // the first one's come first
            EXPECT_EQ(topology.component_of_triangle[i],
                      one.closed.size() == 2 && i >= 4 ? 1U : 0U);
        }
        if (!topology.components.empty()) {
            EXPECT_EQ(topology.components.front().has_sheets_apart, one.has_sheets_apart);
            EXPECT_EQ(topology.components.front().is_orientable, one.is_orientable);
        }
    }
}

TEST(EnclosedVolume, IsThatOfTheSolidAloneAndNegativeWithin) {
    // The last lies 1 m off, so that much more is cancelled; the second is open.
    TriangleSoup soup = box_soup({0.0, 0.0, 0.0}, {0.01, 0.02, 0.03});
    TriangleSoup open = box_soup({0.1, 0.0, 0.0}, {0.11, 0.02, 0.03});
    open.triangles.pop_back();
    soup =
        testing::joined(testing::joined(soup, open),
                        testing::turned_inside_out(box_soup({1.0, 1.0, 1.0}, {1.01, 1.01, 1.02})));
    std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    triangles.push_back({{0, 4, 7}, 35, true}); // a sheet across two edges of the first
    const std::vector<double> volumes = enclosed_volumes_m3(
        triangles, find_topology(triangles, edges_of(triangles)), soup.vertices_m);
    ASSERT_EQ(volumes.size(), 3U);
    EXPECT_NEAR(volumes[0], 6e-6, 1e-17);
    EXPECT_EQ(volumes[1], 0.0);
    EXPECT_NEAR(volumes[2], -2e-6, 1e-14);
}

struct OrientationOutcome {
    std::vector<VertexTriple> triples;
    TurnedTriangles turned;
};

OrientationOutcome oriented(std::vector<MeshTriangle> triangles,
                            const std::vector<Vector3> &vertices_m) {
    const EdgeTable edges = edges_of(triangles);
    OrientationOutcome outcome{{}, orient_triangles(triangles, edges, vertices_m)};
    for (const MeshTriangle &triangle : triangles) {
        outcome.triples.push_back(triangle.vertices);
    }
    return outcome;
}

OrientationOutcome oriented(const TriangleSoup &soup) {
    return oriented(mesh_of(soup.triangles), soup.vertices_m);
}

double volume_m3(const std::vector<VertexTriple> &triples, const std::vector<Vector3> &vertices_m) {
    double volume = 0.0;
    for (const auto &[a, b, c] : triples) {
        volume += vertices_m[a].dot(vertices_m[b].cross(vertices_m[c])) / 6.0;
    }
    return volume;
}

/// How many triangles differ in winding from those given.
std::size_t differences(const std::vector<VertexTriple> &a, const std::vector<VertexTriple> &b) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        VertexTriple turned = b[i];
        std::rotate(turned.begin(), std::ranges::find(turned, a[i][0]), turned.end());
        count += turned == a[i] ? 0 : 1;
    }
    return count;
}

TEST(TriangleOrientation, TurnsTheFewInABodyAndInARoom) {
    std::mt19937_64 random(1);
    const TriangleSoup body = bumpy_sphere(3, 0.03);
    for (const TriangleSoup &right : {body, testing::turned_inside_out(body)}) {
        for (int round = 0; round < 10; ++round) {
            const TriangleSoup disturbed =
                testing::partly_turned(right, 0.05 + 0.02 * round, random);
            const OrientationOutcome outcome = oriented(disturbed);
            EXPECT_EQ(differences(outcome.triples, right.triangles), 0U);
            EXPECT_EQ(outcome.turned.of_one_winding,
                      differences(disturbed.triangles, right.triangles));
        }
    }
}

TEST(TriangleOrientation, TurnsABodyOfRandomWindingOutwards) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 20; ++round) {
        const TriangleSoup body = testing::shuffled(bumpy_sphere(3, 0.03), random);
        const OrientationOutcome outcome = oriented(testing::partly_turned(body, 0.5, random));
        EXPECT_TRUE(testing::is_watertight(outcome.triples));
        EXPECT_GT(volume_m3(outcome.triples, body.vertices_m), 0.0);
    }
}

TEST(TriangleOrientation, CountsAreaNotTriangles) {
    // An octahedron drawn out upwards: its four upper triangles have most of the area.
    const std::vector<Vector3> vertices_m = {{0.01, 0, 0},  {-0.01, 0, 0}, {0, 0, 0.01},
                                             {0, 0, -0.01}, {0, 0.1, 0},   {0, -0.001, 0}};
    const std::vector<VertexTriple> upper_inward = {{4, 0, 2}, {4, 2, 1}, {4, 1, 3}, {4, 3, 0}};
    std::vector<VertexTriple> triples = upper_inward;
    triples.insert(triples.end(), {{5, 0, 2}, {5, 2, 1}, {5, 1, 3}, {5, 3, 0}});
    const OrientationOutcome outcome = oriented(mesh_of(triples), vertices_m);
    EXPECT_TRUE(testing::is_watertight(outcome.triples));
    EXPECT_EQ(outcome.turned.of_one_winding, 4U);
    EXPECT_TRUE(std::equal(upper_inward.begin(), upper_inward.end(), outcome.triples.begin()));
}

TEST(TriangleOrientation, GivesASheetTheWindingOfItsLargerPart) {
    std::mt19937_64 random(1);
    TriangleSoup sheet;
    for (std::uint32_t i = 0; i < 50; ++i) {
        sheet.vertices_m.emplace_back(0.01 * i, 0.0, 0.0);
        sheet.vertices_m.emplace_back(0.01 * i, 0.0, 0.02);
    }
    for (std::uint32_t i = 0; i < 48; ++i) {
        const bool is_turned = i < 20; // 5/12 of it: no clear majority, and no inside either
        sheet.triangles.push_back((i % 2 == 0) != is_turned
                                      ? std::array<std::uint32_t, 3>{i, i + 1, i + 2}
                                      : std::array<std::uint32_t, 3>{i + 1, i, i + 2});
    }
    const OrientationOutcome outcome = oriented(sheet);
    EXPECT_EQ(outcome.turned.of_one_winding, 20U);
    EXPECT_EQ(outcome.triples.back(), sheet.triangles.back());
}

TEST(TriangleOrientation, LeavesAMobiusStripUnchangedAndTurnsOtherPatches) {
    std::vector<VertexTriple> strip = testing::twisted_strip(9, 1);
    std::vector<VertexTriple> triples = strip;
    triples.insert(triples.end(), {{20, 22, 21}, {20, 21, 23}, {21, 22, 23}, {20, 22, 23}});
    std::mt19937_64 random(1);
    std::vector<Vector3> vertices_m;
    vertices_m.reserve(24);
    for (int i = 0; i < 24; ++i) {
        vertices_m.push_back(testing::random_vector(random, 0.1));
    }
    const OrientationOutcome outcome = oriented(mesh_of(triples), vertices_m);
    EXPECT_TRUE(std::equal(strip.begin(), strip.end(), outcome.triples.begin()));
    EXPECT_EQ(outcome.turned.of_one_winding, 1U);
    EXPECT_TRUE(testing::is_watertight(
        std::vector<VertexTriple>(outcome.triples.end() - 4, outcome.triples.end())));
}

TEST(TriangleOrientation, LetsTrianglesOfBothWindingsFollowWithoutAVote) {
    const TriangleSoup body = bumpy_sphere(2, 0.03);
    std::vector<MeshTriangle> triangles = mesh_of(body.triangles);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % 10 != 0) {
            triangles[i].has_both_windings = true;
            std::swap(triangles[i].vertices[0], triangles[i].vertices[1]);
        }
    }
    const OrientationOutcome outcome = oriented(triangles, body.vertices_m);
    EXPECT_EQ(differences(outcome.triples, body.triangles), 0U);
    EXPECT_EQ(outcome.turned.of_one_winding, 0U);
    EXPECT_EQ(outcome.turned.of_both, 288U);
}

struct RepeatOutcome {
    std::vector<MeshTriangle> triangles;
    RepeatedTriangles repeated;
};

RepeatOutcome after_dropping(std::vector<MeshTriangle> triangles,
                             const std::vector<std::uint16_t> &materials, unsigned threads = 1) {
    const EdgeTable edges = edges_of(triangles);
    RepeatedTriangles repeated = drop_repeated_triangles(triangles, edges, materials, threads);
    return {std::move(triangles), std::move(repeated)};
}

VertexTriple lowest_first(VertexTriple vertices) {
    std::rotate(vertices.begin(), std::ranges::min_element(vertices), vertices.end());
    return vertices;
}

VertexTriple other_side(VertexTriple vertices) {
    std::swap(vertices[1], vertices[2]);
    return lowest_first(vertices);
}

/// Winding and material, which determine the contact with these triangles.
using Felt = std::set<std::pair<VertexTriple, std::uint16_t>>;

Felt felt(const std::vector<MeshTriangle> &triangles, const std::vector<std::uint16_t> &materials) {
    Felt result;
    for (const MeshTriangle &triangle : triangles) {
        const std::uint16_t material = materials[triangle.triangle];
        result.emplace(lowest_first(triangle.vertices), material);
        if (triangle.has_both_windings) {
            result.emplace(other_side(triangle.vertices), material);
        }
    }
    return result;
}

TEST(RepeatedTriangles, KeepsBothWindingsOfWhatWasMergedBefore) {
    std::vector<MeshTriangle> triangles = mesh_of({{0, 1, 2}, {0, 1, 2}});
    triangles[1].has_both_windings = true;
    const RepeatOutcome outcome = after_dropping(triangles, {0, 0});
    ASSERT_EQ(outcome.triangles.size(), 1U);
    EXPECT_TRUE(outcome.triangles.front().has_both_windings);
}

TEST(RepeatedTriangles, LeavesOneOfEachAndEverySideTouchable) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 500; ++round) {
        std::vector<VertexTriple> triples;
        std::vector<std::uint16_t> materials;
        for (int i = 0; i < 40; ++i) {
            VertexTriple triple = {0, 1, 2};
            std::array<std::uint32_t, 5> vertices = {0, 1, 2, 3, 4};
            std::ranges::shuffle(vertices, random);
            std::copy_n(vertices.begin(), 3, triple.begin());
            triples.push_back(triple);
            materials.push_back(static_cast<std::uint16_t>(random() % 4 == 0 ? 1 : 0));
        }
        const std::vector<MeshTriangle> before = mesh_of(triples);
        const RepeatOutcome outcome =
            after_dropping(before, materials, static_cast<unsigned>(1 + round % 3));

        // By brute force: of each winding the material of its first triangle.
        Felt expected;
        std::map<VertexTriple, std::uint32_t> first_of;
        for (const MeshTriangle &triangle : before) {
            if (first_of.emplace(lowest_first(triangle.vertices), triangle.triangle).second) {
                expected.emplace(lowest_first(triangle.vertices), materials[triangle.triangle]);
            }
        }
        ASSERT_EQ(felt(outcome.triangles, materials), expected);
        ASSERT_EQ(outcome.triangles.size() + outcome.repeated.same_winding.size() +
                      outcome.repeated.merged.size(),
                  before.size());
        std::set<VertexTriple> windings;
        for (const MeshTriangle &triangle : outcome.triangles) {
            ASSERT_TRUE(windings.insert(lowest_first(triangle.vertices)).second);
            ASSERT_EQ(first_of.at(lowest_first(triangle.vertices)), triangle.triangle);
        }
    }
}

TEST(RepeatedTriangles, HandlesAHundredThousandCopies) {
    std::vector<VertexTriple> triples(100000, {0, 1, 2});
    triples.push_back({0, 2, 1});
    const RepeatOutcome outcome =
        after_dropping(mesh_of(triples), std::vector<std::uint16_t>(triples.size(), 0), 2);
    EXPECT_EQ(outcome.triangles.size(), 1U);
    EXPECT_EQ(outcome.repeated.same_winding.size(), 99999U);
}

std::vector<std::uint32_t> slivers(const TriangleSoup &soup, unsigned threads = 1) {
    const std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    return slivers_to_leave_out(triangles, edges_of(triangles), soup.vertices_m, threads);
}

std::vector<FacetSource> facets(TriangleSoup soup, TouchSides sides) {
    soup.materials.front().sides = sides;
    const std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    return make_facets(triangles, {}, find_topology(triangles, edges_of(triangles)), soup, 1);
}

/// A rectangle 1 cm long in rows of two triangles, each row `height_m` high.
TriangleSoup rows(const std::vector<double> &heights_m) {
    TriangleSoup soup;
    soup.vertices_m = {{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}};
    double y_m = 0.0;
    for (const double height_m : heights_m) {
        y_m += height_m;
        const auto first = static_cast<std::uint32_t>(soup.vertices_m.size()) - 2;
        soup.vertices_m.emplace_back(0.0, y_m, 0.0);
        soup.vertices_m.emplace_back(0.01, y_m, 0.0);
        soup.triangles.push_back({first, first + 1, first + 3});
        soup.triangles.push_back({first, first + 3, first + 2});
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"rows", 0.0}};
    return soup;
}

TEST(SurfaceFacets, LeavesOutWhatIsLowerThanTheLeastHeight) {
    EXPECT_TRUE(slivers(rows({0.01, 1.01 * kMinHeight_m, 0.01})).empty());
    // Of the two in the row, which share their diagonal, one.
    EXPECT_EQ(slivers(rows({0.01, 0.99 * kMinHeight_m, 0.01})).size(), 1U);
}

TEST(SurfaceFacets, KeepsOneOfTwoSliversSideBySide) {
    const std::vector<double> heights_m(20, 0.9 * kMinHeight_m);
    const TriangleSoup soup = rows(heights_m);
    const std::vector<std::uint32_t> left_out = slivers(soup);
    EXPECT_EQ(left_out.size(), soup.triangles.size() / 2);
    std::vector<VertexTriple> triples;
    triples.reserve(left_out.size());
    for (const std::uint32_t index : left_out) {
        triples.push_back(soup.triangles[index]);
    }
    for (const auto &[edge, counts] : testing::edge_counts(triples)) {
        EXPECT_EQ(counts[0] + counts[1], 1);
    }
}

TEST(SurfaceFacets, LeavesOutOneOfABookOfSlivers) {
    // All share the edge from 0 to 1.
    constexpr std::uint32_t kLeaves = 20'000;
    TriangleSoup soup;
    soup.vertices_m = {{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}};
    for (std::uint32_t i = 0; i < kLeaves; ++i) {
        soup.vertices_m.emplace_back(0.01 * (i + 1) / (kLeaves + 1), 0.9 * kMinHeight_m, 0.0);
        soup.triangles.push_back({0, 1, i + 2});
    }
    EXPECT_EQ(slivers(soup), std::vector<std::uint32_t>{0});
    // One without a normal leaves the gap first.
    soup.vertices_m.back().y() = 0.0;
    EXPECT_EQ(slivers(soup), std::vector<std::uint32_t>{kLeaves - 1});
}

TEST(SurfaceFacets, LeavesTheSameOutInAnyNumberOfThreads) {
    std::vector<double> heights_m;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> exponent(-10.0, -5.0);
    heights_m.reserve(300);
    for (int i = 0; i < 300; ++i) {
        heights_m.push_back(std::pow(10.0, exponent(random)));
    }
    EXPECT_EQ(slivers(rows(heights_m), 2), slivers(rows(heights_m), 1));
    EXPECT_EQ(slivers(rows(heights_m), 3), slivers(rows(heights_m), 1));
}

TEST(SurfaceFacets, HaveTheSidesThatTheirMaterialSpecifies) {
    const TriangleSoup box = testing::box_soup({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01});
    TriangleSoup open = box;
    open.triangles.pop_back();
    const auto expect_all = [](const std::vector<FacetSource> &all, FacetSides sides) {
        for (const FacetSource &facet : all) {
            EXPECT_EQ(facet.sides, sides);
        }
    };
    expect_all(facets(box, TouchSides::automatic), FacetSides::one);
    expect_all(facets(open, TouchSides::automatic), FacetSides::two);
    expect_all(facets(box, TouchSides::two), FacetSides::two);
    expect_all(facets(open, TouchSides::one), FacetSides::one);
}

TEST(SurfaceFacets, HaveTwoSidesWhereBothWindingsWereGiven) {
    TriangleSoup box = box_soup({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01});
    box.materials.front().sides = TouchSides::one; // that its normals point to: both
    std::vector<MeshTriangle> triangles = mesh_of(box.triangles);
    triangles[7].has_both_windings = true;
    const std::vector<FacetSource> all =
        make_facets(triangles, {}, find_topology(triangles, edges_of(triangles)), box, 2);
    for (const FacetSource &facet : all) {
        EXPECT_EQ(facet.sides, facet.triangle == 7 ? FacetSides::two : FacetSides::one);
    }
}

TEST(SurfaceFacets, AreInOrderWithoutThoseLeftOut) {
    const TriangleSoup sphere = testing::icosphere(2, 0.03);
    const std::vector<MeshTriangle> triangles = mesh_of(sphere.triangles);
    const MeshTopology topology = find_topology(triangles, edges_of(triangles));
    const std::vector<std::uint32_t> left_out = {0, 5, 106, 107, 160, 319};
    for (const unsigned threads : {1U, 2U, 3U}) {
        const std::vector<FacetSource> all =
            make_facets(triangles, left_out, topology, sphere, threads);
        ASSERT_EQ(all.size(), triangles.size() - left_out.size());
        std::uint32_t triangle = 0;
        for (const FacetSource &facet : all) {
            while (std::ranges::count(left_out, triangle) > 0) {
                ++triangle;
            }
            ASSERT_EQ(facet.triangle, triangle);
            ASSERT_EQ(facet.corners_m, testing::corners(sphere, triangle));
            ++triangle;
        }
    }
}

} // namespace
} // namespace springdrive::contact
