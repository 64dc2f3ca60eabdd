#include "assets/scenes/shapes.h"

#include <Eigen/Geometry>

namespace springdrive::scenes {

namespace {

/// Adds a flat face; its corners run counter-clockwise as seen from outside.
void add_quad(Part &part, const std::array<Vector3, 4> &corners_m) {
    const auto first = static_cast<std::uint32_t>(part.positions_m.size());
    const Vector3 across = (corners_m[2] - corners_m[0]).cross(corners_m[3] - corners_m[1]);
    for (const Vector3 &corner_m : corners_m) {
        part.positions_m.push_back(corner_m);
        part.normals.emplace_back(across / across.norm());
    }
    part.triangles.push_back({first, first + 1, first + 2});
    part.triangles.push_back({first, first + 2, first + 3});
}

} // namespace

Part extrusion(const std::vector<ProfilePoint> &profile, double floor_y_m, double half_width_m) {
    Part part;
    const double w = half_width_m;
    const auto high = [&](double x_m, const ProfilePoint &point) {
        return Vector3(x_m, point.y_m, point.z_m);
    };
    const auto low = [&](double x_m, const ProfilePoint &point) {
        return Vector3(x_m, floor_y_m, point.z_m);
    };
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        const ProfilePoint &a = profile[i];
        const ProfilePoint &b = profile[i + 1];
        add_quad(part, {high(-w, a), high(-w, b), high(w, b), high(w, a)}); // top
        add_quad(part, {low(-w, a), low(w, a), low(w, b), low(-w, b)});     // floor
        add_quad(part, {low(-w, a), low(-w, b), high(-w, b), high(-w, a)}); // left
        add_quad(part, {low(w, a), high(w, a), high(w, b), low(w, b)});     // right
    }
    const ProfilePoint &back = profile.front();
    const ProfilePoint &front = profile.back();
    add_quad(part, {low(-w, back), high(-w, back), high(w, back), low(w, back)});
    add_quad(part, {low(-w, front), low(w, front), high(w, front), high(-w, front)});
    return part;
}

} // namespace springdrive::scenes
