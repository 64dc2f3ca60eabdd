// Keeps the loading of a scene within a stated amount of memory.
#pragma once

#include <cstddef>

namespace springdrive::scene::gltf {

/// Loading takes no more than this at its peak, textures aside.
inline constexpr double kMaxMemory_bytes = 8.0 * 1024 * 1024 * 1024;

/// What a triangle and a vertex cost at the peak: all copies that stand at the same time, in file,
/// scene and search structure. Above what was measured with 9 to 19 million triangles, whether they
/// share their vertices or not, by what colours and texture coordinates would add.
inline constexpr double kPerTriangle_bytes = 300.0;
inline constexpr double kPerVertex_bytes = 220.0;

/// Counts what a scene is made of, before the memory for it is taken.
class LoadAllowance {
public:
    /// @throw InputError with both amounts, when it becomes more than is allowed.
    void add(std::size_t triangles, std::size_t vertices);

private:
    std::size_t triangles_ = 0;
    std::size_t vertices_ = 0;
};

} // namespace springdrive::scene::gltf
