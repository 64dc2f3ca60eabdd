// Options that several subcommands share.
#pragma once

#include "app/commands/command.h"
#include "app/commands/output_files.h"
#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/faults.h"
#include "device/factory/device_factory.h"
#include "device/simulated/simulation_options.h"
#include "engine/control/tuning.h"
#include "engine/scene/scene.h"
#include "engine/session/session.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {

/// `--device-file`: `file` starts as the PHANTOM 1.0.
void add_device_file_option(Command &command, std::filesystem::path &file);

/// `--device`, whatever `device` starts as.
void add_device_option(Command &command, std::string &device);

struct NamedDevice {
    factory::DeviceKind kind = factory::DeviceKind::simulated;
    std::string serial; ///< empty: the only one
};

/// The device that `--device` names.
/// @throw InputError unless it is sim, usb, usb:SERIAL or emulated
[[nodiscard]] NamedDevice device_named(const std::string &device);

/// `--true-device-file` and `--fault`: what an emulated board is.
struct TypedEmulation {
    std::filesystem::path true_device_file; ///< empty: the device file
    std::vector<std::string> faults;

    /// The options hold references to this: it must stay where it is until the parse is over.
    /// @param device  "emulated board", in their help
    void add_to(Command &command, const std::string &device);

    [[nodiscard]] bool is_empty() const { return true_device_file.empty() && faults.empty(); }
    /// @throw InputError if `true_device_file` is no device file
    [[nodiscard]] std::optional<device::DeviceDescription> truth() const;
    /// @throw InputError if one of `faults` is no fault
    [[nodiscard]] std::vector<device::Fault> parsed_faults() const;
};

/// `--tuning-file`, which may stay empty.
void add_tuning_file_option(Command &command, std::filesystem::path &file);

/// The tuning in the file, or the default tuning if `file` is empty.
/// @throw InputError for a file without a tuning.
[[nodiscard]] control::Tuning tuning_of(const std::filesystem::path &file);

/// `kDefaultPose_deg`, for `--q`.
[[nodiscard]] std::vector<double> default_joint_angles_deg();

/// `--q`, in degrees; `q_deg` keeps its value unless the option is given.
void add_joint_angles_option(Command &command, std::vector<double> &q_deg);

/// @throw InputError for an angle that is not finite.
[[nodiscard]] Vector3 joint_angles_rad(const std::vector<double> &q_deg);

/// `--map` or `--kinematics`, one of `kMotionMapNames`.
/// @param warning  ends its help
void add_motion_map_option(Command &command, const std::string &option, std::string &map,
                           std::string_view warning = "");

/// `--servo-hz`, whatever `servo_hz` starts as.
Option add_servo_hz_option(Command &command, double &servo_hz);

/// `--delay`, which starts as 0.
Option add_delay_option(Command &command, double &delay_periods);

/// @throw InputError for a delay that cannot be simulated.
void check_delay(double delay_periods);

/// Names as `Option::one_of` takes them.
template <typename Names> [[nodiscard]] std::vector<std::string> list_of(const Names &names) {
    return {names.begin(), names.end()};
}

/// Which parameters a command can use.
enum class TuningScope : std::uint8_t {
    coupling,   ///< dR, K_P, K_D and λ, which determine K_θ (12)
    everything, ///< also α, η and the maps
};

/// `--tuning-file`, and an option for each parameter that is given on top of it.
struct TuningOptions {
    std::filesystem::path file; ///< empty: the default tuning
    std::array<std::optional<double>, control::kParameters.size()> value;
    std::string map;        ///< empty: as in the file
    std::string alpha_mode; ///< empty: as in the file

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(Command &command, TuningScope scope = TuningScope::everything);

    /// @throw InputError for a file that cannot be used, or a value out of its range.
    [[nodiscard]] control::Tuning tuning() const;
};

/// `--without`, `--with` and `--device-seed`: which effects the simulated device has.
struct EffectOptions {
    std::vector<std::string> without;
    std::vector<std::string> with;
    std::uint64_t device_seed = 0;

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(Command &command);

    /// Whether `--without` or `--with` is given.
    [[nodiscard]] bool switches_effects() const { return !without.empty() || !with.empty(); }

    [[nodiscard]] simulated::PlantEffects effects() const;
};

/// Warns on standard error if a tuning file's margins are those of a faster servo or a shorter
/// delay, and do not apply here.
void warn_about_margins(const std::filesystem::path &tuning_file, double servo_hz,
                        double delay_periods);

/// @throw InputError if dR exceeds a motor's resistance, or is below its amplifier's minimum.
void check_dR(const device::DeviceDescription &device, const control::Tuning &tuning);

/// The dR that the winding guard permits for motors that may be cold: that of the tuning, or a
/// larger one, which is then reported on standard error.
[[nodiscard]] double cold_dR_Ohm(const device::DeviceDescription &device,
                                 const control::Tuning &tuning);

/// @throw InputError, naming `what`, for a value beyond its range or not a number.
void check_range(const std::string &what, double value, double minimum, double maximum);

/// `--gltf-scene`.
void add_gltf_scene_option(Command &command, std::string &gltf_scene);

/// `touch_scene`, with a LoadProgressPrinter on standard error if that is a terminal.
[[nodiscard]] scene::Scene load_scene_with_progress(const std::string &name,
                                                    const std::string &gltf_scene,
                                                    const device::Workspace &workspace);

/// `--model`, and the options that override parts of it.
struct TypedModel {
    std::string use = "full";
    std::string plant;             ///< `--plant-model`; empty: as the model has it
    std::optional<double> step_us; ///< `--step-us`
    std::string surface;           ///< `--contact-shape`; empty: as the model has it

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(Command &command);

    /// Whether `--plant-model` or `--step-us` is given.
    [[nodiscard]] bool overrides_plant() const { return !plant.empty() || step_us.has_value(); }

    /// @throw InputError for an unknown part.
    [[nodiscard]] session::ModelOptions options(const TuningOptions &tuning) const;
};

/// All options of a session.
struct TypedSession {
    session::SessionOptions options;
    TuningOptions tuning;
    EffectOptions effects;
    TypedModel model;
    TypedEmulation emulation;
    std::optional<double> delay_periods;
    std::string device = "sim";
    std::optional<double> late_limit_ms;

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(Command &command);

    /// The options of the session.
    /// @throw InputError for options with which no session can run.
    [[nodiscard]] session::SessionOptions session() const;

    /// The files that the session reads and writes.
    /// @param written  those that it writes beside the record
    [[nodiscard]] RunFiles files(std::vector<std::filesystem::path> written) const;

private:
    void set_device(session::SessionOptions &session) const;
};

} // namespace springdrive::app
