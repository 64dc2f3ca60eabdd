#include "engine/scene/gltf_primitive.h"

#include "base/input_error.h"
#include "base/wanted.h"
#include "engine/scene/gltf_draco.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace springdrive::scene::gltf {

namespace {

constexpr const char *kDraco = "KHR_draco_mesh_compression";

/// Where a primitive's attributes come from: accessors, or its Draco data where these hold them.
class AttributeSource {
public:
    AttributeSource(const tinygltf::Model &model, const tinygltf::Primitive &primitive)
        : model_(model), primitive_(primitive) {
        const auto draco = primitive.extensions.find(kDraco);
        if (draco == primitive.extensions.end()) {
            return;
        }
        const tinygltf::Value &extension = draco->second;
        if (!extension.IsObject() || !extension.Get("bufferView").IsInt() ||
            !extension.Get("attributes").IsObject()) {
            throw InputError(std::string(kDraco) + " needs bufferView and attributes");
        }
        draco_attributes_ = extension.Get("attributes");
        draco_.emplace(view_bytes(model, extension.Get("bufferView").GetNumberAsInt()));
    }

    [[nodiscard]] const DracoMesh *draco() const { return draco_ ? &*draco_ : nullptr; }

    [[nodiscard]] Attribute read(const std::string &name, Scaling scaling) const {
        const auto found = primitive_.attributes.find(name);
        if (found == primitive_.attributes.end()) {
            return {};
        }
        const int accessor = found->second;
        if (!draco_ || !draco_attributes_.Has(name)) {
            return read_attribute(model_, accessor, scaling);
        }
        const bool normalised = scaling == Scaling::unit_range || is_normalised(model_, accessor);
        const tinygltf::Value &id = draco_attributes_.Get(name);
        if (!id.IsInt()) {
            throw InputError(std::string(kDraco) + ": the id of " + name + " is no integer");
        }
        return draco_->attribute(static_cast<std::uint32_t>(id.GetNumberAsInt()), normalised);
    }

private:
    const tinygltf::Model &model_;
    const tinygltf::Primitive &primitive_;
    tinygltf::Value draco_attributes_;
    std::optional<DracoMesh> draco_;
};

void check_shape(const Attribute &attribute, const std::string &name, int fewest, int most,
                 std::size_t count) {
    if (attribute.empty()) {
        return;
    }
    if (attribute.components < fewest || attribute.components > most) {
        throw InputError(name + " has " + std::to_string(attribute.components) +
                         " numbers a vertex; it takes " + std::to_string(most));
    }
    if (attribute.count() != count) {
        throw InputError(name + " has " + std::to_string(attribute.count()) + " entries for " +
                         std::to_string(count) + " vertices");
    }
}

void check_finite(const Attribute &attribute, const std::string &name) {
    const auto bad = std::ranges::find_if_not(attribute.values,
                                              [](double number) { return std::isfinite(number); });
    if (bad != attribute.values.end()) {
        const auto index = static_cast<std::size_t>(bad - attribute.values.begin());
        throw InputError(name + " of vertex " +
                         std::to_string(index / static_cast<std::size_t>(attribute.components)) +
                         " is not finite");
    }
}

void check_in_range(const std::vector<Triangle> &triangles, std::size_t vertex_count) {
    for (const Triangle &triangle : triangles) {
        for (const std::uint32_t index : triangle) {
            if (index >= vertex_count) {
                throw InputError("index " + std::to_string(index) + " is out of range; there are " +
                                 std::to_string(vertex_count) + " vertices");
            }
        }
    }
}

/// What a primitive of points or lines holds, in words; empty for triangles.
std::string describe_untouchable(int mode, std::size_t corners) {
    switch (mode) {
    case TINYGLTF_MODE_POINTS:
        return std::to_string(corners) + " points";
    case TINYGLTF_MODE_LINE:
        return std::to_string(corners / 2) + " line segments";
    case TINYGLTF_MODE_LINE_LOOP:
        return std::to_string(corners) + " line segments";
    case TINYGLTF_MODE_LINE_STRIP:
        return std::to_string(corners - std::min<std::size_t>(corners, 1)) + " line segments";
    default:
        return {};
    }
}

std::vector<std::uint32_t> read_corners(const tinygltf::Model &model,
                                        const tinygltf::Primitive &primitive,
                                        std::size_t vertex_count) {
    if (primitive.indices >= 0) {
        return read_indices(model, primitive.indices);
    }
    std::vector<std::uint32_t> corners(vertex_count);
    std::iota(corners.begin(), corners.end(), 0U);
    return corners;
}

void read_triangles(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                    const DracoMesh *draco, PrimitiveGeometry &geometry) {
    if (draco != nullptr) {
        geometry.triangles = draco->triangles();
        return;
    }
    const std::vector<std::uint32_t> corners =
        read_corners(model, primitive, geometry.position.count());
    geometry.triangles = assemble_triangles(primitive.mode, corners);
    geometry.leftover_vertices = primitive.mode == TINYGLTF_MODE_TRIANGLES ? corners.size() % 3
                                 : corners.size() < 3                      ? corners.size()
                                                                           : 0;
}

} // namespace

std::vector<Triangle> assemble_triangles(int mode, const std::vector<std::uint32_t> &corners) {
    std::vector<Triangle> triangles;
    if (corners.size() < 3) {
        return triangles;
    }
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        triangles.reserve(corners.size() / 3);
        for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
            triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
        }
        return triangles;
    }
    triangles.reserve(corners.size() - 2);
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
        if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
            triangles.push_back({corners[i + 1], corners[i + 2], corners[0]});
        } else { // a strip: every second triangle is turned over
            triangles.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
        }
    }
    return triangles;
}

PrimitiveGeometry read_primitive(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                                 int texture_set) {
    PrimitiveGeometry geometry;
    if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
        throw InputError("primitive mode " + std::to_string(primitive.mode) +
                         " is unknown; glTF has 0 to 6");
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) {
        throw InputError("a primitive has no POSITION");
    }
    const int corners = primitive.indices >= 0 ? primitive.indices : position->second;
    geometry.untouchable = describe_untouchable(primitive.mode, accessor_count(model, corners));
    if (!geometry.untouchable.empty()) {
        return geometry;
    }

    const AttributeSource source(model, primitive);
    geometry.position = source.read("POSITION", Scaling::as_declared);
    const std::size_t count = geometry.position.count();
    check_shape(geometry.position, "POSITION", 3, 3, count);
    check_finite(geometry.position, "POSITION");
    read_triangles(model, primitive, source.draco(), geometry);
    check_in_range(geometry.triangles, count);

    stop_if_given_up();
    const std::string set = "TEXCOORD_" + std::to_string(texture_set);
    geometry.normal = source.read("NORMAL", Scaling::unit_range);
    geometry.colour = source.read("COLOR_0", Scaling::unit_range);
    geometry.texture_coordinate = source.read(set, Scaling::as_declared);
    check_shape(geometry.normal, "NORMAL", 3, 3, count);
    check_shape(geometry.colour, "COLOR_0", 3, 4, count);
    check_shape(geometry.texture_coordinate, set, 2, 2, count);
    check_finite(geometry.colour, "COLOR_0");
    check_finite(geometry.texture_coordinate, set);
    geometry.has_morph_targets = !primitive.targets.empty();
    return geometry;
}

} // namespace springdrive::scene::gltf
