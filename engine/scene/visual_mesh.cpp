#include "engine/scene/visual_mesh.h"

#include "base/assertions.h"
#include "base/cancellation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

namespace springdrive::scene {

namespace {

using Point = std::array<float, 3>;

/// An edge as one of its triangles has it, from the smaller point to the larger.
struct EdgeSide {
    std::array<Point, 2> ends;
    std::array<Point, 2> normals;
};

bool takes_lines(const VisualMesh &mesh) {
    return mesh.texture < 0 && mesh.finish.normal_texture < 0 && !mesh.translucent &&
           !mesh.alpha_cutoff;
}

void add_sides(const VisualMesh &mesh, std::vector<EdgeSide> &sides) {
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        stop_if_given_up(i);
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const VisualVertex *from = &mesh.vertices[mesh.indices[i + corner]];
            const VisualVertex *to = &mesh.vertices[mesh.indices[i + (corner + 1) % 3]];
            if (to->position_m < from->position_m) {
                std::swap(from, to);
            }
            if (from->position_m != to->position_m) {
                sides.push_back({{from->position_m, to->position_m}, {from->normal, to->normal}});
            }
        }
    }
}

bool turns(const Point &normal, const Point &other) {
    static const double kMin = std::cos(kCrease_deg * std::numbers::pi / 180.0);
    return std::inner_product(normal.begin(), normal.end(), other.begin(), 0.0) < kMin;
}

/// @param sides of one edge
bool is_crease(std::span<const EdgeSide> sides) {
    return sides.size() == 1 || std::ranges::any_of(sides.subspan(1), [&](const EdgeSide &side) {
               return turns(side.normals[0], sides.front().normals[0]) ||
                      turns(side.normals[1], sides.front().normals[1]);
           });
}

/// Copies triangles of a mesh into one piece after the other.
class Cutter {
public:
    Cutter(const VisualMesh &mesh, std::size_t max_vertices)
        : mesh_(mesh), max_vertices_(max_vertices), index_in_piece_(mesh.vertices.size(), kNone) {
        begin_piece();
    }

    void add(std::span<const std::uint32_t> triangle) {
        const VisualMesh &full = pieces_.back();
        if (full.vertices.size() + 3 > max_vertices_ ||
            full.indices.size() + 3 > 6 * max_vertices_) {
            begin_piece();
        }
        for (const std::uint32_t corner : triangle) {
            pieces_.back().indices.push_back(index_of(corner));
        }
    }

    [[nodiscard]] std::vector<VisualMesh> take() { return std::move(pieces_); }

private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    void begin_piece() {
        for (const std::uint32_t vertex : in_piece_) {
            index_in_piece_[vertex] = kNone;
        }
        in_piece_.clear();
        VisualMesh &piece = pieces_.emplace_back();
        piece.name = mesh_.name;
        piece.texture = mesh_.texture;
        piece.emission = mesh_.emission;
        piece.emissive_texture = mesh_.emissive_texture;
        piece.finish = mesh_.finish;
        piece.double_sided = mesh_.double_sided;
    }

    std::uint32_t index_of(std::uint32_t vertex) {
        if (index_in_piece_[vertex] == kNone) {
            index_in_piece_[vertex] = static_cast<std::uint32_t>(in_piece_.size());
            in_piece_.push_back(vertex);
            pieces_.back().vertices.push_back(mesh_.vertices[vertex]);
            if (!mesh_.tangents.empty()) {
                pieces_.back().tangents.push_back(mesh_.tangents[vertex]);
            }
        }
        return index_in_piece_[vertex];
    }

    const VisualMesh &mesh_;
    std::size_t max_vertices_;
    std::vector<std::uint32_t> index_in_piece_; ///< of each vertex of the mesh, or kNone
    std::vector<std::uint32_t> in_piece_;       ///< the vertices that have one
    std::vector<VisualMesh> pieces_;
};

} // namespace

std::vector<LineSegment> creases_of(std::span<const VisualMesh> meshes) {
    std::vector<EdgeSide> sides;
    for (const VisualMesh &mesh : meshes) {
        if (takes_lines(mesh)) {
            add_sides(mesh, sides);
        }
        if (sides.size() > 3 * kMaxCreasedTriangles) {
            return {};
        }
    }
    std::ranges::sort(sides, {}, &EdgeSide::ends);
    std::vector<LineSegment> creases;
    for (auto begin = sides.begin(); begin != sides.end();) {
        const auto end = std::find_if(
            begin, sides.end(), [&](const EdgeSide &side) { return side.ends != begin->ends; });
        if (is_crease({begin, end})) {
            creases.push_back(begin->ends);
        }
        if (creases.size() > kMaxCreases) {
            return {};
        }
        begin = end;
    }
    return creases;
}

std::vector<VisualMesh> in_pieces(VisualMesh mesh, std::size_t max_vertices) {
    std::vector<VisualMesh> pieces;
    if (mesh.vertices.size() <= max_vertices && mesh.indices.size() <= 6 * max_vertices) {
        pieces.push_back(std::move(mesh));
        return pieces;
    }
    Cutter cutter(mesh, max_vertices);
    for (std::size_t i = 0; i + 3 <= mesh.indices.size(); i += 3) {
        stop_if_given_up(i);
        cutter.add(std::span(mesh.indices).subspan(i, 3));
    }
    return cutter.take();
}

namespace {

/// The pixels of a row or column, from `first` up to `end`, that one pixel of the result covers.
struct Covered {
    std::size_t first;
    std::size_t end;
};

Covered covered_by(std::size_t pixel, std::size_t from_count, std::size_t to_count) {
    return {pixel * from_count / to_count, ((pixel + 1) * from_count + to_count - 1) / to_count};
}

} // namespace

Texture scaled_down(const Texture &texture, int max_side) {
    SPRINGDRIVE_ASSERT(max_side > 0);
    if (texture.width <= max_side && texture.height <= max_side) {
        return texture;
    }
    Texture result;
    result.width = std::min(texture.width, max_side);
    result.height = std::min(texture.height, max_side);
    result.wrap_s = texture.wrap_s;
    result.wrap_t = texture.wrap_t;
    result.holds_numbers = texture.holds_numbers;
    result.has_alpha = texture.has_alpha;
    const auto from_width = static_cast<std::size_t>(texture.width);
    const auto from_height = static_cast<std::size_t>(texture.height);
    const auto width = static_cast<std::size_t>(result.width);
    const auto height = static_cast<std::size_t>(result.height);
    result.rgba.reserve(4 * width * height);
    for (std::size_t y = 0; y < height; ++y) {
        const Covered rows = covered_by(y, from_height, height);
        for (std::size_t x = 0; x < width; ++x) {
            const Covered columns = covered_by(x, from_width, width);
            const std::size_t count =
                std::max<std::size_t>(1, (rows.end - rows.first) * (columns.end - columns.first));
            for (std::size_t channel = 0; channel < 4; ++channel) {
                std::size_t sum = count / 2; // rounds to the nearest
                for (std::size_t row = rows.first; row < rows.end; ++row) {
                    for (std::size_t column = columns.first; column < columns.end; ++column) {
                        sum += texture.rgba[4 * (row * from_width + column) + channel];
                    }
                }
                result.rgba.push_back(static_cast<std::uint8_t>(sum / count));
            }
        }
    }
    return result;
}

} // namespace springdrive::scene
