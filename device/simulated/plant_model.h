// Models of increasing detail: from the coupling alone to everything that is known about a device.
#pragma once

#include "device/simulated/simulation_options.h"

#include <array>
#include <string_view>

namespace springdrive::simulated {

/// A model and its name.
struct PlantModel {
    std::string_view name;
    PlantDynamics dynamics = PlantDynamics::electromechanical;
    PlantEffects effects;
};

/// From the cheapest to the most detailed.
inline constexpr std::array<PlantModel, 5> kPlantModels{{
    {"coupling", PlantDynamics::coupling, PlantEffects::none()},
    {"rigid_tip", PlantDynamics::rigid_body, {true, true, false, true, true, false, false, false}},
    {"electromechanical",
     PlantDynamics::electromechanical,
     {true, true, false, true, true, true, true, false}},
    {"rigid_links",
     PlantDynamics::electromechanical,
     {true, true, true, true, true, true, true, false}},
    {"full", PlantDynamics::electromechanical, {true, true, true, true, true, true, true, true}},
}};

} // namespace springdrive::simulated
