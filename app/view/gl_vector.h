// The only conversions between the program's vectors (Eigen, double, metres) and the renderer's
// (GLM, float).
#pragma once

#include "base/vector.h"

#include <glm/vec3.hpp>

namespace springdrive::app {

[[nodiscard]] inline glm::vec3 to_glm(const Vector3 &v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

[[nodiscard]] inline Vector3 to_vector3(const glm::vec3 &v) { return {v.x, v.y, v.z}; }

} // namespace springdrive::app
