#include "device/device_file.h"

#include "base/strict_toml.h"
#include "device/phantom/kinematics.h"

namespace springdrive {

namespace {

// Ranges keep out slips of unit (millimetres for metres, degrees for radians, g·cm² for kg·m²)
// and what cannot be; they are wide of every device we know.
MotorParameters read_motor(StrictTomlTable &table) {
    MotorParameters motor;
    motor.resistance_Ohm = table.number("resistance_Ohm", {0.01, 1000.0});
    motor.inductance_H = table.number("inductance_H", {1e-6, 0.1});
    motor.torque_constant_Nm_per_A = table.number("torque_constant_Nm_per_A", {1e-4, 10.0});
    motor.rotor_inertia_kg_m2 = table.number("rotor_inertia_kg_m2", {1e-9, 1e-2});
    motor.supply_V = table.number("supply_V", {0.1, 100.0});
    motor.peak_current_A = table.number("peak_current_A", {0.01, 100.0});
    table.refuse_unknown_keys();
    return motor;
}

PhantomGeometry read_geometry(StrictTomlTable &linkage) {
    PhantomGeometry geometry;
    geometry.upper_arm_m = linkage.number("upper_arm_m", {0.01, 2.0});
    geometry.forearm_m = linkage.number("forearm_m", {0.01, 2.0});
    geometry.transmission_ratio = linkage.vector("transmission_ratio", {0.1, 1000.0});
    return geometry;
}

} // namespace

DeviceDescription read_device_file(const std::filesystem::path &path) {
    StrictTomlTable file = StrictTomlTable::read(path);
    DeviceDescription device;
    device.name = file.text("name");

    StrictTomlTable linkage = file.table("linkage");
    device.geometry = read_geometry(linkage);
    device.joint_damping_Nms_per_rad = linkage.number("joint_damping_Nms_per_rad", {0.0, 1.0});
    device.tip_mass_kg = linkage.number("tip_mass_kg", {1e-3, 10.0});
    linkage.refuse_unknown_keys();

    const int motors = file.tables("motor", 3, [&device](int index, StrictTomlTable &table) {
        device.motor[static_cast<std::size_t>(index)] = read_motor(table);
    });
    if (motors == 1) {
        device.motor.fill(device.motor.front());
    }

    StrictTomlTable encoder = file.table("encoder");
    device.encoder_counts_per_turn = encoder.integer("counts_per_turn", 4, 100'000);
    encoder.refuse_unknown_keys();

    StrictTomlTable workspace = file.table("workspace");
    device.workspace.centre_m = workspace.vector("centre_m", {-2.0, 2.0});
    device.workspace.size_m = workspace.vector("size_m", {0.01, 2.0});
    if (!joint_angles_rad(device.geometry, device.workspace.centre_m)) {
        workspace.refuse("centre_m", "is out of reach; it must be a point that the tip can reach");
    }
    workspace.refuse_unknown_keys();

    StrictTomlTable limits = file.table("limits");
    device.limits.tip_force_N = limits.number("tip_force_N", {0.1, 100.0});
    device.limits.tip_speed_m_per_s = limits.number("tip_speed_m_per_s", {0.01, 20.0});
    limits.refuse_unknown_keys();

    file.refuse_unknown_keys();
    return device;
}

} // namespace springdrive
