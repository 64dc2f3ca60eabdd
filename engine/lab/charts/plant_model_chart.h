// How much of the device has to be simulated: the plant models of plant_model.h over a contact
// transient with encoders as they are, whole and in the plane of the links. A point for each step,
// a line for each model; the error is that of the force on the hand, against the fullest model at a
// step of about a microsecond.
//
// The press lies in the links' plane, so that it suits the models whose base stands still.
#pragma once

#include "device/simulated/plant_model.h"
#include "engine/lab/charts/chart_setting.h"
#include "engine/lab/charts/contact_press.h"
#include "engine/lab/rig/work_point.h"

namespace springdrive::charts {

/// @throw InputError where the device does not reach the place of the press
[[nodiscard]] rig::WorkPrecisionChart plant_model_chart(const ChartSetting &setting,
                                                        const ChartProgress &progress);

/// A model of the plant in the press, with so many equal sub-steps in a servo period. Its force is
/// that on the hand, the mean of each period.
[[nodiscard]] NewPlant model_plant(const rig::Scenario &press, const simulated::PlantModel &model,
                                   bool planar, int sub_steps);

} // namespace springdrive::charts
