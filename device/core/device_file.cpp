#include "device/core/device_file.h"

#include "base/degrees.h"
#include "base/strict_toml.h"
#include "device/core/calibration_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace springdrive::device {

namespace {

// The ranges reject impossible values and wrong units (millimetres for metres, degrees for radians,
// g·cm² for kg·m²); every known device lies well within them.
MotorParameters read_motor(StrictTomlTable &table) {
    MotorParameters motor;
    motor.resistance_Ohm = table.number("resistance_Ohm", {0.01, 1000.0});
    motor.inductance_H = table.number("inductance_H", {1e-6, 0.1});
    motor.torque_constant_Nm_per_A = table.number("torque_constant_Nm_per_A", {1e-4, 10.0});
    motor.rotor_inertia_kg_m2 = table.number("rotor_inertia_kg_m2", {1e-9, 1e-2});
    motor.supply_V = table.number("supply_V", {0.1, 100.0});
    motor.peak_current_A = table.number("peak_current_A", {0.01, 100.0});
    motor.resistance_rise_per_K = table.number("resistance_rise_per_K", {0.0, 0.01});
    motor.commutation_ripple = table.number("commutation_ripple", {0.0, 0.5});
    motor.commutator_segments = table.integer("commutator_segments", 1, 1000);
    motor.thermal.winding_housing_K_per_W = table.number("winding_housing_K_per_W", {0.01, 1000.0});
    motor.thermal.housing_ambient_K_per_W = table.number("housing_ambient_K_per_W", {0.01, 1000.0});
    motor.thermal.winding_time_s = table.number("winding_time_s", {0.1, 1e4});
    motor.thermal.motor_time_s = table.number("motor_time_s", {1.0, 1e5});
    motor.thermal.max_winding_C = table.number("greatest_winding_C", {40.0, 300.0});
    // Not in older files, as records hold them.
    if (table.has("resistance_tolerance")) {
        motor.resistance_tolerance = table.number("resistance_tolerance", {0.0, 0.5});
    }
    if (table.has("torque_constant_tolerance")) {
        motor.torque_constant_tolerance = table.number("torque_constant_tolerance", {0.0, 0.5});
    }
    table.refuse_unknown_keys();
    return motor;
}

CurrentSensing read_current_sensing(StrictTomlTable table) {
    CurrentSensing sensing;
    sensing.resolution_A = table.number("resolution_A", {0.0, 1.0});
    sensing.noise_A = table.number("noise_A", {0.0, 1.0});
    sensing.max_offset_A = table.number("greatest_offset_A", {0.0, 1.0});
    sensing.gain_tolerance = table.number("gain_tolerance", {0.0, 0.2});
    sensing.is_shared = table.integer("shared_with_amplifier", 0, 1) == 1;
    table.refuse_unknown_keys();
    return sensing;
}

PhantomGeometry read_geometry(StrictTomlTable linkage) {
    PhantomGeometry geometry;
    geometry.upper_arm_m = linkage.number("upper_arm_m", {0.01, 2.0});
    geometry.forearm_m = linkage.number("forearm_m", {0.01, 2.0});
    geometry.crank_m = linkage.number("crank_m", {0.001, 1.0});
    geometry.transmission_ratio = linkage.vector("transmission_ratio", {0.1, 1000.0});
    linkage.refuse_unknown_keys();
    return geometry;
}

/// What a link's inertia refers to.
enum class About : std::uint8_t { joint, centre };

LinkBody read_body(StrictTomlTable table, About about) {
    LinkBody body;
    body.mass_kg = table.number("mass_kg", {1e-4, 10.0});
    body.centre_m = table.number("centre_m", {-1.0, 1.0});
    body.inertia_kg_m2 = table.vector("inertia_kg_m2", {1e-10, 1.0});
    // About a joint the inertia is at least that of the point mass. (The triangle inequality of the
    // moments is not checked: published values violate it.)
    const double min_kg_m2 =
        about == About::joint ? body.mass_kg * body.centre_m * body.centre_m : 0.0;
    if (std::min(body.inertia_kg_m2[0], body.inertia_kg_m2[1]) < min_kg_m2) {
        table.refuse(
            "inertia_kg_m2",
            fmt::format("is too small for a mass at that distance from the joint; its first two "
                        "numbers must be at least mass_kg times centre_m squared, {:g}",
                        min_kg_m2));
    }
    table.refuse_unknown_keys();
    return body;
}

LinkageInertia read_inertia(StrictTomlTable table) {
    LinkageInertia inertia;
    inertia.base_kg_m2 = table.number("base_kg_m2", {1e-7, 1.0});
    inertia.upper_arm = read_body(table.table("upper_arm"), About::joint);
    inertia.crank = read_body(table.table("crank"), About::joint);
    inertia.rod = read_body(table.table("rod"), About::centre);
    inertia.forearm = read_body(table.table("forearm"), About::centre);
    inertia.tip_load_kg = table.number("tip_load_kg", {0.0, 5.0});
    table.refuse_unknown_keys();
    return inertia;
}

JointFriction read_friction(StrictTomlTable table) {
    JointFriction friction;
    friction.viscous_Nms_per_rad = table.number("viscous_Nms_per_rad", {0.0, 1.0});
    friction.coulomb_Nm = table.vector("coulomb_Nm", {0.0, 1.0});
    table.refuse_unknown_keys();
    return friction;
}

JointLimits read_joint_limits(StrictTomlTable table) {
    JointLimits limits;
    limits.min_rad = kRadiansPerDegree * table.vector("lowest_deg", {-180.0, 0.0});
    limits.max_rad = kRadiansPerDegree * table.vector("highest_deg", {0.0, 270.0});
    limits.min_q3_minus_q2_rad =
        kRadiansPerDegree * table.number("least_q3_minus_q2_deg", {-89.0, 0.0});
    limits.max_q3_minus_q2_rad =
        kRadiansPerDegree * table.number("greatest_q3_minus_q2_deg", {0.0, 89.0});
    table.refuse_unknown_keys();
    return limits;
}

WorkspaceEdge read_edge(StrictTomlTable table) {
    WorkspaceEdge edge;
    edge.margin_rad = kRadiansPerDegree * table.number("margin_deg", {0.0, 30.0});
    edge.stiffness_Nm_per_rad = table.number("stiffness_Nm_per_rad", {0.0, 100.0});
    edge.damping_Nms_per_rad = table.number("damping_Nms_per_rad", {0.0, 10.0});
    table.refuse_unknown_keys();
    return edge;
}

constexpr double kSecondsPerMillisecond = 1e-3;

DeviceLimits read_limits(StrictTomlTable table) {
    DeviceLimits limits;
    limits.tip_force_N = table.number("tip_force_N", {0.1, 100.0});
    limits.tip_speed_m_per_s = table.number("tip_speed_m_per_s", {0.01, 20.0});
    limits.beyond_stops_rad = kRadiansPerDegree * table.number("beyond_stops_deg", {0.1, 45.0});
    limits.generated_energy_J = table.number("generated_energy_J", {1e-4, 10.0});
    if (table.has("missed_deadlines")) { // older files: periods at 1 kHz
        if (table.has("late_ms") || table.has("stale_ms")) {
            table.refuse("missed_deadlines", "was replaced by late_ms; remove it");
        }
        limits.late_s = kSecondsPerMillisecond * table.integer("missed_deadlines", 1, 10'000);
        limits.stale_s = 5e-3;
    } else {
        limits.late_s = kSecondsPerMillisecond * table.number("late_ms", {0.1, 1e4});
        limits.stale_s = kSecondsPerMillisecond * table.number("stale_ms", {0.1, 1e4});
    }
    limits.window_silence_s = table.number("window_silence_s", {0.05, 60.0});
    table.refuse_unknown_keys();
    return limits;
}

StructuralCompliance read_structure(StrictTomlTable table) {
    StructuralCompliance structure;
    structure.stiffness_N_per_m = table.number("stiffness_N_per_m", {10.0, 1e7});
    structure.damping_Ns_per_m = table.number("damping_Ns_per_m", {0.0, 1e4});
    table.refuse_unknown_keys();
    return structure;
}

AmplifierParameters read_amplifier(StrictTomlTable table,
                                   const std::array<MotorParameters, 3> &motors) {
    AmplifierParameters amplifier;
    // R̂ may exceed R by as much as a warm winding's R does, at most by the excess that the file
    // allows.
    const double excess_Ohm = table.number("greatest_excess_Ohm", {0.0, 100.0});
    double min_resistance_Ohm = std::numeric_limits<double>::infinity();
    for (const MotorParameters &motor : motors) {
        min_resistance_Ohm = std::min(min_resistance_Ohm, motor.resistance_Ohm);
    }
    amplifier.max_cancelled_Ohm =
        table.number("greatest_cancelled_Ohm", {0.0, min_resistance_Ohm + excess_Ohm});
    amplifier.current_bandwidth_hz = table.number("current_bandwidth_hz", {1.0, 1e6});
    table.refuse_unknown_keys();
    return amplifier;
}

DeviceDescription read_device(StrictTomlTable file) {
    DeviceDescription device;
    device.name = file.text("name");

    device.geometry = read_geometry(file.table("linkage"));
    device.inertia = read_inertia(file.table("inertia"));
    device.friction = read_friction(file.table("friction"));
    device.joint_limits = read_joint_limits(file.table("joint_limits"));
    device.structure = read_structure(file.table("structure"));

    const int motors = file.tables("motor", 3, [&device](int index, StrictTomlTable &table) {
        device.motor[static_cast<std::size_t>(index)] = read_motor(table);
    });
    if (motors == 1) {
        device.motor.fill(device.motor.front());
    }
    device.amplifier = read_amplifier(file.table("amplifier"), device.motor);

    if (file.has("current_sensing")) { // not in older files
        device.current_sensing = read_current_sensing(file.table("current_sensing"));
    }

    StrictTomlTable encoder = file.table("encoder");
    device.encoder_counts_per_turn = encoder.integer("counts_per_turn", 4, 100'000);
    encoder.refuse_unknown_keys();

    StrictTomlTable workspace = file.table("workspace");
    device.workspace.centre_m = workspace.vector("centre_m", {-2.0, 2.0});
    device.workspace.size_m = workspace.vector("size_m", {0.01, 2.0});
    if (!can_reach(device, device.workspace.centre_m)) {
        workspace.refuse("centre_m", "is out of reach; it must be a point that the tip can be at, "
                                     "within linkage and joint_limits");
    }
    workspace.refuse_unknown_keys();

    device.edge = read_edge(file.table("edge"));
    device.limits = read_limits(file.table("limits"));
    if (file.has("calibration")) {
        device.calibration = read_calibration(file.table("calibration"), device);
    }

    file.refuse_unknown_keys();
    return device;
}

} // namespace

DeviceDescription read_device_file(const std::filesystem::path &path) {
    return read_device(StrictTomlTable::read(path));
}

DeviceDescription read_device_text(const std::string &text, const std::filesystem::path &path) {
    return read_device(StrictTomlTable::parse(text, path));
}

} // namespace springdrive::device
