// Reading glTF accessors with every bound checked: the only code that touches buffer bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

/// More vertices, or indices, than this in one scene is taken for a damaged file.
inline constexpr std::size_t kMostVertices = 60'000'000;

/// One vertex attribute: `components` numbers a vertex; none at all when the file has none.
struct Attribute {
    int components = 0;
    std::vector<double> values;

    [[nodiscard]] bool empty() const { return components == 0; }
    [[nodiscard]] std::size_t count() const {
        return empty() ? 0 : values.size() / static_cast<std::size_t>(components);
    }
    [[nodiscard]] std::span<const double> operator[](std::size_t vertex) const {
        const auto width = static_cast<std::size_t>(components);
        return std::span(values).subspan(vertex * width, width);
    }
};

/// How integers become numbers.
enum class Scaling : std::uint8_t {
    as_declared, ///< as the accessor's `normalized` says
    unit_range,  ///< always to [0, 1] or [−1, 1]: colours and normals
};

/// The bytes of a buffer view.
/// @throw InputError for a view that is not there or does not lie within its buffer.
[[nodiscard]] std::span<const unsigned char> view_bytes(const tinygltf::Model &model, int view);

/// Reads floats, or 8- and 16-bit integers (KHR_mesh_quantization), sparse ones too.
/// @throw InputError naming the accessor, for one that is not there, is no vector of that kind, or
///        reaches outside its buffer view.
[[nodiscard]] Attribute read_attribute(const tinygltf::Model &model, int accessor, Scaling scaling);

/// Reads 8-, 16- or 32-bit unsigned scalars.
/// @throw InputError as above.
[[nodiscard]] std::vector<std::uint32_t> read_indices(const tinygltf::Model &model, int accessor);

/// How many elements an accessor has, without reading them.
[[nodiscard]] std::size_t accessor_count(const tinygltf::Model &model, int accessor);

/// Whether an accessor's integers stand for [0, 1] or [−1, 1].
[[nodiscard]] bool is_normalised(const tinygltf::Model &model, int accessor);

} // namespace springdrive::scene::gltf
