// Covers engine/commissioning/calibration_run.cpp: drawn devices, on emulated boards and simulated,
// against their truth, and against the information bound of their sensors.
#include "engine/commissioning/calibration_run.h"

#include "base/input_error.h"
#include "device/core/calibration_file.h"
#include "device/factory/board_factory.h"
#include "device/simulated/calibration_tour.h"
#include "device/simulated/drawn_device.h"
#include "tests/support/cases.h"
#include "tests/support/complaint.h"
#include "tests/support/devices.h"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::commissioning {
namespace {

constexpr double kPeriod_s = 1.0 / CalibrationRun::kRate_hz;

// The information bound of (1) with (6), from the plant's truth. Over a tick
//
//   ∫e_W dt + R̂ ∫i dt − L Δi = Σ h p + w + v − v_before,  p = (R, a₁, b₁, a₂, b₂, o, k_T)
//
// with the noise w of the current in dR ∫i dt, and v of the angle's rounding and of L i. Both are
// white, so that the covariance of all ticks is tridiagonal; its LDLᵀ whitens h, row by row.
class InformationBound {
public:
    InformationBound(const device::DeviceDescription &file, std::size_t motor)
        : segments_(file.motor[motor].commutator_segments),
          L_H_(file.motor[motor].inductance_H),
          current_variance_A2_(file.current_sensing.noise_A * file.current_sensing.noise_A +
                               file.current_sensing.resolution_A *
                                   file.current_sensing.resolution_A / 12.0),
          count_variance_rad2_(file.rad_per_count() * file.rad_per_count() / 12.0) {}

    /// The true values before and after a tick.
    void take(double before_A, double after_A, double before_rad, double after_rad, double R_Ohm,
              double R_hat_Ohm, double k_T) {
        const double dR_Ohm = R_Ohm - R_hat_Ohm;
        const double charge_As = 0.5 * (before_A + after_A) * kPeriod_s;
        const double phase_rad = 0.5 * segments_ * (before_rad + after_rad);
        Row h;
        h << charge_As, charge_As * std::cos(phase_rad), charge_As * std::sin(phase_rad),
            charge_As * std::cos(2.0 * phase_rad), charge_As * std::sin(2.0 * phase_rad),
            -R_Ohm * kPeriod_s, after_rad - before_rad;
        const double q = dR_Ohm * dR_Ohm * kPeriod_s * kPeriod_s * current_variance_A2_;
        const double r = k_T * k_T * count_variance_rad2_ + L_H_ * L_H_ * current_variance_A2_;
        const double l = has_row_ ? r / d_ : 0.0;
        z_ = h + l * z_;
        d_ = q + 2.0 * r - l * r;
        has_row_ = true;
        information_ += z_ * z_.transpose() / d_;
    }

    /// The smallest standard deviations that an unbiased estimate can have.
    [[nodiscard]] std::array<double, 7> deviations() const {
        const Matrix scale = Matrix(information_.diagonal().cwiseSqrt().asDiagonal()).inverse();
        const Matrix inverse =
            scale * (scale * information_ * scale).ldlt().solve(Matrix::Identity()) * scale;
        std::array<double, 7> deviations{};
        for (std::size_t i = 0; i < deviations.size(); ++i) {
            const auto index = static_cast<Eigen::Index>(i);
            deviations[i] = std::sqrt(inverse(index, index));
        }
        return deviations;
    }

private:
    using Row = Eigen::Matrix<double, 7, 1>;
    using Matrix = Eigen::Matrix<double, 7, 7>;

    double segments_;
    double L_H_;
    double current_variance_A2_;
    double count_variance_rad2_;
    bool has_row_ = false;
    double d_ = 1.0;
    Row z_{Row::Zero()};
    Matrix information_{Matrix::Zero()};
};

/// What is true of a drawn motor, in the terms of a calibration, in air of 25 °C.
struct TrueMotor {
    double resistance_Ohm = 0.0;
    std::array<double, 2> ripple_Ohm{}; ///< of the first harmonic; there is no second
    double torque_constant_Nm_per_A = 0.0;
    double offset_A = 0.0;
};

TrueMotor true_motor(const device::DeviceDescription &file, std::uint64_t seed, std::size_t motor) {
    const simulated::DrawnMotor drawn = simulated::drawn_device(file, seed).motor[motor];
    TrueMotor truth;
    truth.resistance_Ohm = drawn.resistance_share * file.motor[motor].resistance_Ohm /
                           drawn.sensing.amplifier.gain;
    const double ripple_Ohm = file.motor[motor].commutation_ripple * truth.resistance_Ohm;
    truth.ripple_Ohm = {ripple_Ohm * std::cos(drawn.commutator_phase_rad),
                        -ripple_Ohm * std::sin(drawn.commutator_phase_rad)};
    truth.torque_constant_Nm_per_A =
        drawn.torque_constant_share * file.motor[motor].torque_constant_Nm_per_A;
    truth.offset_A = drawn.sensing.converter.offset_A;
    return truth;
}

/// A drawn device whose hand does as the calibration asks.
struct Tried {
    device::DeviceDescription file = testing::phantom_1_0();
    std::uint64_t seed = 1;
    bool is_on_board = true;
    double ambient_C = 25.0;
    CalibrationOptions options;

    Tried() { options.made_at_s = 1'764'000'000; }

    // What came of it:
    std::unique_ptr<simulated::SimulatedPhantom> phantom;
    factory::OpenBoard board;
    std::array<std::optional<InformationBound>, 3> bound;
    double largest_force_N = 0.0;

    simulated::SimulationOptions simulation() const {
        simulated::SimulationOptions simulation;
        simulation.device_seed = seed;
        simulation.ambient_C = ambient_C;
        return simulation;
    }

    void open() {
        if (!is_on_board) {
            phantom = std::make_unique<simulated::SimulatedPhantom>(file, simulation(),
                                                                    Vector3::Zero());
            return;
        }
        factory::BoardRequest request;
        request.description = request.truth = file;
        request.emulation.simulation = simulation();
        request.emulation.start_tip_m = Vector3::Zero();
        request.emulation.identity =
            emulator::emulated_identity(simulated::simulated_identity(seed).serial);
        request.watchdog_periods = 20.0;
        request.ignores_calibration = true;
        board = factory::open_board(request);
        board.device->zero(Vector3::Zero());
    }

    CalibrationReport run() {
        open();
        device::HapticDevice &device = is_on_board ? *board.device : *phantom;
        simulated::SimulatedPhantom &hand = is_on_board ? board.emulated->phantom() : *phantom;
        CalibrationRun run(device, options);
        bool moves = false;
        simulated::SimulatedPhantom::Truth before = hand.truth();
        for (std::size_t j = 0; j < 3; ++j) {
            bound[j].emplace(file, j);
        }
        while (run.step()) {
            EXPECT_GE(run.share(), 0.0);
            EXPECT_LE(run.share(), 1.0);
            if (run.stage() == CalibrationStage::motion && !moves) {
                moves = true;
                hand.follow(simulated::calibration_tour(file, hand.truth().tip_m, 200.0));
            }
            const simulated::SimulatedPhantom::Truth &now = hand.truth();
            if (run.stage() == CalibrationStage::motion) {
                note(run, before, now);
            }
            before = now;
        }
        return run.report();
    }

    void note(const CalibrationRun &run, const simulated::SimulatedPhantom::Truth &before,
              const simulated::SimulatedPhantom::Truth &now) {
        largest_force_N = std::max(largest_force_N, run.sample().tip_force_N.norm());
        for (std::size_t j = 0; j < 3; ++j) {
            const auto i = static_cast<Eigen::Index>(j);
            bound[j]->take(before.current_A[i], now.current_A[i], before.theta_rad[i],
                           now.theta_rad[i], now.resistance_Ohm[i],
                           run.sample().command.cancelled_resistance_Ohm[i],
                           file.motor[j].torque_constant_Nm_per_A);
        }
    }
};

TEST(CalibrationOfDrawnDevices, IsAsGoodAsItsSensorsAllow) {
    const int devices = testing::cases(2, 50);
    int within = 0;
    double worst_error = 0.0; // in deviations
    double worst_share = 0.0; // of R
    double worst_factor = 0.0;
    double worst_ripple_Ohm = 0.0;
    double longest_s = 0.0;
    for (int seed = 1; seed <= devices; ++seed) {
        Tried tried;
        tried.seed = static_cast<std::uint64_t>(seed);
        tried.is_on_board = seed % 2 == 1;
        const CalibrationReport report = tried.run();
        ASSERT_TRUE(report.is_complete) << "device " << seed << ": " << report.problem;
        longest_s = std::max(longest_s, report.motion_s);
        for (std::size_t j = 0; j < 3; ++j) {
            const device::MotorCalibration &found = report.calibration.motor[j];
            const TrueMotor truth = true_motor(tried.file, tried.seed, j);
            const auto deviations = tried.bound[j]->deviations();
            const double error =
                (found.resistance_Ohm - truth.resistance_Ohm) / found.resistance_deviation_Ohm;
            within += std::abs(error) < 1.96 ? 1 : 0;
            worst_error = std::max(worst_error, std::abs(error));
            worst_share =
                std::max(worst_share, std::abs(found.resistance_Ohm / truth.resistance_Ohm - 1.0));
            const double factor = found.resistance_deviation_Ohm / deviations[0];
            worst_factor = std::max(worst_factor, factor);
            const double ripple_Ohm = std::hypot(found.ripple_cos_Ohm - truth.ripple_Ohm[0],
                                                 found.ripple_sin_Ohm - truth.ripple_Ohm[1]);
            worst_ripple_Ohm = std::max(worst_ripple_Ohm, ripple_Ohm);
            std::printf("device %d motor %zu: R %.5f err %.5f dev %.5f bound %.5f; ripple err %.5f "
                        "dev %.5f bound %.5f; kT err %.2e dev %.2e bound %.2e; o %.2e dev %.2e "
                        "bound %.2e turned %.0f, %.0f s force %.2f\n",
                        seed, j + 1, found.resistance_Ohm,
                        found.resistance_Ohm - truth.resistance_Ohm,
                        found.resistance_deviation_Ohm, deviations[0], ripple_Ohm,
                        found.ripple_deviation_Ohm, deviations[1],
                        found.torque_constant_Nm_per_A - truth.torque_constant_Nm_per_A,
                        found.torque_constant_deviation_Nm_per_A, deviations[6],
                        found.offset_A - (tried.is_on_board ? 0.0 : truth.offset_A),
                        found.offset_deviation_A, deviations[5], report.motor[j].turned_rad,
                        report.motion_s, tried.largest_force_N);
        }
    }
    std::printf("worst of %d: R %.2f deviations, %.3f %%; %.1f times the bound; ripple %.2f mOhm; "
                "%d of %d within 95 %%; %.0f s\n",
                devices, worst_error, 100.0 * worst_share, worst_factor, 1e3 * worst_ripple_Ohm,
                within, 3 * devices, longest_s);
}

} // namespace
} // namespace springdrive::commissioning
