#include "engine/scene/gltf_nodes.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/one_line.h"
#include "engine/scene/gltf_extras.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

namespace springdrive::scene::gltf {

namespace {

constexpr std::array<std::string_view, 2> kSides = {"one", "two"}; // TouchSides after automatic

void read_friction(const Extras &extras, contact::SurfaceMaterial &material) {
    constexpr double kMaximum = 10.0; // rubber reaches about 2; much more is a typing error
    const std::string range = "a number from 0 to 10";
    const auto at_rest = extras.number("static_friction", 0.0, kMaximum, range);
    const auto sliding = extras.number("dynamic_friction", 0.0, kMaximum, range);
    if (!at_rest && !sliding) {
        return;
    }
    material.static_friction = at_rest ? *at_rest : *sliding;
    material.dynamic_friction = sliding ? *sliding : *at_rest;
    if (material.dynamic_friction > material.static_friction) {
        extras.refuse("dynamic_friction",
                      "a number from 0 to 10, not above its static_friction: what slides would "
                      "otherwise stick again at once");
    }
}

void read_sides(const Extras &extras, contact::SurfaceMaterial &material) {
    if (const auto sides = extras.word("sides", kSides, "'one' or 'two'")) {
        material.sides = *sides == 0 ? contact::TouchSides::one : contact::TouchSides::two;
    }
}

/// A plate has no inside; a solid is touched from outside only.
void check_sides(const TouchExtras &touch, const std::string &label) {
    const bool is_plate = touch.shape == ShapeKind::plate;
    const contact::TouchSides impossible =
        is_plate ? contact::TouchSides::one : contact::TouchSides::two;
    if (touch.shape && touch.material.sides == impossible) {
        throw InputError(label + ": a " + name_of(*touch.shape) + " is touched from " +
                         (is_plate ? "both sides; set extras.sides to 'two'"
                                   : "outside only; set extras.sides to 'one'") +
                         ", or leave it out");
    }
}

std::size_t checked_index(int index, std::size_t size, const std::string &what) {
    if (index < 0 || static_cast<std::size_t>(index) >= size) {
        throw InputError(what + " " + std::to_string(index) + " is not in the file, which has " +
                         std::to_string(size));
    }
    return static_cast<std::size_t>(index);
}

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
        return model.scenes[checked_index(scene, model.scenes.size(), "scene")].nodes;
    }
    std::vector<bool> has_parent(model.nodes.size(), false);
    for (const tinygltf::Node &node : model.nodes) {
        for (const int child : node.children) {
            has_parent[checked_index(child, model.nodes.size(), "child node")] = true;
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

TouchExtras read_touch(const std::string &text, const TouchExtras &parent, const std::string &label,
                       WarningList &warnings) {
    const Extras extras(text, label, warnings);
    TouchExtras touch = parent;
    touch.shape.reset();
    constexpr std::size_t kMaxCaption = 40;
    touch.caption = extras.text("caption", kMaxCaption).value_or("");
    if (const auto eta =
            extras.number("eta", 0.0, 1.0, "a number from 0 (rigid) to 1 (free space)")) {
        touch.material.eta = *eta;
    }
    read_friction(extras, touch.material);
    read_sides(extras, touch.material);
    if (const auto smooth = extras.flag("smooth")) {
        touch.smooth = *smooth;
    }
    if (const auto shape = extras.word("shape", kShapeNames,
                                       "'plate', 'sphere', 'box', 'cylinder' or 'capsule'")) {
        touch.shape = static_cast<ShapeKind>(*shape);
    }
    check_sides(touch, label);
    return touch;
}

std::vector<PlacedMesh> place_meshes(const tinygltf::Model &model, WarningList &warnings) {
    std::vector<PlacedMesh> placed;
    std::vector<bool> seen(model.nodes.size(), false);
    std::vector<Visit> stack; // instead of recursion: a chain of nodes may be any length
    push_all(stack, root_nodes(model), Eigen::Affine3d::Identity(), {});
    while (!stack.empty()) {
        stop_if_given_up();
        const Visit visit = stack.back();
        stack.pop_back();
        const std::size_t index = checked_index(visit.node, model.nodes.size(), "node");
        const tinygltf::Node &node = model.nodes[index];
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
            checked_index(node.mesh, model.meshes.size(), label + ": mesh");
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
