#include "engine/scene/visual_pieces.h"

#include "base/cancellation.h"

#include <limits>
#include <span>
#include <utility>

namespace springdrive::scene {

namespace {

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

} // namespace springdrive::scene
