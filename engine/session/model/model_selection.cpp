#include "engine/session/model/model_selection.h"

#include "base/assertions.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace springdrive::model_selection {

namespace {

constexpr std::string_view kSimplified = "simplified_";

template <typename List> auto named(const List &list, std::string_view name) {
    const auto found = std::ranges::find(list, name, &List::value_type::name);
    return found == list.end() ? nullptr : &*found;
}

[[noreturn]] void refuse(const std::string &aspect, const std::string &name) {
    throw InputError("model choice: its " + aspect + " is '" + name +
                     "', which this program does not know; measure it again with --fresh");
}

int number(const std::string &aspect, const std::string &text, int minimum) {
    const auto value = number_in<int>(text);
    if (!value || *value < minimum) {
        refuse(aspect, text);
    }
    return *value;
}

} // namespace

std::string name_of(const ContactShape &shape) {
    switch (shape.kind) {
    case ContactShape::Kind::primitives:
        return "primitives";
    case ContactShape::Kind::simplified:
        return std::string(kSimplified) + std::to_string(shape.divisor);
    case ContactShape::Kind::flat:
        return "flat";
    case ContactShape::Kind::given:
        break;
    }
    return "given";
}

std::optional<ContactShape> contact_shape_named(std::string_view name) {
    for (const auto kind :
         {ContactShape::Kind::primitives, ContactShape::Kind::flat, ContactShape::Kind::given}) {
        if (name == name_of({kind, 1})) {
            return ContactShape{kind, 1};
        }
    }
    if (!name.starts_with(kSimplified)) {
        return std::nullopt;
    }
    const auto divisor =
        number_in<decltype(ContactShape::divisor)>(name.substr(kSimplified.size()));
    return divisor && *divisor >= 2
               ? std::optional(ContactShape{ContactShape::Kind::simplified, *divisor})
               : std::nullopt;
}

const MotionController *motion_controller_named(std::string_view name) {
    return named(kMotionControllers, name);
}

const simulated::PlantModel *plant_model_named(std::string_view name) {
    return named(simulated::kPlantModels, name);
}

void apply(const Model &model, simulated::SimulationOptions &simulation) {
    SPRINGDRIVE_ASSERT(simulation.servo_period_s > 0.0);
    simulation.dynamics = model.plant.dynamics;
    simulation.effects = model.plant.effects;
    simulation.planar = model.planar;
    simulation.longest_step_s = simulation.servo_period_s / model.steps;
}

control::Tuning with_controller(const MotionController &controller, control::Tuning tuning) {
    tuning.map = controller.map;
    tuning.alpha_mode = controller.alpha_mode;
    return tuning;
}

Model model_of(const ModelSelection &choice) {
    Model model;
    const std::string &plant = choice.chosen(ModelAspect::plant);
    const simulated::PlantModel *const plant_model = plant_model_named(plant);
    const std::string &shape = choice.chosen(ModelAspect::surface);
    const std::optional<ContactShape> contact_shape = contact_shape_named(shape);
    const std::string &controller = choice.chosen(ModelAspect::controller);
    const MotionController *const motion_controller = motion_controller_named(controller);
    if (plant_model == nullptr) {
        refuse("plant", plant);
    }
    if (!contact_shape) {
        refuse("surface", shape);
    }
    if (motion_controller == nullptr) {
        refuse("controller", controller);
    }
    model.plant = *plant_model;
    model.steps = number("steps", choice.chosen(ModelAspect::steps), 1);
    model.planar = number("joints", choice.chosen(ModelAspect::joints), 2) == 2;
    model.shape = *contact_shape;
    model.controller = *motion_controller;
    return model;
}

double share_of_tolerance(const ModelError &error, const scene::ModelTolerance &tolerance) {
    const double share =
        std::max(error.force_N / tolerance.force_N, error.direction_rad / tolerance.direction_rad);
    const bool is_number = !std::isnan(error.force_N) && !std::isnan(error.direction_rad);
    return is_number ? share : std::numeric_limits<double>::infinity();
}

std::string verdict(const ModelError &error, const scene::ModelTolerance &tolerance) {
    if (meets(error, tolerance)) {
        return "meets";
    }
    if (!std::isfinite(error.force_N)) {
        return "runs away";
    }
    std::string text;
    if (error.force_N > tolerance.force_N) {
        text = fmt::format("force {:.2g} N > {:.2g} N", error.force_N, tolerance.force_N);
    }
    if (error.direction_rad > tolerance.direction_rad) {
        fmt::format_to(std::back_inserter(text), "{}direction {:.2g}° > {:.2g}°",
                       text.empty() ? "" : ", ", error.direction_rad * kDegreesPerRadian,
                       tolerance.direction_rad * kDegreesPerRadian);
    }
    return text;
}

} // namespace springdrive::model_selection
