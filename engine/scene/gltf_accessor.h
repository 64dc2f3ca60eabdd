// Vertex attributes and indices of a glTF, from its accessors or its compressed data, with every
// bound checked: the only code that reads the bytes of buffers.
#pragma once

#include "base/input_error.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace draco {
class Mesh;
}
namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

/// A scene with more vertices, or indices, than this is taken to be damaged.
inline constexpr std::size_t kMaxVertices = 60'000'000;

using Triangle = std::array<std::uint32_t, 3>; ///< indices of vertices

/// One vertex attribute, `components` numbers a vertex; empty where the file has none.
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

/// The item of one of the file's arrays.
/// @param what it is, for the message: "material"
/// @throw InputError for an index that is not in the file
template <typename Item>
[[nodiscard]] const Item &checked(const std::vector<Item> &items, int index,
                                  const std::string &what) {
    if (index < 0 || static_cast<std::size_t>(index) >= items.size()) {
        throw InputError(what + " " + std::to_string(index) + " is not in the file, which has " +
                         std::to_string(items.size()));
    }
    return items[static_cast<std::size_t>(index)];
}

/// The bytes of a buffer view.
/// @throw InputError for a view that does not exist or does not lie within its buffer.
[[nodiscard]] std::span<const unsigned char> view_bytes(const tinygltf::Model &model, int view);

/// A part of a buffer.
/// @param place of what refers to it, for messages
/// @throw InputError for a buffer that does not exist, has no data or is too short.
[[nodiscard]] std::span<const unsigned char> bytes_within(const tinygltf::Model &model, int buffer,
                                                          std::size_t offset, std::size_t length,
                                                          const std::string &place);

/// Reads floats, or 8- and 16-bit integers (KHR_mesh_quantization), sparse ones too.
/// @throw InputError naming the accessor, for one that does not exist, is no vector of that kind,
///        or reaches outside its buffer view.
[[nodiscard]] Attribute read_attribute(const tinygltf::Model &model, int accessor, Scaling scaling);

/// The first `count` matrices of an accessor of 4 by 4 floats, column by column.
/// @throw InputError as above, and for an accessor of fewer.
[[nodiscard]] std::vector<double> read_matrices(const tinygltf::Model &model, int accessor,
                                                std::size_t count);

/// @param name  in the message: "NORMAL"
/// @throw InputError for an attribute, not an empty one, with fewer or more numbers a vertex, or
///        of another number of vertices than `count`.
void check_shape(const Attribute &attribute, const std::string &name, int minimum, int maximum,
                 std::size_t count);

/// @throw InputError with the vertex for a number that is not finite.
void check_finite(const Attribute &attribute, const std::string &name);

/// Reads 8-, 16- or 32-bit unsigned scalars, sparse ones too; without a buffer view the others are
/// zero.
/// @throw InputError as above.
[[nodiscard]] std::vector<std::uint32_t> read_indices(const tinygltf::Model &model, int accessor);

/// How many elements an accessor has, without reading them.
[[nodiscard]] std::size_t accessor_count(const tinygltf::Model &model, int accessor);

/// Whether an accessor's integers stand for [0, 1] or [−1, 1].
[[nodiscard]] bool is_normalised(const tinygltf::Model &model, int accessor);

inline constexpr const char *kDracoExtension = "KHR_draco_mesh_compression";

/// A triangle mesh compressed in that way, decoded with libdraco: Debian's tinygltf is built
/// without it.
class DracoMesh {
public:
    /// @throw InputError when the bytes are no Draco triangle mesh, or are damaged.
    explicit DracoMesh(std::span<const unsigned char> bytes);
    ~DracoMesh();
    DracoMesh(const DracoMesh &) = delete;
    DracoMesh &operator=(const DracoMesh &) = delete;

    [[nodiscard]] std::vector<Triangle> triangles() const;

    /// The attribute with Draco's unique id `id`.
    /// @param normalised integers stand for [0, 1] or [−1, 1]
    /// @throw InputError when there is none, or it cannot be read as numbers.
    [[nodiscard]] Attribute attribute(std::uint32_t id, bool normalised) const;

private:
    std::unique_ptr<draco::Mesh> mesh_;
};

/// The second may also hold what Debian's meshoptimizer cannot decode: attributes in version 1 of
/// their code, and the filter COLOR.
inline constexpr std::array<const char *, 2> kMeshoptExtensions = {"EXT_meshopt_compression",
                                                                   "KHR_meshopt_compression"};

/// Decodes every buffer view compressed in one of those ways into a buffer of its own, to which the
/// view then refers. One that cannot be decoded stays if its own buffer has the same, uncompressed.
/// @throw InputError naming the buffer view, for what is damaged, cannot be decoded, does not lie
///        within its buffer, or is too large.
void decode_meshopt_views(tinygltf::Model &model);

} // namespace springdrive::scene::gltf
