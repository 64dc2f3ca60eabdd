#include "engine/lab/model_selection/model_run.h"

#include "base/cancellation.h"
#include "engine/control/force_direction.h"
#include "engine/lab/rig/law_rig.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace springdrive::model_selection {

namespace {

/// Weaker forces have no meaningful direction: five times the device's own friction.
constexpr double kMinForceWithDirection_N = 0.2;

std::size_t ticks_of(const ModelSetting &setting) {
    return static_cast<std::size_t>(setting.scenario.duration_s /
                                    setting.scenario.simulation.servo_period_s) +
           1;
}

/// Low-pass filtered, starting from zero.
std::vector<Vector3> below(std::vector<Vector3> force_N, double bandwidth_hz, double period_s) {
    const double pole = std::exp(-2.0 * std::numbers::pi * bandwidth_hz * period_s);
    Vector3 passed_N = Vector3::Zero();
    for (Vector3 &now_N : force_N) {
        passed_N = pole * passed_N + (1.0 - pole) * now_N;
        now_N = passed_N;
    }
    return force_N;
}

bool is_finite(const std::vector<Vector3> &vectors) {
    return std::ranges::all_of(vectors, [](const Vector3 &v) { return v.allFinite(); });
}

} // namespace

bool ModelRun::touches() const {
    return std::ranges::any_of(contacts, &contact::Contact::touching);
}

std::unique_ptr<simulated::SimulatedPhantom> simulated_device(const ModelSetting &setting,
                                                              const Model &model) {
    simulated::SimulationOptions simulation = setting.scenario.simulation;
    apply(model, simulation);
    return std::make_unique<simulated::SimulatedPhantom>(setting.scenario.device, simulation,
                                                         setting.scenario.start_m);
}

ModelRun run_model(const ModelSetting &setting, const Model &model,
                   const contact::HapticSurface &surface) {
    const std::unique_ptr<simulated::SimulatedPhantom> device = simulated_device(setting, model);
    rig::PhantomPlant plant(*device);
    rig::LawOptions options;
    options.device = setting.scenario.device;
    options.tuning = with_controller(model.controller, setting.scenario.tuning);
    options.period_s = setting.scenario.simulation.servo_period_s;
    options.global_alpha_rad2_per_m2 = setting.global_alpha_rad2_per_m2;
    plant.advance({device::DeviceCommand::braking(), Vector3::Zero()});
    rig::LawRig loop(plant, options, rig::surface(surface), rig::FirstCommand::answers);
    ModelRun run;
    const auto note = [&](const device::DeviceCommand &command) {
        run.commands.push_back(command);
        run.force_N.emplace_back(-device->truth().hand_force_N);
        run.configurations.push_back(loop.configuration());
        run.contacts.push_back(loop.contact());
    };
    note(device::DeviceCommand::braking());
    while (run.commands.size() < ticks_of(setting)) {
        stop_if_given_up();
        const device::DeviceCommand command = loop.command().spring_drive;
        loop.tick();
        note(command);
    }
    return run;
}

ModelError model_error(const ModelRun &run, const ModelRun &fullest, double period_s,
                       double bandwidth_hz) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (!is_finite(run.force_N)) {
        return {kInfinity, kInfinity};
    }
    const std::vector<Vector3> felt_N = below(run.force_N, bandwidth_hz, period_s);
    const std::vector<Vector3> wanted_N = below(fullest.force_N, bandwidth_hz, period_s);
    double force_sum = 0.0;
    double angle_sum = 0.0;
    double with_direction = 0.0;
    for (std::size_t i = 0; i < felt_N.size(); ++i) {
        force_sum += (felt_N[i] - wanted_N[i]).squaredNorm();
        const bool both_touch = run.contacts[i].touching && fullest.contacts[i].touching;
        if (both_touch &&
            std::min(felt_N[i].norm(), wanted_N[i].norm()) >= kMinForceWithDirection_N) {
            const double angle_rad = control::direction_error_rad(felt_N[i], wanted_N[i]);
            angle_sum += angle_rad * angle_rad;
            ++with_direction;
        }
    }
    return {std::sqrt(force_sum / static_cast<double>(felt_N.size())),
            with_direction > 0.0 ? std::sqrt(angle_sum / with_direction) : 0.0};
}

} // namespace springdrive::model_selection
