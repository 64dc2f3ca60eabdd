#include "engine/lab/model_selection/contact_shapes.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/input_error.h"
#include "engine/scene/scene.h"
#include "engine/scene/shape_fit.h"

#include <meshoptimizer.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::model_selection {

namespace {

using Point = std::array<float, 3>;

/// Vertices in single precision, merged where they coincide: a mesh whose faces have their own
/// vertices, for sharp normals, would otherwise come apart.
struct WeldedVertices {
    std::vector<Point> places;
    std::vector<Vector3> exact_m; ///< of each place, in double precision
    std::vector<unsigned> place_of_vertex;

    explicit WeldedVertices(const contact::TriangleSoup &soup) {
        std::map<Point, unsigned> known;
        for (const Vector3 &vertex_m : soup.vertices_m) {
            stop_if_given_up(place_of_vertex.size());
            const Point point = {static_cast<float>(vertex_m.x()), static_cast<float>(vertex_m.y()),
                                 static_cast<float>(vertex_m.z())};
            const auto [entry, is_new] =
                known.try_emplace(point, static_cast<unsigned>(places.size()));
            if (is_new) {
                places.push_back(point);
                exact_m.push_back(vertex_m);
            }
            place_of_vertex.push_back(entry->second);
        }
    }
};

std::vector<unsigned> fewer(const std::vector<unsigned> &indices, const WeldedVertices &vertices,
                            int divisor) {
    // Relative to the extent: unlimited, as the error is measured by touch.
    constexpr float kAnyError = 1.0F;
    const std::size_t target = indices.size() / 3 / static_cast<std::size_t>(divisor) * 3;
    std::vector<unsigned> left(indices.size());
    left.resize(meshopt_simplify(left.data(), indices.data(), indices.size(),
                                 vertices.places.front().data(), vertices.places.size(),
                                 sizeof(Point), target, kAnyError, 0, nullptr));
    return left;
}

/// Meshes are not simplified below this: a tetrahedron has four.
constexpr std::size_t kMinTriangles = 4;
/// A simplification that leaves more than this share of the previous one is not a useful candidate.
constexpr double kWorthwhile = 0.75;

/// For each material the primitive that its triangles represent.
std::vector<std::optional<scene::RecognisedShape>> primitives_of(const scene::Scene &scene) {
    std::vector<std::optional<scene::RecognisedShape>> fits;
    for (std::size_t i = 0; i < scene.surface.materials.size(); ++i) {
        fits.push_back(scene::recognise_shape(scene.surface, static_cast<std::uint16_t>(i)));
    }
    return fits;
}

bool has_any(const std::vector<std::optional<scene::RecognisedShape>> &fits) {
    for (const auto &fit : fits) {
        if (fit) {
            return true;
        }
    }
    return false;
}

contact::HapticSurface with_primitives(const scene::Scene &scene) {
    const std::vector<std::optional<scene::RecognisedShape>> fits = primitives_of(scene);
    std::vector<contact::AnalyticShape> shapes = scene.shapes;
    std::vector<bool> is_replaced(fits.size(), false);
    for (std::size_t i = 0; i < fits.size(); ++i) {
        if (fits[i] && shapes.size() < contact::kMaxShapes) {
            shapes.push_back(fits[i]->shape);
            is_replaced[i] = true;
        }
    }
    contact::TriangleSoup rest;
    rest.vertices_m = scene.surface.vertices_m;
    rest.materials = scene.surface.materials;
    for (std::size_t i = 0; i < scene.surface.triangles.size(); ++i) {
        const std::uint16_t material = scene.surface.material_of_triangle[i];
        if (!is_replaced[material]) {
            rest.triangles.push_back(scene.surface.triangles[i]);
            rest.material_of_triangle.push_back(material);
        }
    }
    return contact::HapticSurface(std::move(rest), std::move(shapes));
}

/// The mesh to simplify: the original triangles of smooth nodes, rather than the many of their
/// curved form.
const contact::TriangleSoup &to_simplify(const scene::Scene &scene) {
    return scene.flat_surface.triangles.empty() ? scene.surface : scene.flat_surface;
}

[[noreturn]] void refuse(const scene::Scene &scene, const std::string &shape,
                         const std::string &why) {
    throw InputError(scene.file.string() + ": cannot be touched as '" + shape + "': " + why +
                     "; springdrive inspect lists what it can be touched as");
}

} // namespace

contact::TriangleSoup simplified(const contact::TriangleSoup &soup, int divisor) {
    SPRINGDRIVE_ASSERT(divisor >= 1);
    const WeldedVertices vertices(soup);
    std::vector<std::vector<unsigned>> corners_of_material(soup.materials.size());
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        for (const std::uint32_t corner : soup.triangles[i]) {
            corners_of_material[soup.material_of_triangle[i]].push_back(
                vertices.place_of_vertex[corner]);
        }
    }
    contact::TriangleSoup result;
    result.vertices_m = vertices.exact_m;
    result.materials = soup.materials;
    for (std::size_t material = 0; material < corners_of_material.size(); ++material) {
        if (corners_of_material[material].empty()) {
            continue;
        }
        const std::vector<unsigned> left = fewer(corners_of_material[material], vertices, divisor);
        for (std::size_t i = 0; i < left.size(); i += 3) {
            result.triangles.push_back({left[i], left[i + 1], left[i + 2]});
            result.material_of_triangle.push_back(static_cast<std::uint16_t>(material));
        }
    }
    return result;
}

std::vector<ContactShape> contact_shapes_of(const scene::Scene &scene) {
    using Kind = ContactShape::Kind;
    std::vector<ContactShape> simplified_ones;
    const contact::TriangleSoup &source = to_simplify(scene);
    std::size_t last = source.triangles.size();
    for (int divisor = 2; last / 2 >= kMinTriangles; divisor *= 2) {
        const std::size_t left = simplified(source, divisor).triangles.size();
        if (left < kMinTriangles ||
            static_cast<double>(left) > kWorthwhile * static_cast<double>(last)) {
            break;
        }
        simplified_ones.push_back({Kind::simplified, divisor});
        last = left;
    }
    std::vector<ContactShape> shapes;
    if (has_any(primitives_of(scene))) {
        shapes.push_back({Kind::primitives, 1});
    }
    shapes.insert(shapes.end(), simplified_ones.rbegin(), simplified_ones.rend());
    if (!scene.flat_surface.triangles.empty()) {
        shapes.push_back({Kind::flat, 1});
    }
    shapes.push_back({Kind::given, 1});
    return shapes;
}

contact::HapticSurface haptic_surface_of(const scene::Scene &scene, const ContactShape &shape) {
    switch (shape.kind) {
    case ContactShape::Kind::primitives:
        if (!has_any(primitives_of(scene))) {
            refuse(scene, name_of(shape),
                   "none of its nodes is a plate, sphere, box, cylinder or "
                   "capsule");
        }
        return with_primitives(scene);
    case ContactShape::Kind::simplified:
        return contact::HapticSurface(simplified(to_simplify(scene), shape.divisor), scene.shapes);
    case ContactShape::Kind::flat:
        if (scene.flat_surface.triangles.empty()) {
            refuse(scene, name_of(shape), "none of its nodes is smooth");
        }
        return contact::HapticSurface(scene.flat_surface, scene.shapes);
    case ContactShape::Kind::given:
        break;
    }
    return scene::haptic_surface_of(scene);
}

} // namespace springdrive::model_selection
