#include "engine/lab/rig/law_rig.h"

#include "engine/control/motion_control.h"

#include <cstddef>
#include <utility>

namespace springdrive::rig {

PhantomPlant::PhantomPlant(simulated::SimulatedPhantom &phantom, bool has_counts)
    : phantom_(phantom), has_counts_(has_counts), theta_rad_(phantom.truth().theta_rad) {}

void PhantomPlant::advance(const simulated::PlantCommand &command) {
    const std::array<std::int32_t, 3> counts = phantom_.advance(command).counts;
    theta_rad_ = has_counts_ ? Vector3(phantom_.description().rad_per_count() *
                                       Vector3(counts[0], counts[1], counts[2]))
                             : phantom_.truth().theta_rad;
}

LawRig::LawRig(Plant &plant, const LawOptions &options, Constraint constraint, FirstCommand first)
    : plant_(plant), options_(options), constraint_(std::move(constraint)), law_(options.device),
      pole_(control::velocity_filter_pole(options.tuning.lambda_rad_per_s, options.period_s)),
      filter_(options.rests_at_rad.value_or(plant.theta_rad()), Vector3::Zero()) {
    if (options.global_alpha_rad2_per_m2) {
        global_alpha_rad2_per_m2_ = *options.global_alpha_rad2_per_m2;
    } else if (options.tuning.alpha_mode == control::AlphaMode::global) {
        global_alpha_rad2_per_m2_ = control::global_alpha_bound(options.device);
    }
    if (first == FirstCommand::answers) {
        answer();
    }
}

void LawRig::tick() {
    plant_.advance(command_);
    answer();
}

void LawRig::answer() {
    const Vector3 theta_rad = plant_.theta_rad();
    command_ = {device::DeviceCommand::braking(), Vector3::Zero()};
    if (!(theta_rad.norm() < options_.max_turn_rad)) { // true for a NaN
        return;
    }
    configuration_ =
        law_.configuration(theta_rad, filter_.update(theta_rad, pole_, options_.period_s));
    contact_ = constraint_(configuration_.tip_m);
    if (options_.drive == device::AmplifierKind::current_drive) {
        command_.current_A = current_A();
    } else {
        command_.spring_drive = spring_drive();
    }
}

device::DeviceCommand LawRig::spring_drive() const {
    device::DeviceCommand command =
        law_(configuration_, contact_, options_.tuning, {global_alpha_rad2_per_m2_}).command;
    if (options_.net_resistance_Ohm) {
        for (std::size_t j = 0; j < 3; ++j) {
            command.cancelled_resistance_Ohm[static_cast<Eigen::Index>(j)] =
                options_.device.motor[j].resistance_Ohm - *options_.net_resistance_Ohm;
        }
    }
    return command;
}

Vector3 LawRig::current_A() const {
    const Vector3 force_N =
        control::wall_force_N(options_.wall, configuration_, contact_, options_.tuning.eta);
    return Vector3(configuration_.J.transpose() * force_N).cwiseQuotient(law_.k_T());
}

} // namespace springdrive::rig
