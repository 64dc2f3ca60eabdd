// The steps above which integrators of the plant are unstable.
#include "base/bisection.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/lab/limits/method_limits/experiment_list.h"
#include "engine/lab/rig/plant_equations.h"

#include <cmath>
#include <complex>
#include <limits>

namespace springdrive::limits {

namespace {

/// The contact mode of the plant: a rotor with its load against the inductive stiffness K_L (4) of
/// a winding with a constant set-point.
///
///   J θ̈ = k_T i − b θ̇        L di/dt = −dR i − k_T θ̇
/// Base joint and winding of a plant without hand or command.
struct ContactMode {
    static constexpr double kNet_Ohm = 0.1;  ///< small enough for the mode to oscillate
    static constexpr double kStart_A = 1e-3; ///< in the winding, at rest

    explicit ContactMode(const loops::StabilityCase &which);

    [[nodiscard]] const device::MotorParameters &motor() const { return device.motor[0]; }
    /// The decay rates of current and speed on their own.
    [[nodiscard]] double winding_per_s() const { return kNet_Ohm / motor().inductance_H; }
    [[nodiscard]] double rotor_per_s() const { return damping_Nms_per_rad / inertia_kg_m2; }
    /// K_L/J.
    [[nodiscard]] double omega_squared() const {
        return device::inductive_stiffness_Nm_per_rad(motor()) / inertia_kg_m2;
    }
    /// Eigenvalue of y' = A y with y = (θ̇, i), the one with the positive imaginary part.
    [[nodiscard]] std::complex<double> eigenvalue() const {
        const double middle = 0.5 * (winding_per_s() + rotor_per_s());
        const double product = winding_per_s() * rotor_per_s() + omega_squared();
        return -middle + std::sqrt(std::complex<double>(middle * middle - product));
    }

    [[nodiscard]] rig::PlantState start() const {
        rig::PlantState y = rig::PlantState::Zero();
        y.head<3>() = q_rad;
        y[6] = kStart_A;
        return y;
    }
    [[nodiscard]] double energy_J(const rig::PlantState &y) const {
        const double rate = device.geometry.transmission_ratio[0] * y[3];
        return 0.5 * (inertia_kg_m2 * rate * rate + motor().inductance_H * y[6] * y[6]);
    }
    [[nodiscard]] rig::PlantEquations equations() const;

    device::DeviceDescription device;
    Vector3 q_rad;
    simulated::SimulationOptions options;
    device::DeviceCommand command;
    double inertia_kg_m2 = 0.0; ///< of the base's motor with its load
    double damping_Nms_per_rad = 0.0;
};

ContactMode::ContactMode(const loops::StabilityCase &which)
    : device(which.device), q_rad(which.q_rad) {
    const loops::DrivenLoad load = loops::driven_load(which, {0, loops::no_hand()});
    inertia_kg_m2 = load.inertia_kg_m2(0, 0);
    damping_Nms_per_rad = load.damping_Nms_per_rad(0, 0);
    options.hand = {0.0, 0.0, 0.0, 0.0, 1.0};
    options.effects = simulated::PlantEffects::none();
    options.effects.viscous_friction = true;
    options.quantised_encoders = false;
    for (Eigen::Index j = 0; j < 3; ++j) {
        command.cancelled_resistance_Ohm[j] =
            device.motor[static_cast<std::size_t>(j)].resistance_Ohm - kNet_Ohm;
    }
}

rig::PlantEquations ContactMode::equations() const {
    rig::PlantEquations of(device, options);
    rig::PlantInputs inputs;
    inputs.command = command;
    inputs.target.position_m = device::tip_position_m(device.geometry, q_rad);
    of.set_inputs(inputs);
    return of;
}

constexpr double kMicro = 1e6;
constexpr double kMinTried_s = 1e-6;

/// The winding alone, by a method for a single state.
template <typename Step>
Experiment held_rotor(const char *method, const device::MotorParameters &motor, double net_Ohm,
                      const std::string &setting, double times_L_over_R, const Step &step) {
    const double time_s = motor.inductance_H / net_Ohm;
    using State = Eigen::Matrix<double, 1, 1>;
    return {
        {method, "step above", "µs", setting + ", rotor held", kMicro * times_L_over_R * time_s},
        {kMicro * kMinTried_s, kMicro * 10.0 * time_s},
        [=](double step_us) {
            const auto rates = [&](double, const State &current) -> State {
                return -current / time_s;
            };
            State current = State::Ones();
            for (int i = 0; i < 1000; ++i) {
                current = step(rates, current, step_us / kMicro);
            }
            return std::abs(current[0]) < 1.0;
        }};
}

/// The plant's equations as integrators take them.
auto rates_of(const rig::PlantEquations &f) {
    return [&f](double t, const rig::PlantState &y) { return f.rates(t, y); };
}

/// Whether the mode's energy decays under a method for the whole plant. The links, which have modes
/// of their own, are held.
/// @param step  y after a step, from the equations and y
template <typename Step> bool energy_decays(const ContactMode &mode, const Step &step) {
    constexpr int kSteps = 5000;
    constexpr double kSurely = 1e6;
    const rig::PlantEquations equations = mode.equations();
    rig::PlantState y = mode.start();
    const double start_J = mode.energy_J(y);
    for (int i = 0; i < kSteps; ++i) {
        const rig::PlantState next = step(equations, y);
        for (const Eigen::Index of_base : {0, 3, 6}) {
            y[of_base] = next[of_base];
        }
        const double energy_J = mode.energy_J(y);
        if (!(energy_J < kSurely * start_J)) {
            return false;
        }
        if (energy_J < start_J / kSurely) {
            return true;
        }
    }
    return mode.energy_J(y) < start_J;
}

/// @param predicted_s  nothing where a method has no limit
/// @param holds_for_s  whether it is stable at a step
template <typename Holds>
Experiment contact_experiment(const char *method, std::optional<double> predicted_s,
                              const Holds &holds_for_s, const std::string &more = "") {
    constexpr double kFarBeyond = 10.0;
    constexpr double kMaxTried_s = 1.0;
    return {{method, "step above", "µs",
             "contact mode of base and K_L, dR " + with_unit(ContactMode::kNet_Ohm, "Ω") + more +
                 (predicted_s ? "" : "; tried from 1 µs to 1 s"),
             predicted_s ? std::optional(kMicro * *predicted_s) : std::nullopt},
            {kMicro * kMinTried_s,
             predicted_s ? kMicro * kFarBeyond * *predicted_s : kMicro * kMaxTried_s},
            [=](double step_us) { return holds_for_s(step_us / kMicro); }};
}

/// |1 + hλ| = 1.
Experiment explicit_euler(const ContactMode &mode) {
    const std::complex<double> root = mode.eigenvalue();
    return contact_experiment(
        "explicit Euler", -2.0 * root.real() / std::norm(root), [=](double h) {
            return energy_decays(mode, [=](const rig::PlantEquations &f, const rig::PlantState &y) {
                return rig::explicit_euler_step(rates_of(f), 0.0, y, h);
            });
        });
}

/// With x and y the relative losses of rotor and winding in a step, (2 − x)(2 − y) = (hω)²: 2/ω
/// without losses.
Experiment semi_implicit_euler(const ContactMode &mode) {
    const double losses = mode.winding_per_s() + mode.rotor_per_s();
    const double a = mode.omega_squared() - mode.winding_per_s() * mode.rotor_per_s();
    const double h_s = (std::sqrt(losses * losses + 4.0 * a) - losses) / a;
    const auto holds = [=](double h) {
        return energy_decays(mode, [=](const rig::PlantEquations &f, const rig::PlantState &y) {
            return rig::semi_implicit_euler_step(
                [&](double t, const rig::PlantState &at) { return f.momentum_rates(t, at); },
                [&](double, const rig::PlantState &at) { return f.position_rates(at); }, 0.0, y, h);
        });
    };
    return contact_experiment(
        "semi-implicit Euler", h_s, holds,
        "; 2/ω is " + with_unit(std::round(kMicro * 2.0 / std::sqrt(mode.omega_squared())), "µs"));
}

/// |R(hλ)| = 1 with the classical method's R(z).
Experiment runge_kutta(const ContactMode &mode) {
    const std::complex<double> root = mode.eigenvalue();
    const double h_s =
        last_that_holds({0.0, 10.0 / std::abs(root)}, TriedValues{}.resolution, [&](double h) {
            const std::complex<double> z = h * root;
            return std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))) <= 1.0;
        });
    return contact_experiment("Runge-Kutta 4", h_s, [=](double h) {
        return energy_decays(mode, [=](const rig::PlantEquations &f, const rig::PlantState &y) {
            return rig::runge_kutta_step(rates_of(f), 0.0, y, h);
        });
    });
}

Experiment implicit_midpoint(const ContactMode &mode) {
    return contact_experiment("implicit midpoint", std::nullopt, [=](double h) {
        rig::ImplicitMidpoint<rig::PlantState> midpoint;
        const rig::PlantEquations at_start = mode.equations();
        midpoint.prepare(rates_of(at_start), 0.0, mode.start(), h);
        return energy_decays(mode, [&](const rig::PlantEquations &f, const rig::PlantState &y) {
            return midpoint.step(rates_of(f), 0.0, y)
                .value_or(rig::PlantState::Constant(std::numeric_limits<double>::quiet_NaN()));
        });
    });
}

/// The simulated device: its energy may not rise by more than round-off.
Experiment simulated_device(const ContactMode &mode) {
    return contact_experiment("ours (exact in energy)", std::nullopt, [=](double h) {
        constexpr int kSteps = 1000;
        constexpr double kRoundOff = 1e-9;
        simulated::SimulationOptions options = mode.options;
        options.servo_period_s = options.longest_step_s = h;
        simulated::SimulatedPhantom plant(mode.device, options,
                                          device::tip_position_m(mode.device.geometry, mode.q_rad));
        plant.set_in_motion(Vector3::Zero(), Vector3(ContactMode::kStart_A, 0.0, 0.0));
        double energy_J = plant.stored_energy_J();
        const double round_off_J = kRoundOff * energy_J;
        for (int i = 0; i < kSteps; ++i) {
            static_cast<void>(plant.advance(mode.command));
            const double before_J = energy_J;
            energy_J = plant.stored_energy_J();
            if (!(energy_J <= before_J + round_off_J)) {
                return false;
            }
        }
        return true;
    });
}

} // namespace

Experiments integrator_experiments(const loops::StabilityCase &which) {
    const auto euler = [](const auto &rates, const auto &y, double h) {
        return rig::explicit_euler_step(rates, 0.0, y, h);
    };
    const auto fourth = [](const auto &rates, const auto &y, double h) {
        return rig::runge_kutta_step(rates, 0.0, y, h);
    };
    constexpr double kRealLimit = 2.785293563405282; // where 1 − z + z²/2 − z³/6 + z⁴/24 = 1
    const device::MotorParameters &motor = which.device.motor[1];
    const double dR_Ohm = control::Tuning{}.dR_Ohm;
    const ContactMode mode(which);
    return {held_rotor("explicit Euler", motor, motor.resistance_Ohm, "R̂ = 0", 2.0, euler),
            held_rotor("explicit Euler", motor, dR_Ohm, "dR " + with_unit(dR_Ohm, "Ω"), 2.0, euler),
            explicit_euler(mode),
            semi_implicit_euler(mode),
            held_rotor("Runge-Kutta 4", motor, motor.resistance_Ohm, "R̂ = 0", kRealLimit, fourth),
            runge_kutta(mode),
            implicit_midpoint(mode),
            simulated_device(mode)};
}

} // namespace springdrive::limits
