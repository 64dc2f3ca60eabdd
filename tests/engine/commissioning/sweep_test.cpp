// Covers engine/commissioning/sweep.cpp: on the simulated device, whose stiffness its own truth
// tells while a hand shakes it, and on emulated boards.
#include "engine/commissioning/sweep.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/haptic_device.h"
#include "device/core/phantom/kinematics.h"
#include "device/factory/device_factory.h"
#include "device/simulated/plant_setup.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/control/rendered_force.h"
#include "tests/support/devices.h"
#include "tests/support/tunings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace springdrive::commissioning {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Amplitudes at one frequency of what truly happens between the samples, too.
class TrueAmplitudes {
public:
    TrueAmplitudes(double frequency_hz, double duration_s)
        : omega_rad_per_s_(2.0 * pi * frequency_hz), left_s_(duration_s) {}

    void take(const simulated::SimulatedPhantom::Truth &truth, double step_s) {
        if (left_s_ < 0.5 * step_s) {
            return;
        }
        left_s_ -= step_s;
        const Complex back = std::polar(1.0, -omega_rad_per_s_ * truth.time_s);
        current_ += back * truth.current_A.cast<Complex>();
        theta_ += back * (truth.theta_rad - middle_rad(truth)).cast<Complex>();
    }

    [[nodiscard]] bool is_over() const { return left_s_ < 1e-3 * period_s(); }
    [[nodiscard]] double period_s() const { return 2.0 * pi / omega_rad_per_s_; }

    /// −τ/θ of a motor.
    [[nodiscard]] Complex stiffness(Eigen::Index motor, double k_T) const {
        return -k_T * current_[motor] / theta_[motor];
    }

private:
    /// A constant takes no part in whole periods, but in their round-off.
    Vector3 middle_rad(const simulated::SimulatedPhantom::Truth &truth) {
        first_rad_ = first_rad_.value_or(truth.theta_rad);
        return *first_rad_;
    }

    double omega_rad_per_s_;
    double left_s_;
    std::optional<Vector3> first_rad_;
    Eigen::Vector3cd current_{Eigen::Vector3cd::Zero()};
    Eigen::Vector3cd theta_{Eigen::Vector3cd::Zero()};
};

struct Simulation {
    device::DeviceDescription truth = testing::phantom_1_0();
    simulated::PlantEffects effects = simulated::PlantEffects::none();
    bool counts = false; ///< with the encoders' own counts; otherwise 10,000 times as many
    double delay_periods = 0.3;
    std::optional<double> stated_delay; ///< what the device takes d for
    double period_s = 1e-3;
};

/// The simulated device, looked at forty times in a period of the servo: its commands act at their
/// own times, and its truth is seen in between.
struct FinePhantom {
    static constexpr int kSteps = 40;

    explicit FinePhantom(const Simulation &simulation)
        : phantom(simulation.truth, options_of(simulation), Vector3::Zero()) {}

    static simulated::SimulationOptions options_of(const Simulation &simulation) {
        simulated::SimulationOptions options;
        options.effects = simulation.effects;
        options.quantised_encoders = simulation.counts;
        options.servo_period_s = simulation.period_s / kSteps;
        return options;
    }

    simulated::SimulatedPhantom phantom;
};

class FineDevice final : public FinePhantom, public device::ForwardingDevice {
public:
    explicit FineDevice(const Simulation &simulation)
        : FinePhantom(simulation), device::ForwardingDevice(phantom), simulation_(simulation),
          file_(testing::phantom_1_0()) {
        file_.encoder_counts_per_turn = phantom.description().encoder_counts_per_turn;
        written_.fill(device::DeviceCommand::braking());
    }

    [[nodiscard]] const device::DeviceDescription &description() const override { return file_; }
    [[nodiscard]] double delay_periods() const override {
        return simulation_.stated_delay.value_or(simulation_.delay_periods);
    }
    void set_period(double period_s) override {
        simulation_.period_s = period_s;
        phantom.set_period(period_s / kSteps);
    }
    [[nodiscard]] device::Measurement read() noexcept override {
        const auto whole = static_cast<std::size_t>(simulation_.delay_periods);
        const long switches =
            std::lround((simulation_.delay_periods - static_cast<double>(whole)) * kSteps);
        device::Measurement measured;
        for (int step = 0; step < kSteps; ++step) {
            measured = phantom.advance(written_[step < switches ? whole + 1 : whole]);
            if (watched != nullptr) {
                watched->take(phantom.truth(), simulation_.period_s / kSteps);
            }
        }
        measured.number = ++number_;
        return measured;
    }
    void write(const device::DeviceCommand &command) noexcept override {
        std::shift_right(written_.begin(), written_.end(), 1);
        written_.front() = command;
    }

    TrueAmplitudes *watched = nullptr;

private:
    Simulation simulation_;
    device::DeviceDescription file_;
    std::array<device::DeviceCommand, 10> written_{};
    std::uint64_t number_ = 0;
};

SweepReport swept(device::HapticDevice &device, const SweepOptions &options) {
    StiffnessSweep sweep(device, options);
    while (sweep.step()) {
    }
    return sweep.report();
}

/// −τ/θ of each motor while a hand shakes the tip, and nothing else does.
std::array<Complex, 3> shaken(const Simulation &simulation, const SweepOptions &options,
                              double frequency_hz) {
    FineDevice device(simulation);
    servo::Servo servo(device, options.servo_hz);
    servo.set_rate(options.servo_hz);
    servo::ServoInputs inputs;
    inputs.tuning = options.tuning;
    inputs.tuning.map = control::MotionMap::inverse;
    servo::ServoSample last;
    const auto advance = [&](double seconds) {
        const int ticks = static_cast<int>(std::lround(seconds * options.servo_hz));
        for (int i = 0; i < ticks; ++i) {
            servo.publish(inputs);
            servo.advance(1);
            servo.drain([&](const servo::ServoSample &sample) { last = sample; });
        }
    };
    advance(1.5);
    EXPECT_EQ(last.safety.state, servo::SafetyState::running);
    inputs.fixed_x0_m = last.tip_m;
    advance(0.5);
    std::vector<simulated::HandPath::Point> points;
    const Vector3 amplitude_m = 2e-3 * Vector3::Ones();
    const int all = 8000;
    for (int i = 0; i < all; ++i) {
        const double t = 5e-4 * i;
        points.push_back({t, amplitude_m * std::sin(2.0 * pi * frequency_hz * t)});
    }
    device.phantom.follow(simulated::HandPath(points));
    advance(1.0);
    const double whole_s = std::ceil(2.0 * frequency_hz) / frequency_hz;
    TrueAmplitudes amplitudes(frequency_hz, whole_s);
    device.watched = &amplitudes;
    advance(whole_s + 0.01);
    EXPECT_TRUE(amplitudes.is_over());
    EXPECT_EQ(last.safety.state, servo::SafetyState::running);
    std::array<Complex, 3> found;
    for (std::size_t motor = 0; motor < 3; ++motor) {
        found[motor] = amplitudes.stiffness(static_cast<Eigen::Index>(motor),
                                            simulation.truth.motor[motor].torque_constant_Nm_per_A);
    }
    return found;
}

SweepOptions quick(std::vector<std::size_t> motors = {1}) {
    SweepOptions options;
    options.motors = std::move(motors);
    options.min_hz = 8.0;
    options.points = 3;
    options.observes_resistance = false;
    return options;
}

/// Expects what was measured to be what a shaken device shows, within a share and as many
/// hundredths of a radian.
void expect_as_shaken(const Simulation &simulation, const SweepOptions &options, double tolerance) {
    FineDevice device(simulation);
    const SweepReport report = swept(device, options);
    ASSERT_TRUE(report.is_certain()) << report.problem;
    ASSERT_EQ(report.motors.size(), options.motors.size());
    for (const SweepPoint &point : report.motors.front().points) {
        const std::array<Complex, 3> truth = shaken(simulation, options, point.frequency_hz);
        const Complex error = point.measured_Nm_per_rad / truth[report.motors.front().motor] - 1.0;
        EXPECT_LT(std::abs(error), tolerance)
            << point.frequency_hz << " Hz: measured " << point.measured_Nm_per_rad << ", shaken "
            << truth[report.motors.front().motor];
    }
}

// A rotor's damper and spring between samples, round-off of 10,000 counts: 0.05 % was found.
constexpr double kAgreement = 1e-3;

TEST(StiffnessSweep, AgreesWithADeviceThatAHandShakes) {
    expect_as_shaken({}, quick(), kAgreement);
    Simulation slow;
    slow.period_s = 4e-3;
    SweepOptions options = quick({0});
    options.servo_hz = 250.0;
    options.min_hz = 3.0;
    expect_as_shaken(slow, options, kAgreement);
}

TEST(StiffnessSweep, ShowsTheDevicesOwnWindingsNotTheFiles) {
    Simulation other;
    other.truth.motor[1].resistance_Ohm *= 1.04; // dR 0.587 instead of 0.5
    other.truth.motor[1].inductance_H *= 1.5;
    expect_as_shaken(other, quick(), kAgreement);
    FineDevice device(other);
    const SweepReport report = swept(device, quick());
    const MotorSweep &sweep = report.motors.front();
    EXPECT_NEAR(sweep.winding.dR_Ohm, 0.5 + 0.04 * 2.18, 0.004);
    EXPECT_NEAR(sweep.winding.inductance_H, 1.5 * 0.238e-3, 0.03e-3);
    // 15 % at low frequency, by dR.
    EXPECT_NEAR(sweep.points.front().magnitude_error(), 0.5 / sweep.winding.dR_Ohm - 1.0, 0.03);
    EXPECT_FALSE(report.is_within(0.1, 0.5));
    EXPECT_TRUE(report.is_within(0.25, 0.5));
}

TEST(StiffnessSweep, AgreesWithThePredictionInCounts) {
    Simulation in_counts;
    in_counts.counts = true;
    FineDevice device(in_counts);
    SweepOptions options = quick({0, 2});
    const SweepReport report = swept(device, options);
    ASSERT_TRUE(report.is_certain()) << report.problem;
    // Half a percent and a third of a degree: rounding of motions of two counts, and deviations.
    EXPECT_TRUE(report.is_within(0.006, 0.006));
    EXPECT_EQ(report.discarded_blocks, 0U);
    EXPECT_TRUE(report.warnings.empty());
    ASSERT_EQ(report.motors.size(), 2U);
    EXPECT_EQ(report.motors[1].motor, 2U);
    ASSERT_EQ(report.motors[1].points.size(), 3U);
    EXPECT_NEAR(report.motors[1].points.front().frequency_hz, 8.0, 0.02 * 8.0);
    EXPECT_NEAR(report.motors[1].points.back().frequency_hz, 100.0, 0.005 * 100.0);
    EXPECT_LE(report.motors[1].points.back().frequency_hz, 100.0);
}

TEST(StiffnessSweep, AnotherDelayThanTheStatedOneShowsInThePhase) {
    Simulation late;
    late.delay_periods = 0.8;
    late.stated_delay = 0.3;
    FineDevice device(late);
    const SweepReport report = swept(device, quick());
    // Half a period at 100 Hz is 18° of the law's share.
    const SweepPoint &highest = report.motors.front().points.back();
    EXPECT_LT(highest.phase_error_rad(), -5.0 * kRadiansPerDegree);
    EXPECT_FALSE(report.is_within(0.02, 2.0 * kRadiansPerDegree));
    late.stated_delay.reset(); // and the device's own prediction holds
    FineDevice known(late);
    EXPECT_TRUE(swept(known, quick()).is_within(0.006, 0.006));
}

/// A device whose commands, forces and tip are watched, and whose cable can be cut.
class WatchedDevice final : public device::ForwardingDevice {
public:
    explicit WatchedDevice(device::HapticDevice &device)
        : device::ForwardingDevice(device), k_T_(control::torque_constants(device.description())) {}

    [[nodiscard]] device::Measurement read() noexcept override {
        device::Measurement measured = device::ForwardingDevice::read();
        if (measured.time_s > cut_s) {
            measured.arrival = device::Arrival::absent;
            measured.health = device::DeviceHealth::lost;
        }
        const double rad = description().rad_per_count();
        const Vector3 theta_rad =
            rad * Vector3(measured.counts[0], measured.counts[1], measured.counts[2]);
        const Vector3 q_rad = device::joint_from_motor(description().geometry, theta_rad);
        const Matrix3 J = device::motor_jacobian(description().geometry, q_rad);
        largest_N =
            std::max(largest_N, control::static_tip_force(J, k_T_, measured.current_A).norm());
        const Vector3 tip_m = device::tip_position_m(description().geometry, q_rad);
        largest_m = std::max(largest_m, (tip_m - held_m).norm());
        return measured;
    }
    void write(const device::DeviceCommand &command) noexcept override {
        last = command;
        device::ForwardingDevice::write(command);
    }
    [[nodiscard]] bool is_zeroed() const override {
        return is_known && device::ForwardingDevice::is_zeroed();
    }

    double cut_s = std::numeric_limits<double>::infinity();
    bool is_known = true;
    Vector3 held_m{Vector3::Zero()};
    double largest_N = 0.0;
    double largest_m = 0.0;
    device::DeviceCommand last;

private:
    Vector3 k_T_;
};

/// An emulated board with every effect of the simulation.
factory::OpenBoard board(const std::vector<const char *> &faults = {}, std::uint64_t seed = 0) {
    factory::BoardRequest request;
    request.description = testing::phantom_without_brushes(); // else R takes a calibration
    request.truth = request.description;
    request.emulation.start_tip_m = Vector3::Zero();
    request.emulation.simulation.device_seed = seed;
    for (const char *fault : faults) {
        request.emulation.faults.push_back(device::parse_fault(fault));
    }
    factory::OpenBoard open = factory::open_board(request);
    open.device->zero(Vector3::Zero());
    return open;
}

TEST(StiffnessSweep, ABoardRendersWhatIsPredictedWithItsMeasuredDelay) {
    const factory::OpenBoard open = board();
    SweepOptions options = quick({0, 1, 2});
    options.min_hz = 2.0;
    options.observes_resistance = true; // R here is 2 % above the file's, by the commutator
    const SweepReport report = swept(*open.device, options);
    ASSERT_TRUE(report.is_certain()) << report.problem;
    EXPECT_TRUE(report.is_within(0.02, 2.0 * kRadiansPerDegree)); // as promised
    for (const MotorSweep &sweep : report.motors) {
        // The board's own clock knows d to a microsecond: 12.5 loops of 25 µs.
        EXPECT_NEAR(sweep.points.back().delay_periods, 0.3125, 0.001);
        EXPECT_NEAR(sweep.winding.dR_Ohm, 0.5, 0.01);
    }
}

TEST(StiffnessSweep, AStiffTuningIsMeasuredThroughItsResonance) {
    // Where the hand takes up much energy, and a volt makes much force.
    const factory::OpenBoard open = board();
    SweepOptions options = quick();
    options.tuning = testing::tuning("stable_only_1kHz");
    const double dR_Ohm = 0.32; // which no winding guard holds up
    options.tuning.K_P_V_per_rad *= dR_Ohm / options.tuning.dR_Ohm; // the same static stiffness
    options.tuning.dR_Ohm = dR_Ohm;
    options.min_hz = 12.0;
    options.points = 6;
    options.observes_resistance = true;
    const SweepReport report = swept(*open.device, options);
    ASSERT_TRUE(report.is_certain()) << report.problem;
    EXPECT_TRUE(report.is_within(0.02, 2.0 * kRadiansPerDegree));
}

TEST(StiffnessSweep, StaysWithinItsLimits) {
    for (const double limit_N : {4.0, 1.5}) {
        const factory::OpenBoard open = board({}, 2);
        WatchedDevice device(*open.device);
        SweepOptions options = quick({0, 1});
        options.tip_force_N = limit_N;
        options.motion_m = 6e-4;
        const SweepReport report = swept(device, options);
        ASSERT_TRUE(report.is_complete) << report.problem;
        EXPECT_LT(device.largest_N, 0.85 * limit_N);
        EXPECT_GT(device.largest_N, 0.2 * limit_N); // and uses them
        // An amplitude of up to 1.25 times, dither, and where the hand lets the tip drift.
        EXPECT_LT(device.largest_m, 2.5 * options.motion_m);
        EXPECT_TRUE(limit_N < 4.0 || device.largest_m > 0.5 * options.motion_m);
    }
}

TEST(StiffnessSweep, AStopOrACutCableEndsItWithALineAndBraking) {
    constexpr double kNever_s = std::numeric_limits<double>::infinity();
    struct Case {
        std::vector<const char *> faults;
        double cut_s;
        const char *says;
        std::size_t points; ///< that were measured, at least
    };
    for (const Case &one : {Case{{"stop@6"}, kNever_s, "stop switch", 1},
                            Case{{}, 0.5, "does not answer", 0}, // while it rests
                            Case{{}, 4.0, "does not answer", 0}}) {
        const factory::OpenBoard open = board(one.faults);
        WatchedDevice device(*open.device);
        device.cut_s = one.cut_s;
        StiffnessSweep sweep(device, quick());
        while (sweep.step()) {
        }
        const SweepReport report = sweep.report();
        EXPECT_FALSE(report.is_complete);
        EXPECT_NE(report.problem.find(one.says), std::string::npos) << report.problem;
        EXPECT_EQ(report.problem.find('\n'), std::string::npos);
        EXPECT_EQ(device.last.mode, device::CommandMode::brake);
        EXPECT_FALSE(sweep.step()); // and that is all
        const std::size_t points = report.motors.empty() ? 0 : report.motors[0].points.size();
        EXPECT_GE(points, one.points) << one.says; // what was measured stays
        EXPECT_LT(points, 3U);
    }
}

TEST(StiffnessSweep, StoppingBrakes) {
    const factory::OpenBoard open = board();
    WatchedDevice device(*open.device);
    StiffnessSweep sweep(device, quick());
    while (sweep.stage() != SweepStage::measuring) {
        ASSERT_TRUE(sweep.step());
    }
    for (int i = 0; i < 500; ++i) {
        ASSERT_TRUE(sweep.step());
    }
    EXPECT_EQ(device.last.mode, device::CommandMode::drive);
    sweep.stop();
    EXPECT_EQ(device.last.mode, device::CommandMode::brake);
    EXPECT_FALSE(sweep.step());
    EXPECT_FALSE(sweep.report().is_complete);
    EXPECT_EQ(sweep.report().problem, "");
}

TEST(StiffnessSweep, AFaultBeforeTheStartIsResetAndLostReportsDoNotDisturb) {
    const factory::OpenBoard open = board({"stop@0-0.08", "drop:in:0.002"});
    SweepOptions options = quick();
    options.points = 2;
    options.observes_resistance = true;
    const SweepReport report = swept(*open.device, options);
    ASSERT_TRUE(report.is_complete) << report.problem;
    EXPECT_GT(report.discarded_blocks, 0U);
    EXPECT_TRUE(report.is_within(0.02, 2.0 * kRadiansPerDegree));
}

TEST(StiffnessSweep, RefusesOptionsBeyondTheirRanges) {
    const factory::OpenBoard open = board();
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const auto error = [&](const std::function<void(SweepOptions &)> &change) {
        SweepOptions options;
        change(options);
        return error_text_of([&] { const StiffnessSweep sweep(*open.device, options); });
    };
    const auto set = [&](auto member, const auto &value) {
        return error([&](SweepOptions &options) { options.*member = value; });
    };
    EXPECT_EQ(error([](SweepOptions &) {}), "");
    for (const auto &[value, least, most] :
         {std::tuple(&SweepOptions::tip_force_N, 0.5, 8.5),
          {&SweepOptions::motion_m, 1e-4, 5e-3},
          {&SweepOptions::servo_hz, 250.0, 8000.0}}) { // of the board
        EXPECT_EQ(set(value, least), "");
        EXPECT_EQ(set(value, most), "");
        for (const double outside : {0.99 * least, 1.01 * most, kNone}) {
            EXPECT_NE(set(value, outside), "") << outside;
        }
    }
    EXPECT_EQ(error([](SweepOptions &options) {
                  options.min_hz = 0.1;
                  options.max_hz = 250.0;
              }),
              "");
    for (const double hz : {0.099, 250.1, kNone}) {
        EXPECT_NE(set(&SweepOptions::min_hz, hz), "");
        EXPECT_NE(set(&SweepOptions::max_hz, hz), "");
    }
    EXPECT_NE(set(&SweepOptions::max_hz, SweepOptions{}.min_hz), "");
    EXPECT_EQ(set(&SweepOptions::points, 200), "");
    for (const int points : {1, 201}) {
        EXPECT_NE(set(&SweepOptions::points, points), "");
    }
    for (const std::vector<std::size_t> &motors :
         {std::vector<std::size_t>{}, std::vector<std::size_t>{3},
          std::vector<std::size_t>{1, 1}}) {
        EXPECT_NE(set(&SweepOptions::motors, motors), "");
    }
    EXPECT_NE(error([&](SweepOptions &options) { options.tuning.K_P_V_per_rad = kNone; }), "");
    WatchedDevice device(*open.device);
    device.is_known = false;
    EXPECT_NE(error_text_of([&] { const StiffnessSweep sweep(device); }).find("not zeroed"),
              std::string::npos);
}

} // namespace
} // namespace springdrive::commissioning
