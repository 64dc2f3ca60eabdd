// What a session is to run on, as plain values: with a window or without.
#pragma once

#include "app/model_options.h"
#include "device/simulated/simulation_options.h"
#include "engine/control/tuning.h"

#include <filesystem>
#include <optional>

namespace springdrive {

struct SessionOptions {
    std::filesystem::path scene;
    std::filesystem::path device_file;
    Tuning tuning;
    double servo_hz = 1000.0;
    double delay_periods = 0.0;
    PlantEffects effects; ///< of the simulated device
    ModelOptions model;
    std::filesystem::path path;      ///< of the hand; empty: see `plays_script`
    bool plays_script = false;       ///< without a path: the scripted touch, not `move_hand_to`
    bool lockstep = false;           ///< the servo goes by `Session::advance`, not by a clock
    std::optional<int> cpu;          ///< that the servo's thread is to stay on
    std::optional<double> late_limit_s; ///< of deadlines missed in a row, below the device's
    std::filesystem::path record;    ///< empty: nothing is recorded until asked for
};

} // namespace springdrive
