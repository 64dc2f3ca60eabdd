// How much of the device needs to be simulated: the plant models of plant_model.h over a contact
// transient with quantised encoders, in full and in the plane of the links. A point for each step,
// a line for each model; the error is that of the force on the hand, against the full model at a
// step of about a microsecond.
//
// The press lies in the links' plane, so that it suits the models with a locked base.
#pragma once

#include "device/simulated/plant_model.h"
#include "engine/lab/charts/chart.h"
#include "engine/lab/charts/contact_press.h"

namespace springdrive::charts {

/// @throw InputError where the press is out of the device's reach
[[nodiscard]] SpeedAccuracyChart plant_model_chart(const ChartSetting &setting,
                                                   const ChartProgress &progress);

/// A model of the plant in the press, with `sub_steps` equal steps in a servo period. Its force is
/// that on the hand, the mean of each period.
[[nodiscard]] NewPlant model_plant(const rig::Scenario &press, const simulated::PlantModel &model,
                                   bool planar, int sub_steps);

} // namespace springdrive::charts
