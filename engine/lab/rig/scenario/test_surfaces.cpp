#include "engine/lab/rig/scenario/test_surfaces.h"

#include "base/input_error.h"
#include "base/text.h"
#include "engine/lab/rig/scenario/blob_shape.h"
#include "engine/lab/rig/scenario/machined_surface.h"
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
                         scene::LoadProgress *progress) {
    std::optional<contact::TriangleSoup> surface = test_surface_named(name);
    if (!surface) {
        return scene::load_gltf(name, workspace, progress);
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
