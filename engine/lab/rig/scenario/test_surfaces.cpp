#include "engine/lab/rig/scenario/test_surfaces.h"

#include "base/bisection.h"
#include "base/input_error.h"
#include "base/text.h"
#include "engine/lab/rig/scenario/known_shapes.h"
#include "engine/lab/rig/scenario/scanned_surface.h"
#include "engine/scene/gltf.h"
#include "engine/scene/scene.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace springdrive::rig {

namespace {

constexpr double kFlat_m = 24e-3; ///< half the length of what is left of the block's edges
constexpr double kRounding_m = 1e-3;
constexpr double kFace_m = kFlat_m + kRounding_m;
constexpr double kShaftRadius_m = 18e-3;
constexpr double kShaftEnd_m = 45e-3; ///< from the middle of the block
constexpr double kFoot_m = 1.5e-3;    ///< radius of its fillet
constexpr double kEnd_m = 1e-3;       ///< radius of its rounding

/// The share of the triangles that the block's corners and edges get.
constexpr double kBlockShare = 0.325;

/// Numbers of pieces into which it is divided.
struct Divisions {
    int rounding; ///< quarter circle of the block
    int fillet;   ///< quarter circle of a shaft
    int turn;     ///< circle of a shaft, a multiple of four
};

Divisions divisions_for(std::size_t triangles) {
    const auto requested = static_cast<double>(triangles);
    Divisions into{};
    into.fillet = std::max(2, static_cast<int>(std::lround(std::cbrt(requested / 4600.0))));
    // Eight corners of n² triangles, twelve edges of 2 n.
    into.rounding = std::max(2, static_cast<int>(std::sqrt(kBlockShare * requested / 8.0) - 1.5));
    const double block = 8.0 * (into.rounding * into.rounding + 3 * into.rounding) + 8.0;
    // Two shafts, each a face as far as its foot, two fillets, a cylinder and an end.
    const double per_turn = 2.0 * (1.0 + 4.0 * into.fillet + 2.0 + 1.0);
    into.turn =
        std::max(8, 4 * static_cast<int>(std::lround((requested - block) / (4.0 * per_turn))));
    return into;
}

using Row = std::vector<std::uint32_t>;

class Part {
public:
    explicit Part(const Divisions &into) : into_(into) {
        for (int corner = 0; corner < 8; ++corner) {
            add_corner(corner);
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            add_edges(axis);
        }
        for (const std::size_t axis : {std::size_t{1}, std::size_t{2}}) {
            for (const int side : {-1, 1}) {
                const std::array<std::uint32_t, 4> corners = face_corners(axis, side);
                const Vector3 outwards = side * Vector3::Unit(static_cast<Eigen::Index>(axis));
                add_quad(corners[0], corners[1], corners[2], corners[3], outwards);
            }
        }
        add_shaft(-1);
        add_shaft(1);
    }

    contact::TriangleSoup take() {
        soup_.material_of_triangle.assign(soup_.triangles.size(), 0);
        soup_.materials = {{"part", 0.0}};
        return std::move(soup_);
    }

private:
    std::uint32_t add(const Vector3 &vertex_m) {
        soup_.vertices_m.push_back(vertex_m);
        return static_cast<std::uint32_t>(soup_.vertices_m.size() - 1);
    }

    /// Wound so that its normal is on the side of `outwards`.
    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Vector3 &outwards) {
        const Vector3 to_b = soup_.vertices_m[b] - soup_.vertices_m[a];
        const Vector3 to_c = soup_.vertices_m[c] - soup_.vertices_m[a];
        if (to_b.cross(to_c).dot(outwards) < 0.0) {
            std::swap(b, c);
        }
        soup_.triangles.push_back({a, b, c});
    }

    /// Around its corners in this order.
    void add_quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d,
                  const Vector3 &outwards) {
        add_triangle(a, b, c, outwards);
        add_triangle(a, c, d, outwards);
    }

    static Vector3 signs_of(int corner) {
        return {(corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0,
                (corner & 4) != 0 ? 1.0 : -1.0};
    }

    /// An eighth of a sphere: rows of vertices, the first of which is the face's corner along x.
    void add_corner(int corner) {
        const int n = into_.rounding;
        const Vector3 signs = signs_of(corner);
        const auto height = [&](int share) { return std::sin(0.5 * std::numbers::pi * share / n); };
        std::vector<Row> rows;
        for (int row = 0; row <= n; ++row) {
            rows.emplace_back();
            for (int i = 0; i <= row; ++i) {
                const Vector3 normal =
                    Vector3(height(n - row), height(row - i), height(i)).normalized();
                rows.back().push_back(
                    add(signs.cwiseProduct(Vector3::Constant(kFlat_m) + kRounding_m * normal)));
            }
        }
        for (std::size_t row = 1; row < rows.size(); ++row) {
            const Row &above = rows[row - 1];
            const Row &below = rows[row];
            for (std::size_t i = 0; i < above.size(); ++i) {
                add_triangle(above[i], below[i], below[i + 1], signs);
                if (i + 1 < above.size()) {
                    add_triangle(above[i], below[i + 1], above[i + 1], signs);
                }
            }
        }
        corner_rows_.push_back(std::move(rows));
    }

    /// The vertices of a corner where the rounding of an edge along `axis` begins.
    [[nodiscard]] Row corner_arc(int corner, std::size_t axis) const {
        const std::vector<Row> &rows = corner_rows_[static_cast<std::size_t>(corner)];
        if (axis == 0) {
            return rows.back();
        }
        Row arc;
        for (const Row &row : rows) {
            arc.push_back(axis == 1 ? row.back() : row.front());
        }
        return arc;
    }

    void add_edges(std::size_t axis) {
        const int bit = 1 << axis;
        for (int corner = 0; corner < 8; ++corner) {
            if ((corner & bit) != 0) {
                continue;
            }
            const Row from = corner_arc(corner, axis);
            const Row to = corner_arc(corner | bit, axis);
            Vector3 outwards = signs_of(corner);
            outwards[static_cast<Eigen::Index>(axis)] = 0.0;
            for (std::size_t i = 0; i + 1 < from.size(); ++i) {
                add_quad(from[i], to[i], to[i + 1], from[i + 1], outwards);
            }
        }
    }

    /// Around the flat face.
    [[nodiscard]] std::array<std::uint32_t, 4> face_corners(std::size_t axis, int side) const {
        const int first = 1 << ((axis + 1) % 3);
        const int second = 1 << ((axis + 2) % 3);
        const int common = side > 0 ? 1 << axis : 0;
        const auto vertex = [&](int corner) {
            const std::vector<Row> &rows = corner_rows_[static_cast<std::size_t>(common | corner)];
            return axis == 0   ? rows.front().front()
                   : axis == 1 ? rows.back().front()
                               : rows.back().back();
        };
        return {vertex(first | second), vertex(second), vertex(0), vertex(first)};
    }

    Row add_circle(int side, double x_m, double radius_m) {
        Row circle;
        for (int i = 0; i < into_.turn; ++i) {
            const double turn = 2.0 * std::numbers::pi * i / into_.turn;
            circle.push_back(
                add({side * x_m, radius_m * std::cos(turn), radius_m * std::sin(turn)}));
        }
        return circle;
    }

    /// The face along x as far as the shaft's foot: each corner a fan to a quarter of the circle.
    void add_face(int side, const Row &foot) {
        const std::array<std::uint32_t, 4> corners = face_corners(0, side);
        const Vector3 outwards = side * Vector3::UnitX();
        for (std::size_t i = 0; i < foot.size(); ++i) {
            const std::size_t quarter = 4 * i / foot.size();
            if (4 * i % foot.size() == 0) {
                add_triangle(foot[i], corners[(quarter + 3) % 4], corners[quarter], outwards);
            }
            add_triangle(foot[i], foot[(i + 1) % foot.size()], corners[quarter], outwards);
        }
    }

    void add_band(const Row &from, const Row &to) {
        for (std::size_t i = 0; i < from.size(); ++i) {
            const std::size_t next = (i + 1) % from.size();
            // Away from the axis, or along it where the band is flat: both for any of these.
            const Vector3 &here_m = soup_.vertices_m[from[i]];
            const Vector3 outwards(std::copysign(kShaftRadius_m, here_m.x()), here_m.y(),
                                   here_m.z());
            add_quad(from[i], from[next], to[next], to[i], outwards);
        }
    }

    void add_shaft(int side) {
        const auto quarter_turn = [&](int share) {
            return 0.5 * std::numbers::pi * share / into_.fillet;
        };
        std::vector<Row> circles;
        for (int i = 0; i <= into_.fillet; ++i) {
            const double turn = quarter_turn(i);
            circles.push_back(add_circle(side, kFace_m + kFoot_m * (1.0 - std::cos(turn)),
                                         kShaftRadius_m + kFoot_m * (1.0 - std::sin(turn))));
        }
        for (int i = 0; i <= into_.fillet; ++i) {
            const double turn = quarter_turn(i);
            circles.push_back(add_circle(side, kShaftEnd_m - kEnd_m * (1.0 - std::sin(turn)),
                                         kShaftRadius_m - kEnd_m * (1.0 - std::cos(turn))));
        }
        add_face(side, circles.front());
        for (std::size_t i = 1; i < circles.size(); ++i) {
            add_band(circles[i - 1], circles[i]);
        }
        const Row &rim = circles.back();
        const Vector3 outwards = side * Vector3::UnitX();
        if (side > 0) {
            const std::uint32_t middle = add({kShaftEnd_m, 0.0, 0.0});
            for (std::size_t i = 0; i < rim.size(); ++i) {
                add_triangle(middle, rim[i], rim[(i + 1) % rim.size()], outwards);
            }
        } else {
            for (std::size_t i = 1; i + 1 < rim.size(); ++i) {
                add_triangle(rim[0], rim[i], rim[i + 1], outwards);
            }
        }
    }

    Divisions into_;
    contact::TriangleSoup soup_;
    std::vector<std::vector<Row>> corner_rows_; ///< of each corner
};

bool is_inside_block(const Vector3 &place_m) {
    const Vector3 beyond_m =
        (place_m.cwiseAbs() - Vector3::Constant(kFlat_m)).cwiseMax(Vector3::Zero());
    return beyond_m.norm() < kRounding_m;
}

bool is_inside_shafts(const Vector3 &place_m) {
    const double x_m = std::abs(place_m.x());
    const double from_axis_m = std::hypot(place_m.y(), place_m.z());
    const double above_foot_m = std::max(0.0, kFace_m + kFoot_m - x_m);
    const double into_end_m = std::max(0.0, x_m - (kShaftEnd_m - kEnd_m));
    if (above_foot_m > kFoot_m || into_end_m > kEnd_m) {
        return false; // in the block's range, or beyond the end
    }
    const double foot_m = kFoot_m - std::sqrt(kFoot_m * kFoot_m - above_foot_m * above_foot_m);
    const double end_m = kEnd_m - std::sqrt(kEnd_m * kEnd_m - into_end_m * into_end_m);
    return from_axis_m < kShaftRadius_m + foot_m - end_m;
}

} // namespace

contact::TriangleSoup machined_surface(std::size_t triangles) {
    return Part(divisions_for(triangles)).take();
}

double machined_body_radius_m(const Vector3 &direction) {
    return bisect({0.0, 2.0 * kShaftEnd_m}, 60,
                  [&](double radius_m) {
                      const Vector3 place_m = radius_m * direction;
                      return is_inside_block(place_m) || is_inside_shafts(place_m);
                  })
        .middle();
}

namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr std::string_view kSphere = "sphere:";
constexpr std::string_view kBumpy = "bumpy:";
constexpr std::string_view kOrganic = "organic:";
constexpr std::string_view kScan = "scan:";
constexpr std::string_view kCad = "cad:";

constexpr int kMinDivisions = 3;
constexpr int kMaxDivisions = 8;

constexpr std::size_t kMinTriangles = 1'000;
constexpr std::size_t kMaxTriangles = 2'000'000;

std::size_t triangles_after(int divisions) { return std::size_t{20} << (2 * divisions); }

contact::TriangleSoup icosahedron() {
    const double g = std::numbers::phi;
    contact::TriangleSoup soup;
    // Three golden rectangles, square to each other.
    soup.vertices_m = {{0, -1, -g}, {0, 1, -g}, {0, -1, g},  {0, 1, g},  {-g, 0, -1}, {-g, 0, 1},
                       {g, 0, -1},  {g, 0, 1},  {-1, -g, 0}, {1, -g, 0}, {-1, g, 0},  {1, g, 0}};
    // Faces are the triples of corners that are an edge, of length 2, apart.
    const auto are_joined = [&](std::uint32_t a, std::uint32_t b) {
        return (soup.vertices_m[a] - soup.vertices_m[b]).squaredNorm() < 5.0;
    };
    for (std::uint32_t a = 0; a < 12; ++a) {
        for (std::uint32_t b = a + 1; b < 12; ++b) {
            for (std::uint32_t c = b + 1; c < 12; ++c) {
                if (are_joined(a, b) && are_joined(b, c) && are_joined(c, a)) {
                    Matrix3 corners;
                    corners << soup.vertices_m[a], soup.vertices_m[b], soup.vertices_m[c];
                    const bool turns_outwards =
                        corners.col(0).cross(corners.col(1)).dot(corners.col(2)) > 0.0;
                    soup.triangles.push_back(turns_outwards ? Triangle{a, b, c}
                                                            : Triangle{a, c, b});
                }
            }
        }
    }
    for (Vector3 &vertex : soup.vertices_m) {
        vertex.normalize();
    }
    return soup;
}

/// Creates one vertex for each edge: its middle.
class Middles {
public:
    Middles(std::vector<Vector3> &vertices, std::size_t edges) : vertices_(vertices) {
        known_.reserve(edges);
        vertices_.reserve(vertices_.size() + edges);
    }

    std::uint32_t between(std::uint32_t a, std::uint32_t b) {
        const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
        const auto [found, is_new] =
            known_.try_emplace(key, static_cast<std::uint32_t>(vertices_.size()));
        if (is_new) {
            vertices_.emplace_back((vertices_[a] + vertices_[b]).normalized());
        }
        return found->second;
    }

private:
    std::vector<Vector3> &vertices_;
    std::unordered_map<std::uint64_t, std::uint32_t> known_;
};

void divide(contact::TriangleSoup &soup) {
    Middles middles(soup.vertices_m, soup.triangles.size() * 3 / 2);
    std::vector<Triangle> finer;
    finer.reserve(4 * soup.triangles.size());
    for (const auto &[a, b, c] : soup.triangles) {
        const std::uint32_t ab = middles.between(a, b);
        const std::uint32_t bc = middles.between(b, c);
        const std::uint32_t ca = middles.between(c, a);
        finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    soup.triangles = std::move(finer);
}

/// The number of divisions that gives the number of triangles in a name.
int divisions_of(std::string_view name, std::string_view count) {
    const std::optional<std::size_t> triangles = number_in<std::size_t>(count);
    std::string choices;
    for (int divisions = kMinDivisions; divisions <= kMaxDivisions; ++divisions) {
        if (triangles == triangles_after(divisions)) {
            return divisions;
        }
        choices += (choices.empty()              ? ""
                    : divisions == kMaxDivisions ? " or "
                                                 : ", ") +
                   std::to_string(triangles_after(divisions));
    }
    throw InputError(std::string(name) + ": triangles must be " + choices);
}

/// The number of triangles in a name, for surfaces of any number.
std::size_t triangles_of(std::string_view name, std::string_view count) {
    const std::optional<std::size_t> triangles = number_in<std::size_t>(count);
    if (!triangles || *triangles < kMinTriangles || *triangles > kMaxTriangles) {
        throw InputError(std::string(name) + ": triangles must be from " +
                         std::to_string(kMinTriangles) + " to " + std::to_string(kMaxTriangles));
    }
    return *triangles;
}

} // namespace

contact::TriangleSoup icosphere(int divisions, double radius_m) {
    contact::TriangleSoup soup = icosahedron();
    for (int i = 0; i < divisions; ++i) {
        divide(soup);
    }
    for (Vector3 &vertex : soup.vertices_m) {
        vertex = radius_m * vertex.normalized();
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"sphere", 0.0}};
    return soup;
}

contact::TriangleSoup bumpy_sphere(int divisions, double radius_m, double height_m,
                                   double length_m) {
    contact::TriangleSoup soup = icosphere(divisions, radius_m);
    const double k = 2.0 * std::numbers::pi / length_m;
    for (Vector3 &vertex : soup.vertices_m) {
        const double height =
            std::sin(k * vertex.x()) * std::sin(k * vertex.y()) * std::sin(k * vertex.z());
        vertex *= 1.0 + height_m / radius_m * height;
    }
    soup.materials = {{"bumpy sphere", 0.0}};
    return soup;
}

contact::TriangleSoup organic_surface(int divisions, double scale_m) {
    contact::TriangleSoup soup = icosphere(divisions, 1.0);
    for (Vector3 &vertex : soup.vertices_m) {
        vertex *= scale_m * organic_shape().distance(vertex);
    }
    soup.materials = {{"organic", 0.0}};
    return soup;
}

contact::TriangleSoup solid_box(const Vector3 &lower_m, const Vector3 &upper_m) {
    const auto corner = [&](int which) {
        return Vector3((which & 1) != 0 ? upper_m.x() : lower_m.x(),
                       (which & 2) != 0 ? upper_m.y() : lower_m.y(),
                       (which & 4) != 0 ? upper_m.z() : lower_m.z());
    };
    constexpr std::array<std::array<int, 4>, 6> kFaces{
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    contact::TriangleSoup soup;
    for (const auto &[a, b, c, d] : kFaces) {
        for (const int which : {a, b, c, a, c, d}) {
            soup.vertices_m.push_back(corner(which));
        }
    }
    const auto count = static_cast<std::uint32_t>(soup.vertices_m.size());
    for (std::uint32_t first = 0; first < count; first += 3) {
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"rigid"}};
    return soup;
}

std::optional<contact::TriangleSoup> test_surface_named(std::string_view name) {
    if (names_test_sphere(name)) {
        return icosphere(divisions_of(name, name.substr(kSphere.size())), kTestSphereRadius_m);
    }
    if (name.starts_with(kBumpy)) {
        return bumpy_sphere(divisions_of(name, name.substr(kBumpy.size())), kTestSphereRadius_m,
                            kTestBumpHeight_m, kTestBumpLength_m);
    }
    if (name.starts_with(kOrganic)) {
        return organic_surface(divisions_of(name, name.substr(kOrganic.size())),
                               kTestOrganicScale_m);
    }
    if (name.starts_with(kScan)) {
        return scanned_surface(triangles_of(name, name.substr(kScan.size())), kTestScanSeed);
    }
    if (name.starts_with(kCad)) {
        return machined_surface(triangles_of(name, name.substr(kCad.size())));
    }
    return std::nullopt;
}

scene::Scene touch_scene(const std::string &name, const device::Workspace &workspace,
                         scene::LoadProgress *progress, const std::string &gltf_scene) {
    std::optional<contact::TriangleSoup> surface = test_surface_named(name);
    if (!surface) {
        return scene::load_gltf(name, workspace, progress, gltf_scene);
    }
    if (!gltf_scene.empty()) {
        throw InputError(name + ": is no glTF file, so it has no scene " + in_quotes(gltf_scene));
    }
    scene::BoundingBox box;
    for (const Vector3 &vertex_m : surface->vertices_m) {
        box.include(vertex_m);
    }
    scene::Scene scene;
    scene.file = name;
    scene.surface = std::move(*surface);
    scene.lower_m = box.lower;
    scene.upper_m = box.upper;
    scene.in_metres = true;
    return scene;
}

bool names_test_sphere(std::string_view name) { return name.starts_with(kSphere); }

} // namespace springdrive::rig
