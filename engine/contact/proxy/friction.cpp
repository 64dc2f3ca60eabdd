#include "engine/contact/proxy/friction.h"

#include <algorithm>
#include <cmath>

namespace springdrive::contact {

FrictionStop stop_by_friction(const ProxyPath &path, std::size_t first, double normal_m,
                              const SurfaceMaterial &material, bool was_sliding) noexcept {
    const Vector3 &end_m = path[path.size() - 1];
    const double sticking = was_sliding ? material.dynamic_friction : material.static_friction;
    const double behind_m = (path[first] - end_m).norm();
    if (behind_m <= sticking * normal_m) {
        return {first, path[first], true};
    }
    // From the end backwards to the piece that crosses the sphere of radius μ N about the end.
    const double left_m = material.dynamic_friction * normal_m;
    std::size_t piece = path.size() - 1;
    while (piece > first && (path[piece] - end_m).squaredNorm() <= left_m * left_m) {
        --piece;
    }
    if (piece == path.size() - 1) {
        return {piece, end_m, false};
    }
    const Vector3 start = path[piece] - end_m;
    const Vector3 way = path[piece + 1] - path[piece];
    const double a = way.squaredNorm();
    const double b = start.dot(way);
    const double c = start.squaredNorm() - left_m * left_m;
    const double share = (-b - std::sqrt(std::max(0.0, b * b - a * c))) / a;
    return {piece, path[piece] + std::clamp(share, 0.0, 1.0) * way, false};
}

} // namespace springdrive::contact
