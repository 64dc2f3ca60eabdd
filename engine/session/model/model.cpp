#include "engine/session/model/model.h"

#include "base/assertions.h"
#include "base/number_in.h"

#include <algorithm>

namespace springdrive::model_selection {

namespace {

constexpr std::string_view kSimplified = "simplified_";

template <typename List> auto named(const List &list, std::string_view name) {
    const auto found = std::ranges::find(list, name, &List::value_type::name);
    return found == list.end() ? nullptr : &*found;
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

} // namespace springdrive::model_selection
