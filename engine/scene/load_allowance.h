// Keeps the loading of a scene within a stated amount of memory.
#pragma once

#include <cstddef>

namespace springdrive::scene::gltf {

/// The maximum memory for loading at its peak, without textures.
inline constexpr double kMaxMemory_bytes = 8.0 * 1024 * 1024 * 1024;

/// Memory for a triangle and for a vertex at the peak: all copies that exist at the same time, in
/// file, scene and search structure. Measured with 9 to 19 million triangles, with shared and with
/// separate vertices, plus the additional memory of colours and texture coordinates.
inline constexpr double kPerTriangle_bytes = 300.0;
inline constexpr double kPerVertex_bytes = 220.0;

/// Counts the triangles and vertices of a scene before memory for them is allocated.
class WorkBudget {
public:
    /// @throw InputError with both amounts if the sum exceeds the maximum.
    void add(std::size_t triangles, std::size_t vertices);

private:
    std::size_t triangles_ = 0;
    std::size_t vertices_ = 0;
};

} // namespace springdrive::scene::gltf
