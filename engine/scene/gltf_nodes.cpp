#include "engine/scene/gltf_nodes.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/text.h"
#include "engine/scene/gltf_accessor.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

namespace springdrive::scene::gltf {

namespace {

std::string label_of(const tinygltf::Model &model, std::size_t node) {
    const std::string &name = model.nodes[node].name;
    return "node " + (name.empty() ? std::to_string(node) : in_quotes(name));
}

std::string name_of(const tinygltf::Model &model, std::size_t index) {
    const tinygltf::Node &node = model.nodes[index];
    if (!node.name.empty()) {
        return one_line(node.name);
    }
    const std::string &mesh_name = model.meshes[static_cast<std::size_t>(node.mesh)].name;
    return mesh_name.empty() ? label_of(model, index) : one_line(mesh_name);
}

/// The nodes of the scene to load that have no parent.
std::vector<int> root_nodes(const tinygltf::Model &model) {
    if (model.defaultScene >= 0 || !model.scenes.empty()) {
        const int scene = std::max(model.defaultScene, 0);
        return checked(model.scenes, scene, "scene").nodes;
    }
    std::vector<bool> has_parent(model.nodes.size(), false);
    for (const tinygltf::Node &node : model.nodes) {
        for (const int child : node.children) {
            static_cast<void>(checked(model.nodes, child, "child node"));
            has_parent[static_cast<std::size_t>(child)] = true;
        }
    }
    std::vector<int> roots;
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        if (!has_parent[i]) {
            roots.push_back(static_cast<int>(i));
        }
    }
    return roots;
}

void check_length(const std::vector<double> &numbers, std::size_t length, const char *what,
                  const std::string &label) {
    if (!numbers.empty() && numbers.size() != length) {
        throw InputError(label + ": its " + what + " has " + std::to_string(numbers.size()) +
                         " numbers; it takes " + std::to_string(length));
    }
}

Eigen::Affine3d from_matrix(const std::vector<double> &numbers, const std::string &label) {
    Eigen::Affine3d transform;
    transform.matrix() = Eigen::Map<const Eigen::Matrix4d>(numbers.data()); // column by column
    const Eigen::RowVector4d last = transform.matrix().row(3);
    constexpr double kRounding = 1e-6; // of files written in single precision
    if ((last - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).cwiseAbs().maxCoeff() > kRounding) {
        throw InputError(label + ": its matrix is no affine map; its last row must be 0 0 0 1");
    }
    transform.makeAffine();
    return transform;
}

/// A quaternion that is off unit length by rounding is a rotation, written in few digits. One that
/// is further off is ambiguous, since some programs would also scale with it, and is refused.
Eigen::Quaterniond unit_quaternion(const std::vector<double> &numbers, const std::string &label) {
    constexpr double kRounding = 1e-3; // three digits, or normalised 16-bit integers
    const Eigen::Quaterniond rotation(numbers.data()); // x y z w, as glTF has it
    if (!(std::abs(rotation.norm() - 1.0) <= kRounding)) {
        throw InputError(label + ": its rotation is a quaternion of length " +
                         shortest_text(rotation.norm()) + "; it must have length 1");
    }
    return rotation.normalized();
}

Eigen::Affine3d local_transform(const tinygltf::Node &node, const std::string &label) {
    check_length(node.matrix, 16, "matrix", label);
    check_length(node.translation, 3, "translation", label);
    check_length(node.rotation, 4, "rotation", label);
    check_length(node.scale, 3, "scale", label);
    if (!node.matrix.empty()) {
        return from_matrix(node.matrix, label);
    }
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (!node.translation.empty()) {
        transform.translate(Eigen::Vector3d(node.translation.data()));
    }
    if (!node.rotation.empty()) {
        transform.rotate(unit_quaternion(node.rotation, label));
    }
    if (!node.scale.empty()) {
        transform.scale(Eigen::Vector3d(node.scale.data()));
    }
    return transform;
}

struct Visit {
    int node;
    Eigen::Affine3d parent_to_world;
    TouchExtras parent_touch;
};

void push_all(std::vector<Visit> &stack, const std::vector<int> &nodes,
              const Eigen::Affine3d &to_world, const TouchExtras &touch) {
    std::for_each(nodes.rbegin(), nodes.rend(), [&](int node) {
        stack.push_back({node, to_world, touch});
    });
}

} // namespace

std::vector<PlacedMesh> place_meshes(const tinygltf::Model &model, WarningList &warnings) {
    std::vector<PlacedMesh> placed;
    std::vector<bool> seen(model.nodes.size(), false);
    std::vector<Visit> stack; // instead of recursion: a chain of nodes may be any length
    push_all(stack, root_nodes(model), Eigen::Affine3d::Identity(), {});
    while (!stack.empty()) {
        stop_if_given_up();
        const Visit visit = stack.back();
        stack.pop_back();
        const tinygltf::Node &node = checked(model.nodes, visit.node, "node");
        const auto index = static_cast<std::size_t>(visit.node);
        const std::string label = label_of(model, index);
        if (seen[index]) {
            throw InputError(label + " is reached twice; glTF nodes must form a tree, without "
                                     "cycles or second parents");
        }
        seen[index] = true;
        const Eigen::Affine3d to_world = visit.parent_to_world * local_transform(node, label);
        if (!to_world.matrix().allFinite()) {
            throw InputError(label + ": its transform is not finite");
        }
        const TouchExtras touch =
            read_touch(node.extras_json_string, visit.parent_touch, label, warnings);
        if (node.mesh >= 0) {
            static_cast<void>(checked(model.meshes, node.mesh, label + ": mesh"));
            placed.push_back(
                {name_of(model, index), label, node.mesh, to_world, touch, node.skin >= 0});
            placed.back().touch.material.name = placed.back().name;
        } else if (touch.shape) {
            warnings.add_of(label, nullptr,
                            "extras.shape is left out: it needs a mesh on the same node, to be "
                            "fitted to");
        }
        push_all(stack, node.children, to_world, touch);
    }
    return placed;
}

} // namespace springdrive::scene::gltf
