#include "engine/lab/charts/plant_model_chart.h"

#include "device/simulated/simulated_phantom.h"

#include <array>
#include <cmath>
#include <memory>
#include <string>

namespace springdrive::charts {

namespace {

constexpr std::array<int, 7> kSubSteps{1, 2, 5, 10, 20, 50, 100};
constexpr int kReferenceSubSteps = 1000;

/// The law reads its encoders in whole counts, from the start on.
class ModelPlant final : public PressedPlant {
public:
    ModelPlant(const device::DeviceDescription &description,
               const simulated::SimulationOptions &options, const Vector3 &start_m)
        : device_(description, options, start_m),
          rad_per_count_(device_.description().rad_per_count()) {
        for (std::size_t j = 0; j < 3; ++j) {
            const double theta_rad = device_.truth().theta_rad[static_cast<Eigen::Index>(j)];
            state_.counts[j] = static_cast<std::int32_t>(std::lround(theta_rad / rad_per_count_));
        }
    }

    void advance(const simulated::PlantCommand &command) override {
        state_ = device_.advance(command);
    }
    [[nodiscard]] Vector3 theta_rad() const override {
        return rad_per_count_ * Vector3(state_.counts[0], state_.counts[1], state_.counts[2]);
    }
    [[nodiscard]] Vector3 force_N() const override { return device_.truth().hand_force_N; }

private:
    simulated::SimulatedPhantom device_;
    double rad_per_count_;
    device::Measurement state_;
};

ChartPoint model_point(const rig::Scenario &press, const simulated::PlantModel &model, bool planar,
                       int sub_steps, const PressRecord &reference, int repeats) {
    const NewPlant new_plant = model_plant(press, model, planar, sub_steps);
    const PressRecord record = run_press(press, new_plant);
    ChartPoint point;
    point.method = std::string(model.name) + (planar ? ", planar" : "");
    point.setting =
        std::to_string(std::lround(press.simulation.servo_period_s / sub_steps * 1e6)) + " µs";
    point.error = force_error_N(record, reference);
    point.stable = std::isfinite(point.error);
    point.cost = press_cost(press, record, new_plant, sub_steps, repeats);
    return point;
}

} // namespace

NewPlant model_plant(const rig::Scenario &press, const simulated::PlantModel &model, bool planar,
                     int sub_steps) {
    simulated::SimulationOptions options;
    options.servo_period_s = press.simulation.servo_period_s;
    options.longest_step_s = press.simulation.servo_period_s / sub_steps;
    options.hand = press.simulation.hand;
    options.path = *press.simulation.path;
    options.dynamics = model.dynamics;
    options.effects = model.effects;
    options.planar = planar;
    return [description = press.device, options, start_m = press.start_m] {
        return std::make_unique<ModelPlant>(description, options, start_m);
    };
}

SpeedAccuracyChart plant_model_chart(const ChartSetting &setting, const ChartProgress &progress) {
    const rig::Scenario press = press_of(setting, rig::planar_press());
    const PressRecord reference = run_press(
        press, model_plant(press, simulated::kPlantModels.back(), false, kReferenceSubSteps));
    SpeedAccuracyChart chart;
    chart.name = "plant_models";
    chart.title = "Models of the plant in hard contact";
    chart.cost_label = "processor time per simulated millisecond";
    chart.error_label = "error of the force on the hand, r.m.s. against the full model at 1 µs (N)";
    double done = 0.0;
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        for (const bool planar : {true, false}) {
            for (const int sub_steps : kSubSteps) {
                chart.points.push_back(
                    model_point(press, model, planar, sub_steps, reference, setting.repeats));
            }
            progress(++done / (2.0 * simulated::kPlantModels.size()));
        }
    }
    return chart;
}

} // namespace springdrive::charts
