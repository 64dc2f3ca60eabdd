#include "engine/scene/touch_extras.h"

#include "base/input_error.h"
#include "engine/scene/gltf_extras.h"

#include <array>
#include <string_view>

namespace springdrive::scene::gltf {

namespace {

constexpr std::array<std::string_view, 2> kSides = {"one", "two"}; // TouchSides after automatic
constexpr std::array<std::string_view, 5> kShapes = {"plate", "sphere", "box", "cylinder",
                                                     "capsule"}; // in the order of ShapeKind

void read_friction(const Extras &extras, contact::SurfaceMaterial &material) {
    constexpr double kGreatest = 10.0; // rubber reaches about 2; far above, it is a typing error
    const std::string range = "a number from 0 to 10";
    const auto at_rest = extras.number("static_friction", 0.0, kGreatest, range);
    const auto sliding = extras.number("dynamic_friction", 0.0, kGreatest, range);
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
    if (const auto sides = extras.word("sides", kSides, "'one' or 'two', or left out")) {
        material.sides = *sides == 0 ? contact::TouchSides::one : contact::TouchSides::two;
    }
}

/// A plate has no inside that a tip could be let out of; a solid has nothing but.
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

} // namespace

TouchExtras read_touch(const std::string &json, const TouchExtras &parent,
                       const std::string &label) {
    const Extras extras(json, label);
    TouchExtras touch = parent;
    touch.shape.reset();
    if (const auto eta =
            extras.number("eta", 0.0, 1.0, "a number from 0 (rigid) to 1 (free space)")) {
        touch.material.eta = *eta;
    }
    read_friction(extras, touch.material);
    read_sides(extras, touch.material);
    if (const auto smooth = extras.flag("smooth")) {
        touch.smooth = *smooth;
    }
    if (const auto shape =
            extras.word("shape", kShapes, "'plate', 'sphere', 'box', 'cylinder' or 'capsule'")) {
        touch.shape = static_cast<ShapeKind>(*shape);
    }
    check_sides(touch, label);
    return touch;
}

std::string name_of(ShapeKind shape) {
    return std::string(kShapes[static_cast<std::size_t>(shape)]);
}

} // namespace springdrive::scene::gltf
