#include "engine/lab/model_selection/model_run.h"

#include "base/cancellation.h"
#include "base/timing.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/rig/law_rig.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

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

constexpr int kRepeats = 7;
constexpr std::size_t kPlantTicks = 500; // enough of the path for a touch and a release
constexpr std::size_t kPieceTicks = 25;  // per timing

/// The cost of a tick where each repeat does the same work. Every piece counts with the minimum of
/// its times, which excludes interruptions by other work of the machine.
class TickClock {
public:
    explicit TickClock(std::size_t ticks) : min_ns_(ticks / kPieceTicks, kNever) {}

    /// Runs and times `tick(i)` for each i.
    template <typename Tick> void repeat(const Tick &tick) {
        double sum_ns = 0.0;
        for (std::size_t piece = 0; piece < min_ns_.size(); ++piece) {
            stop_if_given_up();
            const auto start = std::chrono::steady_clock::now();
            for (std::size_t i = 0; i < kPieceTicks; ++i) {
                tick(piece * kPieceTicks + i);
            }
            const auto end = std::chrono::steady_clock::now();
            const double time_ns = std::chrono::duration<double, std::nano>(end - start).count();
            min_ns_[piece] = std::min(min_ns_[piece], time_ns);
            sum_ns += time_ns;
        }
        sums_ns_.push_back(sum_ns);
    }

    [[nodiscard]] Cost cost() const {
        const auto timed = static_cast<double>(min_ns_.size() * kPieceTicks);
        Cost cost = cost_of_times(sums_ns_);
        cost.min_ns = std::accumulate(min_ns_.begin(), min_ns_.end(), 0.0) / timed;
        cost.median_ns /= timed;
        cost.max_ns /= timed;
        return cost;
    }

private:
    static constexpr double kNever = std::numeric_limits<double>::infinity();

    std::vector<double> min_ns_;  ///< of each piece
    std::vector<double> sums_ns_; ///< of each repeat
};

/// The law with one map only.
class OneMap {
public:
    OneMap(const ModelSetting &setting, const MotionController &controller)
        : geometry_(setting.scenario.device.geometry),
          relative_stiffness_(control::relative_stiffness(setting.scenario.device)),
          k_T_(control::torque_constants(setting.scenario.device)),
          tuning_(setting.scenario.tuning), controller_(controller),
          global_alpha_(setting.global_alpha_rad2_per_m2) {}

    [[nodiscard]] Vector3 e_W_V(const control::Configuration &now,
                                const contact::Contact &contact) const {
        const control::TipSetPoint target =
            control::contact_set_point(now.tip_m, now.tip_velocity_m_per_s(), contact,
                                       control::combined_eta(contact.eta, tuning_.eta));
        return control::drift_compensation_V(k_T_, tuning_, now, set_point(now, target));
    }

private:
    [[nodiscard]] control::MotorSetPoint set_point(const control::Configuration &now,
                                                   const control::TipSetPoint &target) const {
        if (controller_.map == control::MotionMap::inverse) {
            return control::inverse_map(geometry_, now, target).value_or(control::no_force(now));
        }
        const double alpha = controller_.alpha_mode == control::AlphaMode::global
                                 ? global_alpha_
                                 : control::alpha_bound(now.J, relative_stiffness_);
        return control::transpose_map(now, target, alpha, relative_stiffness_);
    }

    device::PhantomGeometry geometry_;
    Vector3 relative_stiffness_;
    Vector3 k_T_;
    control::Tuning tuning_;
    MotionController controller_;
    double global_alpha_;
};

/// Calls `run(candidate, clock)` for each candidate in turn, repeatedly.
template <typename Run>
std::vector<Cost> costs_of(std::size_t candidates, std::size_t ticks, const Run &run) {
    std::vector<TickClock> clocks(candidates, TickClock(ticks));
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        for (std::size_t i = 0; i < candidates; ++i) {
            run(i, clocks[i]);
        }
    }
    std::vector<Cost> costs;
    costs.reserve(clocks.size());
    for (const TickClock &clock : clocks) {
        costs.push_back(clock.cost());
    }
    return costs;
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
    const std::vector<Vector3> requested_N = below(fullest.force_N, bandwidth_hz, period_s);
    double force_sum = 0.0;
    double angle_sum = 0.0;
    double with_direction = 0.0;
    for (std::size_t i = 0; i < felt_N.size(); ++i) {
        force_sum += (felt_N[i] - requested_N[i]).squaredNorm();
        const bool both_touch = run.contacts[i].touching && fullest.contacts[i].touching;
        if (both_touch &&
            std::min(felt_N[i].norm(), requested_N[i].norm()) >= kMinForceWithDirection_N) {
            const double angle_rad = control::direction_error_rad(felt_N[i], requested_N[i]);
            angle_sum += angle_rad * angle_rad;
            ++with_direction;
        }
    }
    return {std::sqrt(force_sum / static_cast<double>(felt_N.size())),
            with_direction > 0.0 ? std::sqrt(angle_sum / with_direction) : 0.0};
}

std::vector<Cost> plant_costs(const ModelSetting &setting, const std::vector<Model> &models,
                              const ModelRun &run) {
    const std::size_t ticks = std::min(kPlantTicks, run.commands.size());
    return costs_of(models.size(), ticks, [&](std::size_t model, TickClock &clock) {
        const std::unique_ptr<simulated::SimulatedPhantom> device =
            simulated_device(setting, models[model]);
        clock.repeat([&](std::size_t i) { keep(device->advance(run.commands[i])); });
    });
}

std::vector<Cost> contact_costs(const std::vector<const contact::HapticSurface *> &surfaces,
                                const ModelRun &run) {
    return costs_of(surfaces.size(), run.configurations.size(),
                    [&](std::size_t surface, TickClock &clock) {
                        contact::Proxy proxy;
                        proxy.reset(run.configurations.front().tip_m);
                        clock.repeat([&](std::size_t i) {
                            keep(proxy.update(*surfaces[surface], run.configurations[i].tip_m));
                        });
                    });
}

std::vector<Cost> control_costs(const ModelSetting &setting,
                                const std::vector<MotionController> &controllers,
                                const ModelRun &run) {
    return costs_of(controllers.size(), run.configurations.size(),
                    [&](std::size_t controller, TickClock &clock) {
                        const OneMap map(setting, controllers[controller]);
                        clock.repeat([&](std::size_t i) {
                            keep(map.e_W_V(run.configurations[i], run.contacts[i]));
                        });
                    });
}

} // namespace springdrive::model_selection
