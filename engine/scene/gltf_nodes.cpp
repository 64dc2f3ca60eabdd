#include "engine/scene/gltf_nodes.h"

#include "base/input_error.h"
#include "engine/scene/gltf_text.h"

#include <tiny_gltf.h>

#include <algorithm>

namespace springdrive::gltf {

namespace {

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

/// A scene as we take it: the nodes to start from.
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
        const Eigen::Quaterniond rotation(node.rotation.data()); // x y z w, as glTF has it
        if (!(rotation.norm() > 0.0)) {
            throw InputError(label + ": its rotation is no quaternion; it must have length 1");
        }
        transform.rotate(rotation.normalized());
    }
    if (!node.scale.empty()) {
        transform.scale(Eigen::Vector3d(node.scale.data()));
    }
    return transform;
}

std::string shown(const tinygltf::Value &value) {
    if (value.IsString()) {
        return in_quotes(value.Get<std::string>());
    }
    if (value.IsNumber()) {
        return shortest(value.GetNumberAsDouble());
    }
    return "no number";
}

double eta_of(const tinygltf::Node &node, double inherited, const std::string &label) {
    if (!node.extras.IsObject() || !node.extras.Has("eta")) {
        return inherited;
    }
    const tinygltf::Value &value = node.extras.Get("eta");
    const double eta = value.IsNumber() ? value.GetNumberAsDouble() : -1.0;
    if (!(eta >= 0.0 && eta <= 1.0)) {
        throw InputError(label + ": extras.eta is " + shown(value) +
                         "; it must be a number from 0 (rigid) to 1 (free space)");
    }
    return eta;
}

struct Visit {
    int node;
    Eigen::Affine3d parent_to_world;
    double eta;
};

void push_all(std::vector<Visit> &stack, const std::vector<int> &nodes,
              const Eigen::Affine3d &to_world, double eta) {
    std::for_each(nodes.rbegin(), nodes.rend(), [&](int node) {
        stack.push_back({node, to_world, eta});
    });
}

} // namespace

std::vector<PlacedMesh> place_meshes(const tinygltf::Model &model) {
    std::vector<PlacedMesh> placed;
    std::vector<bool> seen(model.nodes.size(), false);
    std::vector<Visit> stack; // instead of recursion: a chain of nodes may be any length
    push_all(stack, root_nodes(model), Eigen::Affine3d::Identity(), 0.0);
    while (!stack.empty()) {
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
        const double eta = eta_of(node, visit.eta, label);
        if (node.mesh >= 0) {
            checked_index(node.mesh, model.meshes.size(), label + ": mesh");
            placed.push_back(
                {name_of(model, index), label, node.mesh, to_world, eta, node.skin >= 0});
        }
        push_all(stack, node.children, to_world, eta);
    }
    return placed;
}

bool is_in_metres(const tinygltf::Model &model) {
    bool in_metres = false;
    const auto check = [&](const tinygltf::Value &extras, const std::string &owner) {
        if (!extras.IsObject() || !extras.Has("units")) {
            return;
        }
        const tinygltf::Value &units = extras.Get("units");
        if (!units.IsString() || units.Get<std::string>() != "m") {
            throw InputError(owner + ".extras.units is " +
                             (units.IsString() ? in_quotes(units.Get<std::string>()) : "no text") +
                             "; it must be 'm' (metres), or left out to fit the scene");
        }
        in_metres = true;
    };
    check(model.asset.extras, "asset");
    const auto scene = static_cast<std::size_t>(std::max(model.defaultScene, 0));
    if (scene < model.scenes.size()) {
        check(model.scenes[scene].extras, "scene");
    }
    return in_metres;
}

} // namespace springdrive::gltf
