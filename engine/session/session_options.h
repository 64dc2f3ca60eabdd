// Options of a session, with or without a window.
#pragma once

#include "base/new_file.h"
#include "device/factory/device_factory.h"
#include "device/simulated/simulation_options.h"
#include "engine/control/tuning.h"
#include "engine/session/scene_models.h"
#include "engine/session/telemetry_history.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace springdrive::session {

/// The choice of a device, and the file that describes it.
struct DeviceChoice {
    std::filesystem::path file;
    factory::DeviceKind kind = factory::DeviceKind::simulated;
    std::string serial; ///< empty: the only one of its kind
};

struct SessionOptions {
    std::filesystem::path scene;
    DeviceChoice device;
    control::Tuning tuning;
    double servo_hz = 1000.0;
    bool starts_at_zero = false; ///< a device that must be zeroed is in its zero pose at the start
    double delay_periods = 0.0;  ///< of simulated devices; of others, it is measured
    simulated::PlantEffects effects;     ///< of simulated and emulated devices
    std::uint64_t device_seed = 0;       ///< see SimulationOptions
    factory::EmulationOptions emulation; ///< of emulated devices
    bool observes_resistance = true;     ///< R̂ follows the windings' resistances, see `Session`
    ModelOptions model;
    std::filesystem::path path; ///< of the hand; empty: see `plays_script`
    bool plays_script = false; ///< without a path: the scripted touch, not `SimulatedHand::move_to`
    /// Bound on the telemetry that is kept for plots and past records.
    std::size_t history_bytes = TelemetryHistory::kMaxBytes;
    bool lockstep = false;  ///< the servo is timed by `Session::advance`, not by a clock
    std::optional<int> cpu; ///< the processor of the servo's thread
    std::optional<double> late_limit_s; ///< of consecutive missed deadlines; lowers the device's
    std::filesystem::path record;       ///< empty: nothing is recorded until requested
    Existing existing_record = Existing::keep;
    /// Where the windings' temperatures are kept for the next start, see windings_file; empty:
    /// nowhere.
    std::filesystem::path windings_folder;
    std::string program_version; ///< for records, and for cached model choices
};

} // namespace springdrive::session
