#include "engine/lab/model_selection/model_cost.h"

#include "base/cancellation.h"
#include "base/timing.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/contact/proxy/proxy.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>
#include <vector>

namespace springdrive::model_selection {

namespace {

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
