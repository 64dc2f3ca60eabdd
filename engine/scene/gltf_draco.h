// KHR_draco_mesh_compression, decoded with libdraco: Debian's tinygltf comes without it.
#pragma once

#include "engine/scene/gltf_accessor.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace springdrive::scene::gltf {

/// A Draco-compressed triangle mesh.
class DracoMesh {
public:
    /// @throw InputError when the bytes are no Draco triangle mesh, or are damaged.
    explicit DracoMesh(std::span<const unsigned char> bytes);
    ~DracoMesh();
    DracoMesh(const DracoMesh &) = delete;
    DracoMesh &operator=(const DracoMesh &) = delete;

    [[nodiscard]] std::vector<std::array<std::uint32_t, 3>> triangles() const;

    /// The attribute that Draco knows by `id`.
    /// @param normalised integers stand for [0, 1] or [−1, 1]
    /// @throw InputError when there is none, or it cannot be read as numbers.
    [[nodiscard]] Attribute attribute(std::uint32_t id, bool normalised) const;

private:
    struct Decoded;
    std::unique_ptr<Decoded> decoded_;
};

} // namespace springdrive::scene::gltf
