#include "tests/support/hard_meshes.h"

#include "engine/lab/rig/scenario/test_surfaces.h"
#include "tests/support/configurations.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace springdrive::testing {

namespace {

using contact::TriangleSoup;
using Random = std::mt19937_64;

constexpr double kTurn = 2.0 * std::numbers::pi;

double between(Random &random, double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(random);
}

/// Evenly distributed on a logarithmic scale.
double of_any_size(Random &random, double lower, double upper) {
    return std::exp(between(random, std::log(lower), std::log(upper)));
}

bool one_in(Random &random, unsigned count) { return random() % count == 0; }

int integer(Random &random, int lower, int upper) {
    return std::uniform_int_distribution<int>(lower, upper)(random);
}

std::uint32_t number(int i) { return static_cast<std::uint32_t>(i); }

TriangleSoup complete(TriangleSoup soup) {
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"hard", 0.0}};
    return soup;
}

/// Two triangles for each cell of a grid of vertices, divided along either diagonal; a share of the
/// cells is left out.
void add_grid(TriangleSoup &soup, Random &random, std::uint32_t first, int rows, int columns,
              double hole_share) {
    const auto at = [&](int row, int column) { return first + number(row * columns + column); };
    for (int row = 0; row + 1 < rows; ++row) {
        for (int column = 0; column + 1 < columns; ++column) {
            if (between(random, 0.0, 1.0) < hole_share) {
                continue;
            }
            const std::uint32_t a = at(row, column);
            const std::uint32_t b = at(row, column + 1);
            const std::uint32_t c = at(row + 1, column + 1);
            const std::uint32_t d = at(row + 1, column);
            if (one_in(random, 2)) {
                soup.triangles.insert(soup.triangles.end(), {{a, b, c}, {a, c, d}});
            } else {
                soup.triangles.insert(soup.triangles.end(), {{a, b, d}, {b, c, d}});
            }
        }
    }
}

TriangleSoup height_fields(Random &random, int layers, double apart_m) {
    TriangleSoup soup;
    const int side = integer(random, 9, 32);
    const double cell_m = of_any_size(random, 5e-5, 1e-3);
    const double noise_m = cell_m * of_any_size(random, 0.01, 2.0);
    const double jitter_m = between(random, 0.0, 0.45) * cell_m;
    const double hole_share = one_in(random, 3) ? 0.05 : 0.0;
    const double bend_x_per_m = between(random, -40.0, 40.0);
    const double bend_z_per_m = between(random, -40.0, 40.0);
    std::vector<Vector3> field;
    for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side; ++j) {
            const double x = cell_m * (i - 0.5 * side) + between(random, -jitter_m, jitter_m);
            const double z = cell_m * (j - 0.5 * side) + between(random, -jitter_m, jitter_m);
            const double y = 0.5 * (bend_x_per_m * x * x + bend_z_per_m * z * z);
            field.emplace_back(x, y + between(random, -noise_m, noise_m), z);
        }
    }
    for (int layer = 0; layer < layers; ++layer) {
        const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
        for (const Vector3 &point : field) {
            soup.vertices_m.emplace_back(point - layer * apart_m * Vector3::UnitY());
        }
        add_grid(soup, random, first, side, side, hole_share);
    }
    return complete(std::move(soup));
}

Eigen::Isometry3d any_place(Random &random, double within_m) {
    const Vector3 axis = random_direction(random);
    Eigen::Isometry3d place(Eigen::AngleAxisd(between(random, 0.0, kTurn), axis));
    place.pretranslate(random_vector(random, within_m));
    return place;
}

/// What comes out of a file with coordinates in 32 bits.
TriangleSoup rounded(TriangleSoup soup) {
    for (Vector3 &vertex_m : soup.vertices_m) {
        vertex_m = vertex_m.cast<float>().cast<double>();
    }
    return soup;
}

void add(TriangleSoup &soup, const TriangleSoup &other, const Eigen::Isometry3d &place) {
    const auto first = number(static_cast<int>(soup.vertices_m.size()));
    for (const Vector3 &vertex_m : other.vertices_m) {
        soup.vertices_m.emplace_back(place * vertex_m);
    }
    for (const auto &[a, b, c] : other.triangles) {
        soup.triangles.push_back({first + a, first + b, first + c});
    }
}

/// Each triangle divided into four at the middles of its edges.
TriangleSoup divided(const TriangleSoup &whole) {
    TriangleSoup soup;
    soup.vertices_m = whole.vertices_m;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto next = static_cast<std::uint32_t>(soup.vertices_m.size());
        const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), next);
        if (is_new) {
            soup.vertices_m.emplace_back(0.5 * (whole.vertices_m[a] + whole.vertices_m[b]));
        }
        return entry->second;
    };
    for (const auto &[a, b, c] : whole.triangles) {
        const std::uint32_t ab = middle(a, b);
        const std::uint32_t bc = middle(b, c);
        const std::uint32_t ca = middle(c, a);
        soup.triangles.insert(soup.triangles.end(),
                              {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    return complete(std::move(soup));
}

TriangleSoup torn(const TriangleSoup &whole) {
    TriangleSoup soup;
    for (const auto &triangle : whole.triangles) {
        const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
        for (const std::uint32_t vertex : triangle) {
            soup.vertices_m.push_back(whole.vertices_m[vertex]);
        }
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    return complete(std::move(soup));
}

} // namespace

TriangleSoup scan(Random &random) { return height_fields(random, 1, 0.0); }

TriangleSoup thin_shell(Random &random) {
    return height_fields(random, 2, of_any_size(random, 3e-7, 5e-4));
}

TriangleSoup fillet(Random &random) {
    const int slices = integer(random, 4, 24);
    const double radius_m = of_any_size(random, 2e-4, 5e-3);
    const double length_m = radius_m * of_any_size(random, 1.0, 500.0);
    const double angle = between(random, 0.3, 2.5);
    const double sign = one_in(random, 2) ? 1.0 : -1.0; // convex or concave
    const double flank_m = radius_m * between(random, 1.0, 5.0);
    const auto on_arc = [&](double turn) {
        return Vector3(radius_m * std::sin(turn), sign * radius_m * (std::cos(turn) - 1.0), 0.0);
    };
    const auto along_arc = [&](double turn) {
        return Vector3(std::cos(turn), -sign * std::sin(turn), 0.0);
    };
    std::vector<Vector3> profile{on_arc(-0.5 * angle) - flank_m * along_arc(-0.5 * angle)};
    for (int i = 0; i <= slices; ++i) {
        profile.push_back(on_arc(angle * (i / static_cast<double>(slices) - 0.5)));
    }
    profile.emplace_back(on_arc(0.5 * angle) + flank_m * along_arc(0.5 * angle));
    const int columns = integer(random, 2, 4);
    const double jitter_m = one_in(random, 2) ? 0.0 : 0.3 * length_m / columns;
    TriangleSoup soup;
    for (const Vector3 &corner : profile) {
        for (int j = 0; j < columns; ++j) {
            const double z = length_m * (j / (columns - 1.0) - 0.5);
            soup.vertices_m.emplace_back(corner.x(), corner.y(),
                                         z + between(random, -jitter_m, jitter_m));
        }
    }
    add_grid(soup, random, 0, static_cast<int>(profile.size()), columns, 0.0);
    return complete(std::move(soup));
}

TriangleSoup fan(Random &random) {
    const bool is_large = one_in(random, 8);
    const int count = is_large ? integer(random, 80, 600) : integer(random, 4, 80);
    // Those with a round rim and equal sectors are smooth, unless there is noise.
    const double jagged = is_large && one_in(random, 2) ? 0.0 : 1.0;
    const double radius_m = of_any_size(random, 5e-4, 1e-2);
    const double wave_m = radius_m * of_any_size(random, 1e-3, 2.0);
    const double height_m =
        radius_m * of_any_size(random, 1e-3, 5.0) * (one_in(random, 2) ? 1 : -1);
    const double noise_m = one_in(random, 2) ? 0.0 : 0.3 * wave_m;
    const int waves = integer(random, 0, 4);
    TriangleSoup soup;
    soup.vertices_m.emplace_back(Vector3::Zero());
    for (int i = 0; i < count; ++i) {
        const double turn = kTurn * (i + jagged * between(random, -0.3, 0.3)) / count;
        const double out_m = radius_m * (1.0 - jagged * between(random, 0.0, 0.5));
        soup.vertices_m.emplace_back(out_m * std::cos(turn),
                                     height_m + wave_m * std::cos(waves * turn) +
                                         between(random, -noise_m, noise_m),
                                     out_m * std::sin(turn));
    }
    for (int i = 0; i < count; ++i) {
        soup.triangles.push_back({0, number(1 + (i + 1) % count), number(1 + i)});
    }
    return complete(std::move(soup));
}

TriangleSoup book(Random &random) {
    const int pages = integer(random, 2, 60);
    const double spine_m = of_any_size(random, 1e-3, 1e-2);
    const double opening = between(random, 0.1, 1.0) * kTurn;
    TriangleSoup soup;
    soup.vertices_m = {{-0.5 * spine_m, 0.0, 0.0}, {0.5 * spine_m, 0.0, 0.0}};
    for (int i = 0; i < pages; ++i) {
        const double turn = opening * i / pages;
        const double out_m = spine_m * between(random, 0.3, 2.0);
        soup.vertices_m.emplace_back(spine_m * between(random, -0.5, 0.5), out_m * std::cos(turn),
                                     out_m * std::sin(turn));
        soup.triangles.push_back({0, 1, number(2 + i)});
    }
    return complete(std::move(soup));
}

TriangleSoup open_ball(Random &random) {
    const int rows = integer(random, 5, 24);
    const int columns = integer(random, 5, 32);
    const double radius_m = of_any_size(random, 1e-3, 2e-2);
    const double noise_m = radius_m * of_any_size(random, 1e-4, 0.1);
    const double open = between(random, 0.2, 0.8);
    TriangleSoup soup;
    for (int row = 1; row <= rows; ++row) {
        const double polar = open + (std::numbers::pi - open) * (row - 0.5) / rows;
        for (int column = 0; column < columns; ++column) {
            const double turn = kTurn * column / columns;
            const double out_m = radius_m + between(random, -noise_m, noise_m);
            soup.vertices_m.emplace_back(out_m * std::sin(polar) * std::cos(turn),
                                         out_m * std::cos(polar),
                                         out_m * std::sin(polar) * std::sin(turn));
        }
    }
    const auto at = [&](int row, int column) { return number(row * columns + column % columns); };
    for (int row = 0; row + 1 < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            soup.triangles.push_back({at(row, column), at(row, column + 1), at(row + 1, column)});
            soup.triangles.push_back(
                {at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)});
        }
    }
    const auto pole = static_cast<std::uint32_t>(soup.vertices_m.size());
    soup.vertices_m.emplace_back(0.0, -radius_m, 0.0);
    for (int column = 0; column < columns; ++column) {
        soup.triangles.push_back({at(rows - 1, column), at(rows - 1, column + 1), pole});
    }
    return complete(std::move(soup));
}

TriangleSoup tangle(Random &random) {
    const int count = integer(random, 4, 64);
    const double half_m = of_any_size(random, 1e-3, 1e-2);
    TriangleSoup soup;
    for (int i = 0; i < count; ++i) {
        const Vector3 middle_m = random_vector(random, half_m).cwiseProduct(Vector3(1.0, 0.3, 1.0));
        const double size_m = half_m * of_any_size(random, 0.03, 2.0);
        for (int corner = 0; corner < 3; ++corner) {
            soup.vertices_m.emplace_back(middle_m +
                                         between(random, 0.0, size_m) * random_direction(random));
        }
        soup.triangles.push_back({number(3 * i), number(3 * i + 1), number(3 * i + 2)});
    }
    return complete(std::move(soup));
}

TriangleSoup machined_part(Random &random) {
    TriangleSoup soup =
        rig::machined_surface(static_cast<std::size_t>(of_any_size(random, 1e3, 6e3)));
    Vector3 stretch = Vector3::Ones() + random_vector(random, 0.4);
    stretch *= of_any_size(random, 0.05, 1.0);
    for (Vector3 &vertex_m : soup.vertices_m) {
        vertex_m = vertex_m.cwiseProduct(stretch);
    }
    return rounded(complete(std::move(soup)));
}

TriangleSoup subdivided_scan(Random &random) {
    const TriangleSoup soup = divided(scan(random));
    return rounded(soup.triangles.size() < 1500 && one_in(random, 2) ? divided(soup) : soup);
}

TriangleSoup in_32_bits(Random &random) {
    constexpr std::array kKinds{scan, fillet, fan, book, open_ball, tangle};
    TriangleSoup soup;
    const TriangleSoup part = kKinds[random() % kKinds.size()](random);
    add(soup, part, any_place(random, 0.3));
    return rounded(complete(std::move(soup)));
}

TriangleSoup crossing_fields(Random &random) {
    TriangleSoup soup;
    for (int i = integer(random, 2, 3); i > 0; --i) {
        const TriangleSoup field = scan(random);
        add(soup, field, any_place(random, 1e-3));
    }
    return complete(std::move(soup));
}

TriangleSoup crossing_bodies(Random &random) {
    TriangleSoup soup;
    const double size_m = of_any_size(random, 1e-3, 2e-2);
    for (int i = integer(random, 2, 5); i > 0; --i) {
        Vector3 half_m = Vector3::Ones() + random_vector(random, 0.5);
        half_m *= size_m * of_any_size(random, 0.2, 1.0);
        const TriangleSoup body = one_in(random, 2)
                                      ? rig::solid_box(-half_m, half_m)
                                      : rig::icosphere(integer(random, 0, 2), half_m.x());
        add(soup, body, any_place(random, 0.6 * size_m));
    }
    return complete(std::move(soup));
}

HardMesh hard_mesh(const HardMeshKind &kind, std::uint64_t seed) {
    Random random(seed);
    HardMesh made{std::string(kind.name), kind.make(random)};
    if (one_in(random, 4)) {
        made.soup = torn(made.soup);
        made.name += ", torn";
    }
    constexpr std::array kSides{contact::TouchSides::one, contact::TouchSides::two,
                                contact::TouchSides::automatic};
    made.soup.materials[0].sides = kSides[random() % kSides.size()];
    if (one_in(random, 2)) {
        const Eigen::AngleAxisd turn(between(random, 0.0, kTurn), random_direction(random));
        const Vector3 offset_m = random_vector(random, 0.05);
        for (Vector3 &vertex_m : made.soup.vertices_m) {
            vertex_m = turn * vertex_m + offset_m;
        }
    }
    return made;
}

ProbingTip::ProbingTip(const TriangleSoup &soup, std::uint64_t seed)
    : soup_(soup), random_(seed), step_m_(of_any_size(random_, 3e-6, 5e-4)) {
    for (const Vector3 &vertex_m : soup.vertices_m) {
        box_.extend(vertex_m);
    }
    tip_m_ = box_.center() + 0.7 * box_.diagonal().norm() * random_direction(random_);
}

Vector3 ProbingTip::place_in_the_mesh() {
    const auto &[a, b, c] = soup_.triangles[random_() % soup_.triangles.size()];
    const std::array corners_m{soup_.vertices_m[a], soup_.vertices_m[b], soup_.vertices_m[c]};
    double u = between(random_, 0.0, 1.0);
    double v = between(random_, 0.0, 1.0);
    if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    switch (random_() % 6) {
    case 0: // a corner
        u = v = 0.0;
        break;
    case 1: // an edge
        v = 0.0;
        break;
    default:
        break;
    }
    const Vector3 to_b = corners_m[1] - corners_m[0];
    const Vector3 to_c = corners_m[2] - corners_m[0];
    const Vector3 inwards = -(to_b.cross(to_c).normalized() + 0.3 * random_direction(random_));
    return corners_m[0] + u * to_b + v * to_c + of_any_size(random_, 1e-5, 5e-3) * inwards;
}

const Vector3 &ProbingTip::advance() {
    if (steps_left_-- <= 0) {
        steps_left_ = integer(random_, 20, 120);
        is_fast_ = one_in(random_, 4);
        aim_m_ =
            one_in(random_, 8)
                ? Vector3(box_.center() + 0.6 * box_.diagonal().norm() * random_direction(random_))
                : place_in_the_mesh();
    }
    const Vector3 left_m = aim_m_ - tip_m_;
    const double distance_m = left_m.norm();
    double longest_m = std::max(step_m_, distance_m / (steps_left_ + 1));
    if (!is_fast_) {
        longest_m = std::min(longest_m, 1e-3);
    }
    tip_m_ += distance_m > longest_m ? Vector3(longest_m / distance_m * left_m) : left_m;
    wobble_ = (wobble_ + 0.3 * random_direction(random_)).normalized();
    tip_m_ += 0.1 * step_m_ * wobble_;
    return tip_m_;
}

} // namespace springdrive::testing
