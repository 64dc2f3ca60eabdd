// One stimulus as the servo is to present it. Protocols make them: engine/study/protocol.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/control/tuning.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace springdrive::study {

/// How a stimulus comes to the hand.
enum class StimulusForm : std::uint8_t {
    press,  ///< the hand presses on the spot with `press_N`
    blow,   ///< the hand strikes the spot with `speed_m_per_s`
    pulse,  ///< the hand rests on the spot with `press_N`; the device pushes once, by `pulse_N`
    stroke, ///< the hand moves to and fro in free space, `speed_m_per_s` at most
};

/// By their number, as in protocol files.
inline constexpr std::array<std::string_view, 4> kStimulusFormNames{"press", "blow", "pulse",
                                                                    "stroke"};

/// What holds the tip where it is presented a stimulus.
enum class Hold : std::uint8_t {
    surface, ///< the scene: without friction, so that the tip slides where it is not pressed square
    cup,     ///< a friction cup at the spot: x₀ stays where the tip first touches the scene
};

/// By their number, as in protocol files.
inline constexpr std::array<std::string_view, 2> kHoldNames{"surface", "cup"};

/// The axes in which a force's direction is told: right-handed about `turn_axis`, from the normal.
struct TurnFrame {
    Vector3 normal{Vector3::UnitY()};    ///< unit
    Vector3 turn_axis{Vector3::UnitX()}; ///< unit, square to it
};

/// How far a force leans [°]; of a force against the normal beyond 90.
struct ForceAngles {
    double turn_deg = 0.0;   ///< out of the normal, about the turn axis
    double across_deg = 0.0; ///< out of the plane of that turn, towards the axis
};
[[nodiscard]] ForceAngles force_angles(const TurnFrame &frame, const Vector3 &force);

/// One period of 1 − cos, `height_N` at its middle; 1/`frequency_hz` long.
struct Pulse {
    double height_N = 0.0; ///< as the force on a hand that does not move
    double frequency_hz = 30.0;

    [[nodiscard]] double length_s() const { return 1.0 / frequency_hz; }
    /// At a time from its beginning [N]; 0 before and after. RT-safe.
    [[nodiscard]] double force_N(double since_s) const noexcept;
    /// The force's derivative [N/s]. RT-safe.
    [[nodiscard]] double rate_N_per_s(double since_s) const noexcept;
};

/// From the end of a pulse until the currents have settled [s]: ten of their time constants L/dR at
/// 0.5 Ω, and a servo's delay at 1 kHz.
inline constexpr double kAfterPulse_s = 0.01;

struct Stimulus {
    StimulusForm form = StimulusForm::press;
    Hold hold = Hold::surface;
    control::Tuning contact;
    control::Tuning free_space;       ///< before and after; only dR and λ matter there
    Vector3 start_m{Vector3::Zero()}; ///< where the hand rests before
    TurnFrame frame;
    Vector3 direction{Vector3::UnitY()}; ///< unit: of the force, or of the pulse
    bool is_steered = false;             ///< the force is kept in that direction
    Pulse pulse;
    double rest_s = 0.5;           ///< the hand is at rest at the start for so long
    double approach_s = 2.0;       ///< at most, from there to contact
    double presentation_s = 1.0;   ///< from contact; of a stroke from the end of the rest
    double min_glide_back_s = 0.0; ///< see `glide_back_s`; one for all that are compared

    /// From contact to the beginning of the pulse: the middle, or so that it ends, and the currents
    /// have settled, in time.
    [[nodiscard]] double pulse_from_s() const;
};

/// So long the hand stays in contact after the presentation, until free space tells nothing of it:
/// ten of the time constants with which the servo glides if dR or λ have to, K_P and the rest do
/// not matter there; half of that if a steered force has to be taken back; else 0. But at least
/// `min_glide_back_s`, except of a stroke.
[[nodiscard]] double glide_back_s(const Stimulus &stimulus);

// What a stimulus is measured by: the same of what was intended and of what was delivered.

/// Nothing where it does not apply, or could not be measured.
struct StimulusMeasures {
    std::optional<double> turn_deg;          ///< of the force, or of a pulse; see `ForceAngles`
    std::optional<double> across_deg;        ///< the same
    std::optional<double> stiffness_N_per_m; ///< along the normal, at rest
    std::optional<double> press_N;           ///< of the hand along the normal, at rest
    std::optional<double> speed_m_per_s;     ///< of the hand: at touch, or at most in a stroke
    std::optional<double> pulse_N;           ///< height of a pulse, on a hand that does not move

    friend bool operator==(const StimulusMeasures &, const StimulusMeasures &) = default;
};

/// How far what was delivered may be off.
enum class Band : std::uint8_t {
    direction, ///< difference from the intended angle, at most `Marking::direction_deg`
    stiffness, ///< share of the intended one, at most `Marking::stiffness_percent`
    force,     ///< share of the intended one, at most `Marking::force_percent`
};

struct StimulusMeasure {
    std::string_view name; ///< in stores and exports, with its unit
    std::optional<double> StimulusMeasures::*value = nullptr;
    Band band = Band::force;
};

/// The list of all, in the order in which they are stored.
inline constexpr std::array<StimulusMeasure, 6> kStimulusMeasures{{
    {"direction_deg", &StimulusMeasures::turn_deg, Band::direction},
    {"direction_across_deg", &StimulusMeasures::across_deg, Band::direction},
    {"stiffness_N_per_m", &StimulusMeasures::stiffness_N_per_m, Band::stiffness},
    {"press_N", &StimulusMeasures::press_N, Band::force},
    {"speed_m_per_s", &StimulusMeasures::speed_m_per_s, Band::force},
    {"pulse_N", &StimulusMeasures::pulse_N, Band::force},
}};

} // namespace springdrive::study
