// Surfaces that several tests share.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"

#include <array>
#include <cstdint>
#include <ostream>

namespace springdrive::contact {

/// For GoogleTest, which would otherwise print its bytes.
inline void PrintTo(const TriangleSoup &soup, std::ostream *out) {
    *out << soup.triangles.size() << " triangles";
}

} // namespace springdrive::contact

namespace springdrive::testing {

/// A closed box, wound outward, with one material.
inline contact::TriangleSoup box_soup(const Vector3 &lower_m, const Vector3 &upper_m,
                                      double eta = 0.0) {
    contact::TriangleSoup soup;
    for (int corner = 0; corner < 8; ++corner) {
        soup.vertices_m.emplace_back((corner & 1) != 0 ? upper_m.x() : lower_m.x(),
                                     (corner & 2) != 0 ? upper_m.y() : lower_m.y(),
                                     (corner & 4) != 0 ? upper_m.z() : lower_m.z());
    }
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    for (const auto &f : kFaces) {
        soup.triangles.push_back({f[0], f[1], f[2]});
        soup.triangles.push_back({f[0], f[2], f[3]});
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"box", eta}};
    return soup;
}

} // namespace springdrive::testing
