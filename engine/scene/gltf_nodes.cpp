#include "engine/scene/gltf_nodes.h"

#include "base/cancellation.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "base/text.h"
#include "base/vector.h"
#include "engine/scene/gltf_accessor.h"

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>
#include <utility>

namespace springdrive::scene::gltf {

namespace {

/// The extras of a glTF object, read key by key from the JSON text itself: tinygltf's own values
/// lose `null` and whatever does not fit into an int. Keys that are not read belong to other
/// programs.
class Extras {
public:
    /// @param text JSON of the extras; empty when there are none
    /// @param owner for messages: "node 'pad'"
    /// @param warnings gains the values that are left out as another program's
    Extras(const std::string &text, std::string owner, WarningList &warnings);

    [[nodiscard]] bool has(const char *key) const;

    /// The number under `key`, if there is one.
    /// @param meaning what it may be, for the message: "a number from 0 to 10"
    /// Left out unless it is a number from `minimum` to `maximum`.
    [[nodiscard]] std::optional<double> number(const char *key, double minimum, double maximum,
                                               const std::string &meaning) const;

    /// Left out unless the value is true or false.
    [[nodiscard]] std::optional<bool> flag(const char *key) const;

    /// Which of `words` the value of `key` is, if there is one. Left out unless it is one of them.
    [[nodiscard]] std::optional<std::size_t> word(const char *key,
                                                  std::span<const std::string_view> words,
                                                  const std::string &meaning) const;

    /// The text under `key`, if there is one, on one line. Left out unless it is a text of at most
    /// `max_length` bytes that shows something.
    [[nodiscard]] std::optional<std::string> text(const char *key, std::size_t max_length) const;

    /// The three numbers under `key`, if there are any. Left out unless it is a list of three, each
    /// at most `max_size` in size.
    [[nodiscard]] std::optional<Vector3> vector(const char *key, double max_size) const;

    /// The extras within the extras, if there are any. Messages name their keys as `key.inner`.
    /// Left out unless it is an object, empty or with any of `keys`; then it is our own, and values
    /// in it that cannot be are refused rather than left out.
    [[nodiscard]] std::optional<Extras> object(const char *key,
                                               std::span<const std::string_view> keys,
                                               const std::string &meaning) const;

    /// @throw InputError for a key that is none of `keys`: in an object of our own, it is a typing
    ///        error.
    void refuse_all_but(std::span<const std::string_view> keys) const;

    /// @throw InputError always: "<owner>: extras.<key> is <value>; it must be <meaning>".
    [[noreturn]] void refuse(const char *key, const std::string &meaning) const;

private:
    /// A warning, or in an object of our own a refusal.
    void leave_out(const char *key, const std::string &meaning) const;

    nlohmann::json values_;
    std::string owner_;
    WarningList *warnings_;
    bool is_ours_ = false;
    std::string path_ = "extras."; ///< before keys, in messages
};

std::string shown(const nlohmann::json &value) {
    constexpr std::size_t kMax = 40;
    return value.is_string() ? in_quotes(value.get<std::string>()) : one_line(value.dump(), kMax);
}

Extras::Extras(const std::string &text, std::string owner, WarningList &warnings)
    : values_(text.empty() ? nlohmann::json::object() : nlohmann::json::parse(text)),
      owner_(std::move(owner)), warnings_(&warnings) {}

bool Extras::has(const char *key) const { return values_.is_object() && values_.contains(key); }

std::optional<double> Extras::number(const char *key, double minimum, double maximum,
                                     const std::string &meaning) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const auto number = values_[key].is_number() ? values_[key].get<double>() : minimum - 1.0;
    if (!(number >= minimum && number <= maximum)) {
        leave_out(key, meaning);
        return std::nullopt;
    }
    return number;
}

std::optional<bool> Extras::flag(const char *key) const {
    if (!has(key)) {
        return std::nullopt;
    }
    if (!values_[key].is_boolean()) {
        leave_out(key, "true or false");
        return std::nullopt;
    }
    return values_[key].get<bool>();
}

std::optional<std::size_t> Extras::word(const char *key, std::span<const std::string_view> words,
                                        const std::string &meaning) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const auto found = values_[key].is_string()
                           ? std::ranges::find(words, values_[key].get_ref<const std::string &>())
                           : words.end();
    if (found == words.end()) {
        leave_out(key, meaning);
        return std::nullopt;
    }
    return static_cast<std::size_t>(found - words.begin());
}

std::optional<std::string> Extras::text(const char *key, std::size_t max_length) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const std::string text = values_[key].is_string()
                                 ? one_line(values_[key].get_ref<const std::string &>())
                                 : std::string();
    if (text.empty() || text.size() > max_length) {
        leave_out(key, "a text of 1 to " + std::to_string(max_length) + " bytes");
        return std::nullopt;
    }
    return text;
}

std::optional<Vector3> Extras::vector(const char *key, double max_size) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const nlohmann::json &list = values_[key];
    const auto fits = [max_size](const nlohmann::json &number) {
        return number.is_number() && std::abs(number.get<double>()) <= max_size;
    };
    if (!list.is_array() || list.size() != 3 || !std::ranges::all_of(list, fits)) {
        leave_out(key, "a list of three numbers from " + shortest_text(-max_size) + " to " +
                           shortest_text(max_size));
        return std::nullopt;
    }
    return Vector3(list[0].get<double>(), list[1].get<double>(), list[2].get<double>());
}

std::optional<Extras> Extras::object(const char *key, std::span<const std::string_view> keys,
                                     const std::string &meaning) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const nlohmann::json &value = values_[key];
    const bool is_ours = value.is_object() &&
                         (value.empty() || std::ranges::any_of(keys, [&](std::string_view name) {
                              return value.contains(name);
                          }));
    if (!is_ours) {
        leave_out(key, meaning);
        return std::nullopt;
    }
    Extras inner("", owner_, *warnings_);
    inner.values_ = value;
    inner.path_ = path_ + key + ".";
    inner.is_ours_ = true;
    return inner;
}

void Extras::refuse_all_but(std::span<const std::string_view> keys) const {
    for (const auto &[key, value] : values_.items()) {
        if (std::ranges::find(keys, key) == keys.end()) {
            std::string known;
            for (const std::string_view name : keys) {
                known += (known.empty() ? "" : ", ") + std::string(name);
            }
            throw InputError(owner_ + ": " + path_ + one_line(key, 40) +
                             " is not known; what may stand there is " + known);
        }
    }
}

void Extras::refuse(const char *key, const std::string &meaning) const {
    throw InputError(owner_ + ": " + path_ + key + " is " + shown(values_[key]) + "; it must be " +
                     meaning);
}

void Extras::leave_out(const char *key, const std::string &meaning) const {
    if (is_ours_) {
        refuse(key, meaning);
    }
    const std::string text = path_ + key + " is " + shown(values_[key]) +
                             ": left out as another program's; it would have to be " + meaning;
    if (owner_.find(' ') == std::string::npos) {
        warnings_->add(owner_ + ": " + text);
    } else {
        warnings_->add_of(owner_, nullptr, text);
    }
}

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

constexpr std::array<std::string_view, 3> kToleranceKeys = {"force_N", "direction_deg",
                                                            "bandwidth_hz"};

void read_tolerance(const Extras &extras, ModelTolerance &tolerance) {
    tolerance.force_N = extras.number("force_N", 1e-4, 10.0, "a number from 0.0001 to 10")
                            .value_or(tolerance.force_N);
    if (const auto direction_deg =
            extras.number("direction_deg", 0.01, 180.0, "a number from 0.01 to 180")) {
        tolerance.direction_rad = *direction_deg * kRadiansPerDegree;
    }
    tolerance.bandwidth_hz = extras.number("bandwidth_hz", 1.0, 5000.0, "a number from 1 to 5000")
                                 .value_or(tolerance.bandwidth_hz);
    extras.refuse_all_but(kToleranceKeys);
}

constexpr std::array<std::string_view, 4> kLessonKeys = {"title", "feel", "point", "normal"};

void read_spot(const Extras &extras, std::optional<TouchSpot> &spot) {
    constexpr double kFarthest = 1e6; // in the file's units, which may be micrometres
    const auto point = extras.vector("point", kFarthest);
    const auto normal = extras.vector("normal", kFarthest);
    if (point.has_value() != normal.has_value()) {
        extras.refuse(point ? "point" : "normal",
                      point ? "given with its normal" : "given with its point");
    }
    if (normal && normal->isZero(0.0)) {
        extras.refuse("normal", "a direction, not zero");
    }
    if (point) {
        spot = TouchSpot{*point, normal->stableNormalized()};
    }
}

void read_lesson(const Extras &extras, Lesson &lesson) {
    constexpr std::size_t kMaxTitle = 40;
    constexpr std::size_t kMaxSentence = 200;
    lesson.title = extras.text("title", kMaxTitle).value_or(lesson.title);
    lesson.feel = extras.text("feel", kMaxSentence).value_or(lesson.feel);
    read_spot(extras, lesson.spot);
    extras.refuse_all_but(kLessonKeys);
}

void read_scene(const std::string &text, const std::string &owner, SceneExtras &scene,
                WarningList &warnings) {
    constexpr std::array<std::string_view, 1> kUnits = {"m"};
    const Extras extras(text, owner, warnings);
    scene.in_metres |= extras.word("units", kUnits, "'m' (metres)").has_value();
    scene.planar = extras.flag("planar").value_or(scene.planar);
    if (const auto tolerance = extras.object(
            "tolerance", kToleranceKeys, "an object of force_N, direction_deg and bandwidth_hz")) {
        read_tolerance(*tolerance, scene.tolerance);
    }
    if (const auto lesson =
            extras.object("lesson", kLessonKeys, "an object of title, feel, point and normal")) {
        read_lesson(*lesson, scene.lesson);
    }
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

namespace {

/// The number of a scene, and its name if it has one.
std::string name_of_scene(const tinygltf::Model &model, std::size_t scene) {
    const std::string &name = model.scenes[scene].name;
    return std::to_string(scene) + (name.empty() ? "" : " " + in_quotes(name));
}

std::string names_of_scenes(const tinygltf::Model &model) {
    constexpr std::size_t kMax = 10;
    std::string names;
    for (std::size_t i = 0; i < std::min(model.scenes.size(), kMax); ++i) {
        names += (i == 0 ? "" : ", ") + name_of_scene(model, i);
    }
    return names + (model.scenes.size() > kMax
                        ? " and " + std::to_string(model.scenes.size() - kMax) + " more"
                        : "");
}

bool has_triangles(const tinygltf::Model &model, const tinygltf::Mesh &mesh) {
    return std::ranges::any_of(mesh.primitives, [&](const tinygltf::Primitive &primitive) {
        const auto position = primitive.attributes.find("POSITION");
        if (primitive.mode < TINYGLTF_MODE_TRIANGLES || position == primitive.attributes.end()) {
            return false;
        }
        const int corners = primitive.indices >= 0 ? primitive.indices : position->second;
        return accessor_count(model, corners) >= 3;
    });
}

std::size_t first_scene_with_triangles(const tinygltf::Model &model) {
    std::vector<bool> seen(model.nodes.size(), false); // in this or an earlier scene: without any
    for (std::size_t i = 0; i < model.scenes.size(); ++i) {
        std::vector<int> nodes = model.scenes[i].nodes;
        while (!nodes.empty()) {
            stop_if_given_up();
            const tinygltf::Node &node = checked(model.nodes, nodes.back(), "node");
            const auto index = static_cast<std::size_t>(nodes.back());
            nodes.pop_back();
            if (seen[index]) {
                continue;
            }
            seen[index] = true;
            const auto mesh = static_cast<std::size_t>(node.mesh);
            // A mesh that is not there is named with its node, as the scene is read.
            if (node.mesh >= 0 &&
                (mesh >= model.meshes.size() || has_triangles(model, model.meshes[mesh]))) {
                return i;
            }
            nodes.insert(nodes.end(), node.children.begin(), node.children.end());
        }
    }
    return 0;
}

} // namespace

int choose_scene(const tinygltf::Model &model, const std::string &name, WarningList &warnings) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < model.scenes.size(); ++i) {
        if (!name.empty() && model.scenes[i].name == name) {
            found.push_back(i);
        }
    }
    for (std::size_t i = 0; i < model.scenes.size() && found.empty(); ++i) {
        if (std::to_string(i) == name) {
            found.push_back(i);
        }
    }
    if (!name.empty() && found.size() != 1) {
        throw InputError("has " + (found.empty() ? "no" : std::to_string(found.size())) +
                         " scene " + in_quotes(name) +
                         (model.scenes.empty()
                              ? ", and no other: leave --gltf-scene out"
                              : "; name one of " + names_of_scenes(model) + ", or its number"));
    }
    if (model.scenes.empty() && model.defaultScene < 0) {
        return -1;
    }
    const int scene = !name.empty() ? static_cast<int>(found.front())
                      : model.defaultScene >= 0
                          ? model.defaultScene
                          : static_cast<int>(first_scene_with_triangles(model));
    static_cast<void>(checked(model.scenes, scene, "scene"));
    if (model.scenes.size() > 1) {
        warnings.add("scene " + name_of_scene(model, static_cast<std::size_t>(scene)) +
                     " is loaded, of " + names_of_scenes(model) +
                     "; --gltf-scene NAME loads another");
    }
    return scene;
}

SceneExtras read_scene_extras(const tinygltf::Model &model, WarningList &warnings) {
    SceneExtras extras;
    read_scene(model.asset.extras_json_string, "asset", extras, warnings);
    const auto scene = static_cast<std::size_t>(std::max(model.defaultScene, 0));
    if (scene < model.scenes.size()) {
        read_scene(model.scenes[scene].extras_json_string, "scene", extras, warnings);
    }
    return extras;
}

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

/// In place of a parent.
constexpr int kNoParent = -1;
constexpr int kSeveralParents = -2;

std::vector<int> parents_of(const tinygltf::Model &model) {
    std::vector<int> parents(model.nodes.size(), kNoParent);
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        for (const int child : model.nodes[i].children) {
            static_cast<void>(checked(model.nodes, child, "child node"));
            int &parent = parents[static_cast<std::size_t>(child)];
            parent = parent == kNoParent ? static_cast<int>(i) : kSeveralParents;
        }
    }
    return parents;
}

/// The nodes of the scene to load that have no parent.
std::vector<int> root_nodes(const tinygltf::Model &model) {
    if (model.defaultScene >= 0 || !model.scenes.empty()) {
        const int scene = std::max(model.defaultScene, 0);
        return checked(model.scenes, scene, "scene").nodes;
    }
    const std::vector<int> parents = parents_of(model);
    std::vector<int> roots;
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        if (parents[i] == kNoParent) {
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
Eigen::Quaterniond unit_quaternion(std::span<const double, 4> numbers, const std::string &label,
                                   double rounding = 1e-3) { // of three digits, or 16-bit integers
    const Eigen::Quaterniond rotation(numbers.data());       // x y z w, as glTF has it
    if (!(std::abs(rotation.norm() - 1.0) <= rounding)) {
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
        transform.rotate(unit_quaternion(std::span(node.rotation).first<4>(), label));
    }
    if (!node.scale.empty()) {
        transform.scale(Eigen::Vector3d(node.scale.data()));
    }
    return transform;
}

constexpr const char *kInstancingExtension = "EXT_mesh_gpu_instancing";

/// Where the instances of a node's mesh stand beside the node; itself, if it has none.
class Instances {
public:
    Instances(const tinygltf::Model &model, const tinygltf::Node &node, std::string label)
        : label_(std::move(label)) {
        const auto extension = node.extensions.find(kInstancingExtension);
        if (extension == node.extensions.end()) {
            return;
        }
        if (!extension->second.IsObject() || !extension->second.Get("attributes").IsObject()) {
            throw InputError(label_ + ": " + kInstancingExtension + " needs attributes");
        }
        const tinygltf::Value &attributes = extension->second.Get("attributes");
        const std::array<const char *, 3> names{"TRANSLATION", "ROTATION", "SCALE"};
        std::optional<std::size_t> count;
        for (std::size_t i = 0; i < names.size(); ++i) {
            if (attributes.Has(names[i])) {
                read(model, attributes.Get(names[i]), names[i], i == 1, count, values_[i]);
            }
        }
        count_ = count.value_or(1);
    }

    [[nodiscard]] std::size_t count() const { return count_; }

    [[nodiscard]] Eigen::Affine3d operator[](std::size_t i) const {
        constexpr double kRounding = 1e-2; // of normalised 8-bit integers
        const auto &[translation, rotation, scale] = values_;
        Eigen::Affine3d transform = Eigen::Affine3d::Identity();
        if (!translation.empty()) {
            transform.translate(Vector3(translation[i].data()));
        }
        if (!rotation.empty()) {
            transform.rotate(unit_quaternion(
                rotation[i].first<4>(), label_ + ": instance " + std::to_string(i), kRounding));
        }
        if (!scale.empty()) {
            transform.scale(Vector3(scale[i].data()));
        }
        return transform;
    }

private:
    void read(const tinygltf::Model &model, const tinygltf::Value &accessor, const char *name,
              bool is_rotation, std::optional<std::size_t> &count, Attribute &values) {
        const std::string what = std::string(kInstancingExtension) + ": its " + name;
        try {
            if (!accessor.IsInt()) {
                throw InputError("it must be the number of an accessor");
            }
            const int index = accessor.GetNumberAsInt();
            const std::size_t instances = accessor_count(model, index);
            if (instances > kMaxInstances || instances != count.value_or(instances)) {
                throw InputError("it has " + std::to_string(instances) + " instances; at most " +
                                 std::to_string(kMaxInstances) +
                                 " are allowed, in each attribute as many");
            }
            count = instances;
            values = read_attribute(model, index,
                                    is_rotation ? Scaling::unit_range : Scaling::as_declared);
            const int width = is_rotation ? 4 : 3;
            check_shape(values, name, width, width, instances);
        } catch (const InputError &error) {
            throw InputError(label_ + ": " + what + ": " + error.what());
        }
    }

    std::string label_;
    std::array<Attribute, 3> values_; ///< translation, rotation, scale
    std::size_t count_ = 1;
};

[[noreturn]] void refuse_graph(const std::string &label) {
    throw InputError(label + " is reached twice; glTF nodes must form a tree, without cycles or "
                             "second parents");
}

/// The skins of a scene at rest, each read once.
class SkinCache {
public:
    /// @param to_world of the nodes of the scene
    SkinCache(const tinygltf::Model &model, std::vector<std::optional<Eigen::Affine3d>> to_world)
        : model_(model), to_world_(std::move(to_world)), skins_(model.skins.size()) {}

    /// @throw InputError for a skin that does not exist, joints that are no nodes of a tree, and
    ///        inverse bind matrices that cannot be read.
    const std::shared_ptr<const JointTransforms> &find_or_read(int index) {
        const tinygltf::Skin &skin = checked(model_.skins, index, "skin");
        std::shared_ptr<const JointTransforms> &entry = skins_[static_cast<std::size_t>(index)];
        if (!entry) {
            entry = std::make_shared<const JointTransforms>(read(skin));
        }
        return entry;
    }

private:
    JointTransforms read(const tinygltf::Skin &skin) {
        std::vector<double> inverse_bind;
        if (skin.inverseBindMatrices >= 0) {
            inverse_bind = read_matrices(model_, skin.inverseBindMatrices, skin.joints.size());
        }
        JointTransforms joints;
        joints.reserve(skin.joints.size());
        for (const int joint : skin.joints) {
            Eigen::Affine3d transform = place(joint);
            if (!inverse_bind.empty()) { // their last row is 0 0 0 1
                Eigen::Affine3d bind;
                bind.matrix() =
                    Eigen::Map<const Eigen::Matrix4d>(&inverse_bind[16 * joints.size()]);
                bind.makeAffine();
                transform = transform * bind;
            }
            joints.push_back(transform);
        }
        return joints;
    }

    /// Where a joint is, which need not be in the scene, nor its ancestors.
    const Eigen::Affine3d &place(int joint) {
        static_cast<void>(checked(model_.nodes, joint, "joint"));
        std::vector<std::size_t> chain; // of those without a place yet
        auto node = static_cast<std::size_t>(joint);
        Eigen::Affine3d above = Eigen::Affine3d::Identity();
        while (!to_world_[node]) {
            stop_if_given_up(chain.size());
            if (parents_.empty()) {
                parents_ = parents_of(model_);
            }
            if (chain.size() == model_.nodes.size() || parents_[node] == kSeveralParents) {
                refuse_graph(label_of(model_, node));
            }
            chain.push_back(node);
            if (parents_[node] == kNoParent) {
                break;
            }
            node = static_cast<std::size_t>(parents_[node]);
        }
        if (to_world_[node]) {
            above = *to_world_[node];
        }
        for (auto below = chain.rbegin(); below != chain.rend(); ++below) {
            above = above * local_transform(model_.nodes[*below], label_of(model_, *below));
            to_world_[*below] = above;
        }
        return *to_world_[static_cast<std::size_t>(joint)];
    }

    const tinygltf::Model &model_;
    std::vector<std::optional<Eigen::Affine3d>> to_world_;
    std::vector<int> parents_;
    std::vector<std::shared_ptr<const JointTransforms>> skins_;
};

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
    std::vector<std::optional<Eigen::Affine3d>> to_world(model.nodes.size());
    std::vector<Visit> stack; // instead of recursion: a chain of nodes may be any length
    push_all(stack, root_nodes(model), Eigen::Affine3d::Identity(), {});
    while (!stack.empty()) {
        stop_if_given_up();
        const Visit visit = stack.back();
        stack.pop_back();
        const tinygltf::Node &node = checked(model.nodes, visit.node, "node");
        const auto index = static_cast<std::size_t>(visit.node);
        const std::string label = label_of(model, index);
        if (to_world[index]) {
            refuse_graph(label);
        }
        to_world[index] = visit.parent_to_world * local_transform(node, label);
        if (!to_world[index]->matrix().allFinite()) {
            throw InputError(label + ": its transform is not finite");
        }
        const TouchExtras touch =
            read_touch(node.extras_json_string, visit.parent_touch, label, warnings);
        if (node.mesh >= 0) {
            const tinygltf::Mesh &mesh = checked(model.meshes, node.mesh, label + ": mesh");
            const Instances instances(model, node, label);
            if (instances.count() > 1 && placed.size() + instances.count() > kMaxInstances) {
                throw InputError(label + ": with its " + std::to_string(instances.count()) +
                                 " instances the scene has more than " +
                                 std::to_string(kMaxInstances) + " meshes; export fewer");
            }
            if (node.skin >= 0 && instances.count() > 1) {
                warnings.add_of(label, nullptr, "its instances are left out: it has a skin");
            }
            const std::size_t count =
                node.skin >= 0 ? std::min<std::size_t>(instances.count(), 1) : instances.count();
            for (std::size_t i = 0; i < count; ++i) {
                placed.push_back({name_of(model, index), label, node.mesh,
                                  *to_world[index] * instances[i], touch,
                                  node.weights.empty() ? mesh.weights : node.weights, node.skin});
                placed.back().touch.material.name = placed.back().name;
                if (i > 0) {
                    placed.back().touch.caption.clear(); // it is on the first
                }
                if (!placed.back().to_world.matrix().allFinite()) {
                    throw InputError(label + ": the transform of instance " + std::to_string(i) +
                                     " is not finite");
                }
            }
        } else if (touch.shape) {
            warnings.add_of(label, nullptr,
                            "extras.shape is left out: it needs a mesh on the same node, to be "
                            "fitted to");
        }
        push_all(stack, node.children, *to_world[index], touch);
    }
    SkinCache skins(model, std::move(to_world)); // with the place of each node that may be a joint
    for (PlacedMesh &mesh : placed) {
        if (mesh.skin < 0) {
            continue;
        }
        mesh.without_skin = std::exchange(mesh.to_world, Eigen::Affine3d::Identity());
        try {
            mesh.joints = skins.find_or_read(mesh.skin);
        } catch (const InputError &error) {
            throw InputError(mesh.label + ": skin " + std::to_string(mesh.skin) + ": " +
                             error.what());
        }
    }
    return placed;
}

} // namespace springdrive::scene::gltf
