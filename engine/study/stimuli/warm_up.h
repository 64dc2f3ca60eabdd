// The temperatures in which a study keeps its windings, and how it gets them there.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/motor/winding_heat.h"
#include "engine/control/tuning.h"
#include "engine/servo/servo_inputs.h"
#include "engine/servo/servo_sample.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace springdrive::study {

/// The windings are warmed to this band before the first trial and kept in it.
struct WindingBand {
    double air_C = 25.0;
    double from_C = 30.0;
    double to_C = 60.0;

    friend bool operator==(const WindingBand &, const WindingBand &) = default;
};

/// By the safety monitor, the middle of its bounds: the air is taken to be between 15 and 35 °C.
/// RT-safe.
[[nodiscard]] inline Vector3 estimated_windings_C(const servo::ServoSample &sample) noexcept {
    Vector3 winding_C;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const servo::WindingStatus &winding = sample.winding[static_cast<std::size_t>(j)];
        winding_C[j] = 0.5 * (winding.min_C + winding.max_C);
    }
    return winding_C;
}

// Warms the windings to a study's band, in free space, without a hand's having to hold against it.
//
//   waiting ──the servo runs, the tip is free──► heating ──warm──► fading ──► done
//                                                   │                │
//                                                   └────► failed ◄──┘
//
// Three motors move a tip in three directions: any current that stays is a force. One that
// alternates faster than the mass can follow is not. The voltage changes its sign with every tick;
// without cancelled resistance the current settles within L/R, a ninth of a millisecond, so it is a
// square wave, too, of half the servo's rate, with most of the heat of a steady current:
//
//   P = R a² [1 − 2 (τ/T) tanh(T/2τ)],      τ = L/R
//
// A mass m under a force ±F that changes its sign every T goes to and fro by F T²/8m to either
// side: 11 µm of 65 g with 6 N at 1 kHz, 0.7 µm at 4 kHz. That is all that a free tip does. A hand
// that holds it is shaken with that by F m_h/(m + m_h), newtons if its mass is that of the tip; at
// 500 Hz skin feels micrometres. So the hand should be off: what holds still stays where it is, but
// buzzes.
//
// Half the rate, not a quarter: the energy observer takes the mean of the forces at both ends of a
// tick. Where the sign changes with each, it sees no work. With +, +, −, − it would see F² T²/2m of
// work in each half-wave that is none, and trip on a free tip. The price is that the monitor's
// lower bound of temperature counts no heat where a current has changed its sign, so the middle of
// its bounds sees half of a² R, and windings are by a third warmer above the air than it tells.
//
// Each winding gets what it lacks. Its housing, ten times as heavy, has to be warmed, too, or the
// winding is cold again 12 s later. That follows from the winding's estimate,
//
//   C_h dT_h/dt = (T_w − T_h)/R_wh − (T_h − T_a)/R_ha
//
// and a winding is warm when it would stay in the band left alone, kReserve of it above its lower
// end: (C_w T_w + C_h T_h)/(C_w + C_h). Meanwhile it is hotter than that, but not above kCeiling of
// the band, which leaves room for that third.
//
// R̂ is zero meanwhile: dR is R, so that no tuning can be unstable and the current settles.

enum class WarmUpPhase : std::uint8_t {
    waiting, ///< until the servo runs, in free space
    heating,
    fading, ///< the tuning glides back, windings that were hotter come down into the band
    done,
    failed,
};

enum class WarmUpFailure : std::uint8_t {
    none,
    tripped,  ///< the safety monitor
    too_long, ///< not in the band after `kMax_s`
};

/// By the number of the failure.
inline constexpr std::array<std::string_view, 3> kWarmUpFailures{
    "", "the safety monitor tripped", "the windings did not come into their band in ten minutes"};
static_assert(kWarmUpFailures.size() == static_cast<std::size_t>(WarmUpFailure::too_long) + 1);
[[nodiscard]] constexpr std::string_view description(WarmUpFailure failure) {
    return kWarmUpFailures[static_cast<std::size_t>(failure)];
}

/// What a winding and its housing meet at, left alone and without what they lose to the air [°C].
[[nodiscard]] double meeting_C(const device::ThermalParameters &thermal, double winding_C,
                               double housing_C) noexcept;

/// The largest current of each motor [A], at these angles: `kForceShare` of the limit of force at
/// the tip if all motors carry it, and `kCurrentShare` and `kVoltageShare` of the motors' own
/// limits. RT-safe.
[[nodiscard]] Vector3 warming_current_A(const device::DeviceDescription &device,
                                        const servo::SafetyLimits &limits,
                                        const Vector3 &theta_rad) noexcept;

/// What a warm-up comes to.
struct PredictedHeating {
    double duration_s = 0.0;                ///< of the heating, at most `WarmUp::kMax_s`
    device::WindingTemperature temperature; ///< at its end; its step is `step_s`
};

/// Of one winding, from the air's temperature, by the thermal network, as the monitor sees it.
[[nodiscard]] PredictedHeating predicted_heating(const device::MotorParameters &motor,
                                                 const WindingBand &band, double current_A,
                                                 double step_s);

class WarmUp {
public:
    /// Of the limiter's and monitor's own limits; the rest is for tolerances of R and k_T, the
    /// commutator's ripple, and a hand that moves.
    static constexpr double kForceShare = 0.7;
    static constexpr double kCurrentShare = 0.5;
    static constexpr double kVoltageShare = 0.5;
    /// From zero to the largest amplitude and back [s].
    static constexpr double kRamp_s = 0.5;
    static constexpr double kMax_s = 600.0;
    /// Of the band's width, above its lower end: what windings and housings may cool before they
    /// are warmed again.
    static constexpr double kReserve = 0.05;
    /// Of the band's width, above its lower end: no winding is heated above that.
    static constexpr double kCeiling = 0.5;
    /// A winding so near to the ceiling, or to the monitor's limit, is heated less [K].
    static constexpr double kSoft_K = 4.0;

    WarmUp(const device::DeviceDescription &device, const WindingBand &band, double period_s);

    /// What winding and housing of a warm motor would meet at, left alone.
    [[nodiscard]] static double warm_C(const WindingBand &band) noexcept {
        return band.from_C + kReserve * (band.to_C - band.from_C);
    }
    [[nodiscard]] static double ceiling_C(const WindingBand &band) noexcept {
        return band.from_C + kCeiling * (band.to_C - band.from_C);
    }

    /// Whether it has anything to do.
    [[nodiscard]] static bool is_needed(const WindingBand &band, const Vector3 &winding_C) noexcept;

    /// After a tick: sets dR and excitation of the next one; when it is over, dR is what it was
    /// before and the excitation zero. RT-safe.
    /// @param inputs  as published, or as the last call left them
    void update(const servo::ServoSample &last, servo::LawInputs &inputs) noexcept;

    [[nodiscard]] WarmUpPhase phase() const { return phase_; }
    [[nodiscard]] WarmUpFailure failure() const { return failure_; }
    [[nodiscard]] bool is_over() const {
        return phase_ == WarmUpPhase::done || phase_ == WarmUpPhase::failed;
    }
    /// What the coldest motor still lacks, or the hottest has too much [K].
    [[nodiscard]] double off_band_K() const { return off_band_K_; }
    /// Of the currents at present [A].
    [[nodiscard]] const Vector3 &amplitude_A() const { return amplitude_A_; }

private:
    void follow_housings(const Vector3 &winding_C) noexcept;
    [[nodiscard]] double lacking_K(Eigen::Index motor, double winding_C) const noexcept;
    [[nodiscard]] double heat_share(Eigen::Index motor,
                                    const servo::ServoSample &last) const noexcept;
    [[nodiscard]] Vector3 requested_A(const servo::ServoSample &last, const Vector3 &most_A,
                                      bool is_allowed) const noexcept;
    void proceed(const servo::ServoSample &last) noexcept;
    [[nodiscard]] bool has_asked_dR(const servo::ServoSample &last) const noexcept {
        return last.tuning.dR_Ohm == requested_dR_Ohm_;
    }
    [[nodiscard]] Vector3 voltage_V(const servo::ServoSample &last) noexcept;

    device::DeviceDescription device_;
    WindingBand band_;
    double period_s_;
    WarmUpPhase phase_ = WarmUpPhase::waiting;
    WarmUpFailure failure_ = WarmUpFailure::none;
    double elapsed_s_ = 0.0;
    double off_band_K_ = 0.0;
    double sign_ = 1.0; ///< of the last voltage
    std::optional<double> dR_before_Ohm_;
    double requested_dR_Ohm_ = 0.0; ///< by the last update; the servo glides there
    bool has_housings_ = false;
    Vector3 housing_C_{Vector3::Zero()};
    std::array<bool, 3> has_warmed_{};
    Vector3 amplitude_A_{Vector3::Zero()};
};

} // namespace springdrive::study
