#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/text.h"
#include "engine/scene/gltf_mesh.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace springdrive::scene::gltf {

namespace {

/// Adds a share of what a morph target changes of an attribute, three numbers a vertex.
void add_target(const tinygltf::Model &model, const std::map<std::string, int> &target,
                const char *name, Scaling scaling, double weight, Attribute &attribute) {
    const auto found = target.find(name);
    if (found == target.end() || attribute.empty()) {
        return;
    }
    const Attribute change = read_attribute(model, found->second, scaling);
    const std::string what = std::string("a morph target's ") + name;
    check_shape(change, what, 3, 3, attribute.count());
    check_finite(change, what);
    for (std::size_t vertex = 0; vertex < change.count(); ++vertex) {
        stop_if_given_up(vertex);
        for (std::size_t c = 0; c < 3; ++c) {
            attribute.values[vertex * static_cast<std::size_t>(attribute.components) + c] +=
                weight * change[vertex][c];
        }
    }
}

void add_targets(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                 std::span<const double> weights, PrimitiveGeometry &geometry) {
    for (std::size_t i = 0; i < std::min(weights.size(), primitive.targets.size()); ++i) {
        if (weights[i] != 0.0) {
            const std::map<std::string, int> &target = primitive.targets[i];
            add_target(model, target, "POSITION", Scaling::as_declared, weights[i],
                       geometry.position);
            add_target(model, target, "NORMAL", Scaling::unit_range, weights[i], geometry.normal);
            add_target(model, target, "TANGENT", Scaling::unit_range, weights[i], geometry.tangent);
        }
    }
}

/// How the joints of a skin move the vertices of a primitive.
class Skinning {
public:
    Skinning(const std::vector<JointSet> &sets, const JointTransforms &joints)
        : sets_(sets), joints_(joints) {}

    /// Takes a vertex from the mesh to the world.
    Eigen::Affine3d at(std::size_t vertex) {
        Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
        double weights = 0.0;
        for (std::size_t n = 0; n < sets_.size(); ++n) {
            for (std::size_t i = 0; i < 4; ++i) {
                const double weight = sets_[n].weights[vertex][i];
                if (weight < 0.0) {
                    throw InputError(at_vertex("WEIGHTS_", n, vertex) + shortest_text(weight) +
                                     "; a weight is not negative");
                }
                if (weight > 0.0) { // the joints of others are of no meaning
                    sum += weight * joint(n, vertex, i).matrix();
                    weights += weight;
                }
            }
        }
        Eigen::Affine3d transform = Eigen::Affine3d::Identity();
        if (weights > 0.0) {
            transform.matrix() = sum / weights;
        } else {
            ++weightless_;
            transform = joint(0, vertex, 0);
        }
        return transform;
    }

    /// How many vertices had no joint with a weight, and followed the first.
    [[nodiscard]] std::size_t weightless() const { return weightless_; }

private:
    [[nodiscard]] static std::string at_vertex(const char *name, std::size_t set,
                                               std::size_t vertex) {
        return name + std::to_string(set) + " of vertex " + std::to_string(vertex) + " is ";
    }

    [[nodiscard]] const Eigen::Affine3d &joint(std::size_t set, std::size_t vertex,
                                               std::size_t i) const {
        const double index = sets_[set].joints[vertex][i];
        if (!(index >= 0.0 && index < static_cast<double>(joints_.size()))) {
            throw InputError(at_vertex("JOINTS_", set, vertex) + shortest_text(index) +
                             "; the skin has " + std::to_string(joints_.size()) + " joints");
        }
        return joints_[static_cast<std::size_t>(index)];
    }

    const std::vector<JointSet> &sets_;
    const JointTransforms &joints_;
    std::size_t weightless_ = 0;
};

/// Whether a blend of joints turns what it moves inside out, and not only flattens it.
bool mirrors(const Matrix3 &M) {
    constexpr double kRounding = 1e-14;
    return M.determinant() < -kRounding * std::pow(M.norm(), 3);
}

/// Takes a vector of an attribute along, of which a fourth number is a tangent's sign.
void transform(const Matrix3 &M, bool flips_sign, std::size_t vertex, Attribute &attribute) {
    if (!attribute.empty()) {
        const std::size_t at = vertex * static_cast<std::size_t>(attribute.components);
        Eigen::Map<Vector3> vector(&attribute.values[at]);
        vector = M * Vector3(vector);
        if (flips_sign) {
            attribute.values[at + 3] *= -1.0;
        }
    }
}

void move_by_skin(const PlacedMesh &node, PrimitiveGeometry &geometry, WarningList &warnings) {
    const std::vector<JointSet> sets = std::exchange(geometry.joint_sets, {});
    Skinning skinning(sets, *node.joints);
    std::vector<bool> mirrored(geometry.position.count());
    for (std::size_t i = 0; i < mirrored.size(); ++i) {
        stop_if_given_up(i);
        const Eigen::Affine3d to_world = sets.empty() ? node.without_skin : skinning.at(i);
        const Matrix3 M = to_world.linear();
        mirrored[i] = mirrors(M);
        Eigen::Map<Vector3> position(&geometry.position.values[3 * i]);
        position = to_world * Vector3(position);
        transform(normal_matrix(M, mirrored[i]), false, i, geometry.normal);
        transform(M, mirrored[i], i, geometry.tangent);
    }
    for (Triangle &triangle : geometry.triangles) { // outwards again, as of nodes that mirror
        if (mirrored[triangle[0]] + mirrored[triangle[1]] + mirrored[triangle[2]] >= 2) {
            std::swap(triangle[1], triangle[2]);
        }
    }
    if (sets.empty()) {
        warnings.add_of(node.label, &node,
                        "a primitive has no JOINTS_0: its skin does not move it");
    }
    if (skinning.weightless() > 0) {
        warnings.add_of(node.label, &node, skinning.weightless(),
                        "vertices have no weight of a joint; they follow their first");
    }
}

} // namespace

std::shared_ptr<const PrimitiveGeometry>
at_rest(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
        const std::shared_ptr<const PrimitiveGeometry> &geometry, const PlacedMesh &node,
        WarningList &warnings) {
    const std::size_t weights = node.morph_weights.size();
    if (weights != 0 && weights != primitive.targets.size()) {
        warnings.add_of(node.label, &node,
                        "has " + std::to_string(weights) + " weights for " +
                            std::to_string(primitive.targets.size()) +
                            " morph targets; those without are left out");
    }
    const bool is_morphed =
        !primitive.targets.empty() &&
        std::ranges::any_of(node.morph_weights, [](double weight) { return weight != 0.0; });
    if (!is_morphed && !node.joints) {
        return geometry;
    }
    auto rest = std::make_shared<PrimitiveGeometry>(*geometry);
    add_targets(model, primitive, node.morph_weights, *rest);
    if (node.joints) {
        move_by_skin(node, *rest, warnings);
    }
    check_finite(rest->position, "POSITION at rest");
    check_finite(rest->tangent, "TANGENT at rest");
    return rest;
}

} // namespace springdrive::scene::gltf
