// Covers engine/record/telemetry_columns.h.
#include "engine/record/telemetry_columns.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <type_traits>

namespace springdrive::record {
namespace {

/// Addresses and sizes of the sample's members that are in the list.
std::map<const char *, std::size_t> places(const servo::ServoSample &sample) {
    std::map<const char *, std::size_t> found;
    for_each_column(sample, [&](std::string_view name, std::string_view, const auto &value) {
        const auto *const address = reinterpret_cast<const char *>(&value);
        EXPECT_TRUE(found.emplace(address, sizeof value).second) << name << " is listed twice";
    });
    return found;
}

TEST(TelemetryColumns, CoverEveryByteOfASampleExceptPaddingAndDocumentedExceptions) {
    // The command's number equals the measurement's; its reset and that it voids the zero concern
    // the device alone, a housing's temperature the next start. A failed assertion is a note.
    const servo::ServoSample sample;
    auto found = places(sample);
    const auto *const begin = reinterpret_cast<const char *>(&sample);
    found.emplace(reinterpret_cast<const char *>(&sample.command.number), sizeof(std::uint64_t));
    found.emplace(reinterpret_cast<const char *>(&sample.command.resets_faults), sizeof(bool));
    found.emplace(reinterpret_cast<const char *>(&sample.command.voids_zero), sizeof(bool));
    for (const servo::WindingStatus &winding : sample.winding) {
        found.emplace(reinterpret_cast<const char *>(&winding.max_housing_C), sizeof(double));
    }
    found.emplace(reinterpret_cast<const char *>(&sample.safety.failure), sizeof(AssertionFailure));
    found.emplace(begin + sizeof sample, 0);
    const char *at = begin;
    for (const auto &[address, bytes] : found) {
        EXPECT_GE(address, at) << "overlap";
        EXPECT_LT(address - at, 8) << "bytes " << at - begin << " to " << address - begin;
        at = address + bytes;
    }
}

// A small member could be hidden in padding. These bindings do not compile if one is added or
// removed: update the list first, then these.
TEST(TelemetryColumns, KnowEveryMember) {
    const servo::ServoSample sample;
    [[maybe_unused]] const auto &[tick, time, number, measured_at, arrival, health, faults, supply,
                                  since_last, counts, theta, rate, tip, contact, scene, tuning, eta,
                                  global_alpha, alpha, bound, x_Sd, theta_Sd, inverse_possible,
                                  carried, motor, command, current, force, rendered, inverse,
                                  transpose, safety, active_limits, limits, energy, winding, missed,
                                  in_a_row, missed_periods, clock, lateness, period, read, compute,
                                  write] = sample;
    [[maybe_unused]] const auto &[touching, x0, motion, normal, surface_eta, constraints, sticking,
                                  settled, surface, barycentric, triangle, material] = contact;
    [[maybe_unused]] const auto &[dR, K_P, K_D, lambda, by_hand, softness, map, mode] = tuning;
    [[maybe_unused]] const auto &[state, cause, measured, limit, ramp, failure, held_stop] = safety;
    [[maybe_unused]] const auto &[held_force, held_voltage, at_edge] = active_limits;
    [[maybe_unused]] const auto &[e_W, R_hat, command_mode, command_number, resets_faults,
                                  voids_zero] = command;
    [[maybe_unused]] const auto &[minimum, maximum, R_hat_limit, is_limited, is_contradicted,
                                  housing] = winding[0];
    [[maybe_unused]] const auto &[here, mean, k_T, offset, is_observed, is_trusted] = motor[0];
    [[maybe_unused]] const auto &[R, deviation] = here;
    EXPECT_EQ(sizeof limits, servo::kSafetyLimits.size() * sizeof(double));
}

/// The required ending of a name.
std::string ending_for(std::string_view unit) {
    const std::map<std::string_view, std::string> spelled{{"1", ""},
                                                          {"SI", ""},
                                                          {"s", "_s"},
                                                          {"rad", "_rad"},
                                                          {"rad/s", "_rad_per_s"},
                                                          {"m", "_m"},
                                                          {"m/s", "_m_per_s"},
                                                          {"V", "_V"},
                                                          {"A", "_A"},
                                                          {"N", "_N"},
                                                          {"J", "_J"},
                                                          {"Ω", "_Ohm"},
                                                          {"°C", "_C"},
                                                          {"N·m/A", "_Nm_per_A"},
                                                          {"V/rad", "_V_per_rad"},
                                                          {"V·s/rad", "_Vs_per_rad"},
                                                          {"rad²/m²", "_rad2_per_m2"}};
    const auto found = spelled.find(unit);
    return found == spelled.end() ? "unknown unit " + std::string(unit) : found->second;
}

TEST(TelemetryColumns, HaveValidNamesAndUnits) {
    std::set<std::string_view> names;
    const servo::ServoSample sample;
    for_each_column(sample, [&](std::string_view name, std::string_view unit, const auto &) {
        EXPECT_TRUE(names.insert(name).second) << name << " twice";
        EXPECT_TRUE(name.ends_with(ending_for(unit))) << name << " [" << unit << "]";
        EXPECT_LE(name.size(), 63U) << name;
        EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                         "0123456789_"),
                  std::string_view::npos)
            << name;
    });
    EXPECT_EQ(names.count("limit_beyond_stops_rad"), 1U);
}

double value_of(const servo::ServoSample &sample, std::string_view wanted) {
    double found = -1e9;
    for_each_column(sample, [&](std::string_view name, std::string_view, const auto &value) {
        if (name == wanted) {
            found = static_cast<double>(value);
        }
    });
    return found;
}

/// Above all those that could be swapped unnoticed: adjacent, of the same type and unit.
TEST(TelemetryColumns, MapToTheMemberOfTheirName) {
    servo::ServoSample sample;
    const std::map<std::string, double *> members{
        {"time_s", &sample.time_s},
        {"measured_s", &sample.measured_s},
        {"since_last_s", &sample.since_last_s},
        {"clock_s", &sample.clock_s},
        {"lateness_s", &sample.lateness_s},
        {"period_s", &sample.period_s},
        {"read_s", &sample.read_s},
        {"compute_s", &sample.compute_s},
        {"write_s", &sample.write_s},
        {"rendered_error_rad", &sample.rendered_error_rad},
        {"inverse_error_rad", &sample.inverse_error_rad},
        {"transpose_error_rad", &sample.transpose_error_rad},
        {"global_alpha_rad2_per_m2", &sample.global_alpha_rad2_per_m2},
        {"alpha_in_force_rad2_per_m2", &sample.alpha_rad2_per_m2},
        {"alpha_bound_rad2_per_m2", &sample.alpha_bound_rad2_per_m2},
        {"trip_measured", &sample.safety.measured},
        {"trip_limit", &sample.safety.limit},
        {"winding_least2_C", &sample.winding[1].min_C},
        {"winding_greatest2_C", &sample.winding[1].max_C},
        {"theta2_rad", &sample.theta_rad[1]},
        {"tip_y_m", &sample.tip_m[1]},
        {"proxy_z_m", &sample.contact.x0_m[2]},
        {"allowed_motion_xz", &sample.contact.tangent_projector(0, 2)},
        {"allowed_motion_zx", &sample.contact.tangent_projector(2, 0)},
        {"eta", &sample.tuning.eta},
        {"surface_eta", &sample.contact.eta},
        {"eta_in_force", &sample.eta},
        {"alpha_rad2_per_m2", &sample.tuning.alpha_rad2_per_m2},
        {"limit_window_silence_s", &sample.limits.window_silence_s},
        {"theta_Sd2_rad", &sample.theta_Sd_rad[1]},
        {"R2_Ohm", &sample.motor[1].here.resistance_Ohm},
        {"R2_deviation_Ohm", &sample.motor[1].here.deviation_Ohm},
        {"R_mean2_Ohm", &sample.motor[1].mean.resistance_Ohm},
        {"R_mean2_deviation_Ohm", &sample.motor[1].mean.deviation_Ohm},
        {"k_T2_Nm_per_A", &sample.motor[1].torque_constant_Nm_per_A},
        {"offset2_A", &sample.motor[1].offset_A},
        {"carried2_V", &sample.transfer_offset_V[1]},
        {"e_W2_V", &sample.command.e_W_V[1]},
    };
    double value = 0.0;
    for (const auto &[name, member] : members) {
        *member = ++value;
    }
    sample.counts = {-1, -2, -3};
    sample.winding[2].is_limited = true;
    sample.safety.cause = servo::TripCause::voltage;
    sample.missed_deadlines = 101;
    sample.missed_in_a_row = 102;
    sample.missed_periods = 103;
    for (const auto &[name, member] : members) {
        EXPECT_EQ(value_of(sample, name), *member) << name;
    }
    EXPECT_EQ(value_of(sample, "counts3"), -3.0);
    EXPECT_EQ(value_of(sample, "R_hat_limited3"), 1.0);
    EXPECT_EQ(value_of(sample, "R_hat_limited1"), 0.0);
    EXPECT_EQ(value_of(sample, "trip_cause"), static_cast<double>(servo::TripCause::voltage));
    EXPECT_EQ(value_of(sample, "missed_deadlines"), 101.0);
    EXPECT_EQ(value_of(sample, "missed_in_a_row"), 102.0);
    EXPECT_EQ(value_of(sample, "missed_periods"), 103.0);
}

} // namespace
} // namespace springdrive::record
