#include "assets/scenes/shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace springdrive::scenes {

namespace {

using Corner = std::array<int, 3>;

/// Adds the square face of cell (i, j, k) that faces along ±`axis`.
void add_face(Part &part, const std::array<const std::vector<double> *, 3> &coordinates,
              const Corner &cell, int axis, bool upper) {
    const int u = (axis + 1) % 3; // axis, u, v are right-handed
    const int v = (axis + 2) % 3;
    const auto first = static_cast<std::uint32_t>(part.positions_m.size());
    Vector3 normal = Vector3::Zero();
    normal[axis] = upper ? 1.0 : -1.0;
    constexpr std::array<std::array<int, 2>, 4> kAround = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    for (const auto &[step_u, step_v] : kAround) {
        Corner corner = cell;
        const auto a = static_cast<std::size_t>(axis);
        corner[a] += upper ? 1 : 0;
        corner[static_cast<std::size_t>(u)] += step_u;
        corner[static_cast<std::size_t>(v)] += step_v;
        Vector3 position;
        for (int c = 0; c < 3; ++c) {
            const auto d = static_cast<std::size_t>(c);
            position[c] = (*coordinates[d])[static_cast<std::size_t>(corner[d])];
        }
        part.positions_m.push_back(position);
        part.normals.push_back(normal);
    }
    const std::uint32_t second = upper ? 1 : 3;
    const std::uint32_t last = upper ? 3 : 1;
    part.triangles.push_back({first, first + second, first + 2});
    part.triangles.push_back({first, first + 2, first + last});
}

/// The icosahedron's twelve corners: three mutually perpendicular golden rectangles.
std::vector<Vector3> icosahedron_corners() {
    const double golden = 0.5 * (1.0 + std::sqrt(5.0));
    std::vector<Vector3> corners;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double a : {-1.0, 1.0}) {
            for (const double b : {-golden, golden}) {
                Vector3 corner = Vector3::Zero();
                corner[(axis + 1) % 3] = a;
                corner[(axis + 2) % 3] = b;
                corners.push_back(corner);
            }
        }
    }
    return corners;
}

/// Its twenty faces: triples of corners that are an edge (length 2) apart, wound outwards.
std::vector<std::array<std::uint32_t, 3>> icosahedron_faces(const std::vector<Vector3> &corners) {
    const auto are_joined = [&](std::uint32_t a, std::uint32_t b) {
        return (corners[a] - corners[b]).squaredNorm() < 5.0; // an edge has 4, the next 10.5
    };
    std::vector<std::array<std::uint32_t, 3>> faces;
    for (std::uint32_t a = 0; a < 12; ++a) {
        for (std::uint32_t b = a + 1; b < 12; ++b) {
            for (std::uint32_t c = b + 1; c < 12; ++c) {
                if (!are_joined(a, b) || !are_joined(b, c) || !are_joined(a, c)) {
                    continue;
                }
                const double volume = corners[a].dot(corners[b].cross(corners[c]));
                faces.push_back(volume > 0.0 ? std::array{a, b, c} : std::array{a, c, b});
            }
        }
    }
    return faces;
}

/// Between three linear colours: deep water, sand, coral.
std::array<std::uint8_t, 4> coral_colour(double share) {
    constexpr std::array<std::array<double, 3>, 3> kStops = {
        {{0.02, 0.16, 0.22}, {0.75, 0.62, 0.42}, {0.85, 0.20, 0.12}}};
    const double place = 2.0 * std::clamp(share, 0.0, 1.0);
    const std::size_t stop = place < 1.0 ? 0 : 1;
    const double blend = place - static_cast<double>(stop);
    std::array<std::uint8_t, 4> colour{0, 0, 0, 255};
    for (std::size_t c = 0; c < 3; ++c) {
        const double value = kStops[stop][c] + blend * (kStops[stop + 1][c] - kStops[stop][c]);
        colour[c] = static_cast<std::uint8_t>(std::lround(255.0 * value));
    }
    return colour;
}

} // namespace

Part cell_solid(const CellGrid &grid, const std::function<bool(int, int, int)> &is_solid) {
    const std::array<const std::vector<double> *, 3> coordinates = {&grid.x_m, &grid.y_m,
                                                                    &grid.z_m};
    const Corner size = {static_cast<int>(grid.x_m.size()) - 1,
                         static_cast<int>(grid.y_m.size()) - 1,
                         static_cast<int>(grid.z_m.size()) - 1};
    const auto holds = [&](const Corner &cell) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (cell[axis] < 0 || cell[axis] >= size[axis]) {
                return false;
            }
        }
        return is_solid(cell[0], cell[1], cell[2]);
    };
    Part part;
    for (int i = 0; i < size[0]; ++i) {
        for (int j = 0; j < size[1]; ++j) {
            for (int k = 0; k < size[2]; ++k) {
                const Corner cell = {i, j, k};
                for (int side = 0; holds(cell) && side < 6; ++side) {
                    Corner neighbour = cell;
                    neighbour[static_cast<std::size_t>(side / 2)] += side % 2 == 0 ? -1 : 1;
                    if (!holds(neighbour)) {
                        add_face(part, coordinates, cell, side / 2, side % 2 != 0);
                    }
                }
            }
        }
    }
    return part;
}

Part box(const Vector3 &lower_m, const Vector3 &upper_m) {
    return cell_solid(
        {{lower_m.x(), upper_m.x()}, {lower_m.y(), upper_m.y()}, {lower_m.z(), upper_m.z()}},
        [](int, int, int) { return true; });
}

Part sheared(Part part, double rise_x, double rise_z) {
    for (Vector3 &position : part.positions_m) {
        position.y() += rise_x * position.x() + rise_z * position.z();
    }
    for (Vector3 &normal : part.normals) { // by the inverse transpose
        normal.x() -= rise_x * normal.y();
        normal.z() -= rise_z * normal.y();
        normal /= normal.norm();
    }
    return part;
}

Part faceted(const Part &part) {
    Part facets;
    for (const auto &[a, b, c] : part.triangles) {
        const std::array<Vector3, 3> corners = {part.positions_m[a], part.positions_m[b],
                                                part.positions_m[c]};
        const Vector3 across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        const auto first = static_cast<std::uint32_t>(facets.positions_m.size());
        for (const Vector3 &corner : corners) {
            facets.positions_m.push_back(corner);
            facets.normals.emplace_back(across / across.norm());
        }
        facets.triangles.push_back({first, first + 1, first + 2});
    }
    return facets;
}

Part geodesic_sphere(int frequency) {
    const std::vector<Vector3> corners = icosahedron_corners();
    Part part;
    // A vertex on an edge or corner belongs to several faces. Its weights on the icosahedron's
    // corners identify equal vertices without comparing coordinates.
    std::map<std::map<std::uint32_t, int>, std::uint32_t> known;
    const auto vertex = [&](const std::array<std::uint32_t, 3> &face, int a, int b) {
        const std::array<int, 3> weights = {frequency - a - b, a, b};
        std::map<std::uint32_t, int> key; // sorted, so all faces add up in the same order
        for (std::size_t c = 0; c < 3; ++c) {
            if (weights[c] > 0) {
                key[face[c]] = weights[c];
            }
        }
        const auto next = static_cast<std::uint32_t>(part.positions_m.size());
        const auto [entry, is_new] = known.try_emplace(key, next);
        if (is_new) {
            Vector3 point = Vector3::Zero();
            for (const auto &[corner, weight] : key) {
                point += static_cast<double>(weight) * corners[corner];
            }
            part.positions_m.emplace_back(point / point.norm());
        }
        return entry->second;
    };
    for (const auto &face : icosahedron_faces(corners)) {
        for (int a = 0; a < frequency; ++a) {
            for (int b = 0; a + b < frequency; ++b) {
                part.triangles.push_back(
                    {vertex(face, a, b), vertex(face, a + 1, b), vertex(face, a, b + 1)});
                if (a + b + 1 < frequency) {
                    part.triangles.push_back({vertex(face, a + 1, b), vertex(face, a + 1, b + 1),
                                              vertex(face, a, b + 1)});
                }
            }
        }
    }
    part.normals = part.positions_m;
    return part;
}

Part blob_union(const rig::BlobShape &shape, int frequency) {
    Part part = geodesic_sphere(frequency);
    double nearest = std::numeric_limits<double>::infinity();
    double farthest = 0.0;
    for (std::size_t i = 0; i < part.positions_m.size(); ++i) {
        Vector3 &position = part.positions_m[i];
        const double distance = shape.distance(position);
        position *= distance;
        part.normals[i] = shape.outward_normal(position);
        nearest = std::min(nearest, distance);
        farthest = std::max(farthest, distance);
    }
    for (const Vector3 &position : part.positions_m) {
        part.colours.push_back(coral_colour((position.norm() - nearest) / (farthest - nearest)));
    }
    return part;
}

} // namespace springdrive::scenes
