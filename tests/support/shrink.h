// Cuts a mesh on which something fails down to the triangles that it takes.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <string>

namespace springdrive::testing {

/// The soup without triangles `first` to `last`, the end excluded.
[[nodiscard]] inline contact::TriangleSoup without(contact::TriangleSoup soup, std::size_t first,
                                                   std::size_t last) {
    const auto erase = [&](auto &list) {
        list.erase(list.begin() + static_cast<std::ptrdiff_t>(first),
                   list.begin() + static_cast<std::ptrdiff_t>(last));
    };
    erase(soup.triangles);
    erase(soup.material_of_triangle);
    return soup;
}

/// Leaves out triangles, first many at once, then fewer, as long as `fails(soup)` remains true: of
/// the result, no single triangle can be left out. Vertices stay.
template <typename Fails>
[[nodiscard]] contact::TriangleSoup shrunk(contact::TriangleSoup soup, const Fails &fails) {
    for (std::size_t at_once = soup.triangles.size() / 2; at_once > 0;) {
        bool has_shrunk = false;
        for (std::size_t first = 0; first < soup.triangles.size();) {
            const std::size_t last = std::min(first + at_once, soup.triangles.size());
            contact::TriangleSoup smaller = without(soup, first, last);
            if (!smaller.triangles.empty() && fails(smaller)) {
                soup = std::move(smaller);
                has_shrunk = true;
            } else {
                first = last;
            }
        }
        at_once = has_shrunk && at_once == 1 ? 1 : at_once / 2;
    }
    return soup;
}

/// Wavefront OBJ, to look at.
inline void write_obj(const std::string &path, const contact::TriangleSoup &soup) {
    std::ofstream out(path);
    out.precision(17);
    for (const Vector3 &vertex_m : soup.vertices_m) {
        out << "v " << vertex_m.transpose() << '\n';
    }
    for (const auto &[a, b, c] : soup.triangles) {
        out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
    }
}

} // namespace springdrive::testing
