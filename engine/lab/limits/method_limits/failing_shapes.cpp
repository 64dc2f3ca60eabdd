#include "engine/lab/limits/method_limits/failing_shapes.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace springdrive::limits {

namespace {

constexpr double kHalf_m = 0.05; ///< of shapes without another size

contact::TriangleSoup nothing() {
    contact::TriangleSoup soup;
    soup.materials = {{"rigid"}};
    return soup;
}

void add(contact::TriangleSoup &soup, const std::array<Vector3, 3> &corners_m) {
    const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
    soup.vertices_m.insert(soup.vertices_m.end(), corners_m.begin(), corners_m.end());
    soup.triangles.push_back({first, first + 1, first + 2});
    soup.material_of_triangle.push_back(0);
}

void add_square(contact::TriangleSoup &soup, const std::array<Vector3, 4> &corners_m) {
    add(soup, {corners_m[0], corners_m[1], corners_m[2]});
    add(soup, {corners_m[0], corners_m[2], corners_m[3]});
}

} // namespace

contact::TriangleSoup cracked_sheet(double gap_m) {
    contact::TriangleSoup soup = nothing();
    for (const double side : {-1.0, 1.0}) {
        const double near_m = 0.5 * side * gap_m;
        const double far_m = side * kHalf_m;
        add_square(soup,
                   {Vector3(near_m, 0.0, -side * kHalf_m), Vector3(near_m, 0.0, side * kHalf_m),
                    Vector3(far_m, 0.0, side * kHalf_m), Vector3(far_m, 0.0, -side * kHalf_m)});
    }
    return soup;
}

contact::TriangleSoup pit(int faces, double opening_rad) {
    contact::TriangleSoup soup = nothing();
    const double out = std::sin(0.5 * opening_rad);
    const double up = std::cos(0.5 * opening_rad);
    if (faces == 2) {
        for (const double side : {-1.0, 1.0}) {
            const Vector3 rise = kHalf_m * Vector3(side * out, up, 0.0);
            const Vector3 along = kHalf_m * Vector3(0.0, 0.0, side);
            add_square(soup,
                       {Vector3(-along), along, Vector3(rise + along), Vector3(rise - along)});
        }
        return soup;
    }
    // The middle of each face rises at the opening's half angle; its corners reach farther out.
    const double turn_rad = 2.0 * std::numbers::pi / faces;
    const double reach = out / std::cos(0.5 * turn_rad);
    const auto rim = [&](int i) {
        const double angle = turn_rad * i;
        return Vector3(kHalf_m * Vector3(reach * std::sin(angle), up, reach * std::cos(angle)));
    };
    for (int i = 0; i < faces; ++i) {
        add(soup, {Vector3::Zero(), rim(i), rim(i + 1)});
    }
    return soup;
}

} // namespace springdrive::limits
