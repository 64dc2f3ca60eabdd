#include "engine/study/protocol/study_setting.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "base/input_file.h"
#include "base/text.h"
#include "device/core/device_file.h"
#include "device/core/hand_parameters.h"
#include "device/core/phantom/kinematics.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/control/motion_control.h"
#include "engine/lab/loops/both_maps.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/scene/gltf.h"
#include "engine/scene/scene.h"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace springdrive::study {

namespace {

/// How far a given spot may be from the surface, and its normal from the surface's.
constexpr double kOffSurface_m = 1e-3;
constexpr double kOffNormal_rad = 5.0 * kRadiansPerDegree;

bool is_file(const std::string &name) { return name.find_first_of("./\\") != std::string::npos; }

std::filesystem::path included_or_own(const std::string &name, const ProtocolFolders &folders,
                                      const std::string &kind, const std::string &ending) {
    if (!is_file(name)) {
        return folders.assets / kind / (name + ending);
    }
    try {
        static_cast<void>(contained_file(name, folders.own, "protocol"));
    } catch (const InputError &error) {
        throw InputError(in_quotes(name) + " " + error.what());
    }
    return folders.own / name;
}

struct LoadedStudyScene {
    scene::Lesson lesson;
    std::shared_ptr<const contact::HapticSurface> surface; ///< null: it could not be loaded
    std::string problem;                                   ///< why
};

LoadedStudyScene load(const std::filesystem::path &file, const device::Workspace &workspace) {
    LoadedStudyScene loaded;
    loaded.problem = error_text_of([&] {
        const scene::Scene scene = scene::load_gltf(file, workspace);
        loaded.lesson = scene.lesson;
        loaded.surface =
            std::make_shared<const contact::HapticSurface>(scene::haptic_surface_of(scene));
    });
    return loaded;
}

/// The contact of a tip that comes straight down on a spot and stops half a millimetre below it.
contact::Contact touch_at(const contact::HapticSurface &surface, const scene::TouchSpot &spot) {
    constexpr double kTouchDepth_m = 0.5e-3;
    constexpr int kSteps = 100;
    contact::Proxy proxy;
    proxy.reset(spot.point_m + kApproach_m * spot.normal);
    contact::Contact contact;
    for (int i = 1; i <= kSteps; ++i) {
        const double height_m = kApproach_m - (kApproach_m + kTouchDepth_m) * i / kSteps;
        contact = proxy.update(surface, spot.point_m + height_m * spot.normal);
        if (contact.touching && height_m > kOffSurface_m) {
            return contact; // something is in the way
        }
    }
    return contact;
}

std::string wrong_spot(const scene::TouchSpot &spot, const contact::Contact &contact) {
    if (!contact.touching) {
        return fmt::format("its spot is not on the surface: {:g} mm below it nothing is touched; "
                           "move point_m onto the surface, or turn normal out of it",
                           0.5);
    }
    if (const double off_m = (contact.x0_m - spot.point_m).norm(); off_m > kOffSurface_m) {
        return fmt::format("on the way to its spot the tip touches something {:.1f} mm off it; "
                           "choose a spot that is free for {:g} mm along its normal",
                           1e3 * off_m, 1e3 * kApproach_m);
    }
    const double off_rad = std::acos(std::clamp(contact.normal.dot(spot.normal), -1.0, 1.0));
    if (off_rad > kOffNormal_rad) {
        return fmt::format("its normal is {:.0f}° off the surface's at the spot; give ({:.3f}, "
                           "{:.3f}, {:.3f})",
                           off_rad * kDegreesPerRadian, contact.normal.x(), contact.normal.y(),
                           contact.normal.z());
    }
    return {};
}

PlacedCondition placed(const Condition &condition, const LoadedStudyScene &scene) {
    PlacedCondition place;
    place.surface = scene.surface;
    if (!scene.problem.empty()) {
        place.problem = scene.problem;
        return place;
    }
    if (!condition.spot && !scene.lesson.spot) {
        place.problem = fmt::format("scene {} marks no spot; give point_m and normal, in device "
                                    "coordinates",
                                    condition.scene);
        return place;
    }
    place.spot = condition.spot ? *condition.spot : *scene.lesson.spot;
    const contact::Contact contact = touch_at(*scene.surface, place.spot);
    place.problem = wrong_spot(place.spot, contact);
    place.surface_eta = contact.touching ? contact.eta : 0.0;
    return place;
}

PlacedCondition in_free_space(const Condition &condition, const device::Workspace &workspace) {
    PlacedCondition place;
    place.spot = condition.spot.value_or(scene::TouchSpot{workspace.centre_m, Vector3::UnitY()});
    place.surface_eta = 1.0;
    return place;
}

void add(std::vector<Presented> &all, const Protocol &protocol, std::size_t condition,
         std::optional<double> level) {
    Condition parameters =
        level ? comparison(protocol, condition, *level) : standard(protocol, condition);
    if (const std::optional<control::Tuning> free = free_space_tuning(protocol, parameters)) {
        all.push_back({condition, level, std::move(parameters), *free});
    }
}

bool is_in_a_block(const Protocol &protocol, std::size_t condition) {
    return std::ranges::any_of(protocol.blocks, [condition](const ProtocolBlock &block) {
        return std::ranges::count(block.conditions, condition) > 0;
    });
}

double active_alpha(const StudySetting &setting, const control::Tuning &tuning, const Matrix3 &J) {
    switch (tuning.alpha_mode) {
    case control::AlphaMode::global:
        return setting.global_alpha_rad2_per_m2;
    case control::AlphaMode::by_hand:
        return tuning.alpha_rad2_per_m2;
    case control::AlphaMode::on_the_fly:
    case control::AlphaMode::at_touch:
        break;
    }
    return control::alpha_bound(J, control::relative_stiffness(setting.device));
}

/// The static stiffness of the tip under the condition's map.
std::optional<Matrix3> static_stiffness(const StudySetting &setting, const Presented &presented,
                                        const Vector3 &q_rad, const Matrix3 &J) {
    const Condition &condition = presented.parameters;
    control::Tuning tuning = condition.tuning;
    const double surface_eta =
        condition.hold == Hold::cup ? 0.0 : setting.conditions[presented.condition].surface_eta;
    tuning.eta = control::combined_eta(surface_eta, tuning.eta);
    const std::optional<loops::MapStiffness> both =
        loops::map_stiffness(setting.device, tuning, q_rad, active_alpha(setting, tuning, J));
    if (!both) {
        return std::nullopt;
    }
    return tuning.map == control::MotionMap::inverse
               ? both->inverse_N_per_m
               : Matrix3(both->transpose_N_per_m * Matrix3::Identity());
}

/// The part of the hand's force along the normal, without a pulse.
double pressed_N(const device::DeviceDescription &device, const Condition &condition,
                 StimulusForm form, const PredictedPress &press, const Vector3 &normal) {
    if (form != StimulusForm::blow) {
        return condition.press_N;
    }
    const double mass_kg =
        device::HandParameters{}.mass_kg + tip_mass_kg(device, press.q_rad, normal);
    return condition.speed_m_per_s * std::sqrt(press.stiffness_N_per_m * mass_kg);
}

/// Sets depth, forces and energy of a press against the stiffness K.
void set_force(PredictedPress &press, const Condition &condition, StimulusForm form,
               const Matrix3 &K, const Vector3 &normal, double normal_N) {
    const Vector3 turn = turned(condition, normal);
    const bool is_turned = condition.turn_deg != 0.0 && form != StimulusForm::pulse;
    // Cut at 84 degrees, where the force would be ten times the press.
    const double against_hand = is_turned ? std::max(0.1, turn.dot(normal)) : 1.0;
    press.depth_m = normal_N / (press.stiffness_N_per_m * against_hand);
    const Vector3 straight_N = press.depth_m * (K * normal);
    press.held_N = is_turned ? Vector3(straight_N.dot(normal) * turn) : straight_N;
    press.force_N = press.held_N;
    if (form == StimulusForm::pulse) {
        press.force_N += condition.pulse_N * turn;
    }
    press.held_energy_J = 0.5 * press.depth_m * straight_N.dot(normal);
}

void set_direction(StimulusMeasures &measures, const TurnFrame &frame, const Vector3 &force) {
    const ForceAngles angles = force_angles(frame, force);
    measures.turn_deg = angles.turn_deg;
    measures.across_deg = angles.across_deg;
}

} // namespace

std::filesystem::path device_file_of(const Protocol &protocol, const ProtocolFolders &folders) {
    return included_or_own(protocol.device_file, folders, "devices", ".toml");
}

std::filesystem::path scene_file_of(const Condition &condition, const ProtocolFolders &folders) {
    return included_or_own(condition.scene, folders, "scenes", ".gltf");
}

StudySetting study_setting(const Protocol &protocol, const ProtocolFolders &folders) {
    StudySetting setting;
    setting.device = device::read_device_file(device_file_of(protocol, folders));
    setting.global_alpha_rad2_per_m2 = control::global_alpha_bound(setting.device);
    std::map<std::filesystem::path, LoadedStudyScene> scenes;
    for (const Condition &condition : protocol.conditions) {
        if (condition.scene == kNoScene) {
            setting.conditions.push_back(in_free_space(condition, setting.device.workspace));
            if (protocol.stimulus != StimulusForm::stroke) {
                setting.conditions.back().problem = "it has no scene; name one, as only a stroke "
                                                    "is felt in free space";
            }
            continue;
        }
        std::filesystem::path file;
        if (std::string problem = error_text_of([&] { file = scene_file_of(condition, folders); });
            !problem.empty()) {
            setting.conditions.emplace_back().problem = std::move(problem);
            continue;
        }
        if (!scenes.contains(file)) {
            scenes.emplace(file, load(file, setting.device.workspace));
        }
        setting.conditions.push_back(placed(condition, scenes.at(file)));
    }
    return setting;
}

bool is_used(const Protocol &protocol, std::size_t condition) {
    return is_in_a_block(protocol, condition) || standard_condition_of(protocol) == condition;
}

std::vector<Presented> all_presented(const Protocol &protocol) {
    std::vector<Presented> all;
    const std::optional<std::size_t> shared = standard_condition_of(protocol);
    if (shared) {
        add(all, protocol, *shared, std::nullopt);
    }
    const std::vector<double> levels = presentable_levels(protocol);
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        if (!is_in_a_block(protocol, i)) {
            continue;
        }
        if (!shared) {
            add(all, protocol, i, std::nullopt);
        }
        for (const double level : levels) {
            add(all, protocol, i, level);
        }
    }
    return all;
}

std::vector<Presented> extremes(const std::vector<Presented> &all) {
    std::vector<Presented> some;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const bool is_first =
            i == 0 || all[i - 1].condition != all[i].condition || !all[i - 1].level.has_value();
        const bool is_last = i + 1 == all.size() || all[i + 1].condition != all[i].condition ||
                             !all[i + 1].level.has_value();
        if (!all[i].level || is_first || is_last) {
            some.push_back(all[i]);
        }
    }
    return some;
}

std::string name_of(const Protocol &protocol, const Presented &presented) {
    const std::string name =
        fmt::format("condition \"{}\"", protocol.conditions[presented.condition].name);
    if (!presented.level) {
        return name + ", the standard";
    }
    const ParameterFacts &variable = variable_of(protocol);
    return fmt::format("{} at level {:g} ({} {:g})", name, *presented.level, variable.name,
                       variable.get(presented.parameters));
}

double tip_mass_kg(const device::DeviceDescription &device, const Vector3 &q_rad,
                   const Vector3 &direction) {
    loops::StabilityCase which;
    which.device = device;
    which.q_rad = q_rad;
    which.freedom = loops::Freedom::three_motors;
    const Matrix3 M = loops::driven_load(which, {0, loops::no_hand()}).inertia_kg_m2;
    const Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
    return 1.0 / direction.dot(J * M.inverse() * J.transpose() * direction);
}

std::optional<PredictedPress> predicted_press(const StudySetting &setting,
                                              const Presented &presented, StimulusForm form) {
    const device::DeviceDescription &device = setting.device;
    const Condition &condition = presented.parameters;
    const scene::TouchSpot &spot = setting.conditions[presented.condition].spot;
    const std::optional<Vector3> q_rad = device::joint_angles_rad(device.geometry, spot.point_m);
    if (!q_rad || form == StimulusForm::stroke) {
        return std::nullopt;
    }
    PredictedPress press;
    press.q_rad = *q_rad;
    const Matrix3 J = device::motor_jacobian(device.geometry, *q_rad);
    const std::optional<Matrix3> K = static_stiffness(setting, presented, *q_rad, J);
    if (!K || !(spot.normal.dot(*K * spot.normal) > 0.0)) {
        return std::nullopt;
    }
    press.stiffness_N_per_m = spot.normal.dot(*K * spot.normal);
    set_force(press, condition, form, *K, spot.normal,
              pressed_N(device, condition, form, press, spot.normal));
    return press;
}

Vector3 currents_A(const device::DeviceDescription &device, const Vector3 &q_rad,
                   const Vector3 &force_N) {
    const Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
    return (J.transpose() * force_N).cwiseQuotient(control::torque_constants(device));
}

double pulse_energy_J(const device::DeviceDescription &device, const PredictedPress &press,
                      const Condition &condition) {
    const loops::Hand light = loops::hand_of_firmness(0.0);
    const Vector3 pushed_N = press.force_N - press.held_N;
    const double mass_kg = light.mass_kg + tip_mass_kg(device, press.q_rad, pushed_N.normalized());
    const double impulse_Ns = 0.5 * condition.pulse_N / condition.pulse_hz; // of (1 − cos)/2
    return std::min(0.5 * impulse_Ns * impulse_Ns / mass_kg,
                    0.5 * condition.pulse_N * condition.pulse_N / light.stiffness_N_per_m);
}

bool is_steered(const Protocol &protocol, const Condition &condition) {
    switch (protocol.stimulus) {
    case StimulusForm::press:
        return condition.turn_deg != 0.0 || (condition.hold == Hold::cup &&
                                             condition.tuning.map == control::MotionMap::transpose);
    case StimulusForm::blow:
        return condition.turn_deg != 0.0;
    case StimulusForm::pulse:
    case StimulusForm::stroke:
        break;
    }
    return false;
}

double longest_glide_back_s(const Protocol &protocol) {
    double longest_s = 0.0;
    for (const Presented &presented : all_presented(protocol)) {
        Stimulus stimulus;
        stimulus.form = protocol.stimulus;
        stimulus.contact = presented.parameters.tuning;
        stimulus.free_space = presented.free_space;
        stimulus.is_steered = is_steered(protocol, presented.parameters);
        longest_s = std::max(longest_s, glide_back_s(stimulus));
    }
    return longest_s;
}

Stimulus stimulus_of(const Protocol &protocol, const StudySetting &setting,
                     const Presented &presented) {
    const Condition &condition = presented.parameters;
    const scene::TouchSpot &spot = setting.conditions[presented.condition].spot;
    Stimulus stimulus;
    stimulus.form = protocol.stimulus;
    stimulus.hold = condition.hold;
    stimulus.contact = condition.tuning;
    stimulus.free_space = presented.free_space;
    stimulus.start_m = protocol.stimulus == StimulusForm::stroke
                           ? spot.point_m
                           : Vector3(spot.point_m + kApproach_m * spot.normal);
    stimulus.frame = {spot.normal, turn_axis(spot.normal, condition.turn_axis_deg)};
    stimulus.direction = turned(condition, spot.normal);
    stimulus.is_steered = is_steered(protocol, condition);
    stimulus.pulse = {condition.pulse_N, condition.pulse_hz};
    stimulus.rest_s = protocol.timing.rest_s;
    stimulus.approach_s = protocol.timing.approach_s;
    stimulus.presentation_s = protocol.timing.presentation_s;
    stimulus.min_glide_back_s = longest_glide_back_s(protocol);
    return stimulus;
}

StimulusMeasures intended_measures(const Protocol &protocol, const StudySetting &setting,
                                   const Presented &presented) {
    const Stimulus stimulus = stimulus_of(protocol, setting, presented);
    const Condition &condition = presented.parameters;
    StimulusMeasures measures;
    if (stimulus.form == StimulusForm::stroke || stimulus.form == StimulusForm::blow) {
        measures.speed_m_per_s = condition.speed_m_per_s;
        if (stimulus.is_steered) {
            set_direction(measures, stimulus.frame, stimulus.direction);
        }
        return measures;
    }
    const std::optional<PredictedPress> press = predicted_press(setting, presented, stimulus.form);
    if (!press) {
        return measures;
    }
    measures.stiffness_N_per_m = press->stiffness_N_per_m;
    measures.press_N = condition.press_N;
    if (stimulus.form == StimulusForm::pulse) {
        measures.pulse_N = condition.pulse_N;
        set_direction(measures, stimulus.frame, stimulus.direction);
    } else if (stimulus.is_steered || stimulus.hold == Hold::surface) {
        set_direction(measures, stimulus.frame, press->held_N);
    }
    return measures;
}

} // namespace springdrive::study
