#include "engine/scene/load_allowance.h"

#include "base/input_error.h"
#include "base/one_line.h"

#include <cmath>
#include <string>

namespace springdrive::scene::gltf {

namespace {

std::string in_GiB(double bytes) {
    return shortest_text(std::round(bytes / (1024.0 * 1024.0 * 1024.0) * 10.0) / 10.0) + " GiB";
}

} // namespace

void WorkBudget::add(std::size_t triangles, std::size_t vertices) {
    triangles_ += triangles;
    vertices_ += vertices;
    const double needed_bytes = kPerTriangle_bytes * static_cast<double>(triangles_) +
                                kPerVertex_bytes * static_cast<double>(vertices_);
    if (needed_bytes > kMaxMemory_bytes) {
        throw InputError("with it the scene has " + std::to_string(triangles_) + " triangles and " +
                         std::to_string(vertices_) + " vertices, for which loading needs about " +
                         in_GiB(needed_bytes) + " of memory; at most " + in_GiB(kMaxMemory_bytes) +
                         " are allowed: simplify it");
    }
}

} // namespace springdrive::scene::gltf
