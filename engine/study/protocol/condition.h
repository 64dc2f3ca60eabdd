// A condition of a study: a full set of parameters, and the list of those that are no gains. The
// gains are those of engine/control/tuning.h.
#pragma once

#include "base/field.h"
#include "base/vector.h"
#include "engine/control/tuning.h"
#include "engine/scene/lesson.h"
#include "engine/study/stimuli/stimulus.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::study {

/// The scene of a condition in free space.
inline constexpr std::string_view kNoScene = "none";

/// The defaults are those of protocol files.
struct Condition {
    std::string name;
    std::string scene = "plate"; ///< included, by its name; a file; or `kNoScene`
    /// In device coordinates. Nothing: the scene's own spot, which its lesson marks.
    std::optional<scene::TouchSpot> spot;
    Hold hold = Hold::surface;
    control::Tuning tuning; ///< in contact
    double servo_hz = 1000.0;
    double delay_periods = 0.0; ///< d of the device at that servo rate
    double turn_deg = 0.0;      ///< of the force, about the axis below; see `turned`
    double turn_axis_deg = 0.0;
    double press_N = 1.0;       ///< with which the hand presses
    double speed_m_per_s = 0.1; ///< of the hand: of a blow where it touches, of a stroke at most
    double pulse_N = 1.0;       ///< height of a pulse, as the force of a hand that does not move
    double pulse_hz = 30.0;     ///< of a pulse: it is one period of 1 − cos, 1/pulse_hz long

    friend bool operator==(const Condition &, const Condition &);
};

inline constexpr auto kConditionName = std::to_array<Field<Condition>>({
    {"name", &Condition::name, "in results", kRequired},
});

inline constexpr auto kConditionFields = std::to_array<Field<Condition>>({
    {"scene", &Condition::scene,
     "an included scene, by its name; a .gltf or .glb file beside the protocol; or \"none\", for "
     "free space",
     kReadable},
    {"hold", choice_of<&Condition::hold>(kHoldNames),
     "surface: the scene, without friction; cup: x₀ stays where the tip touches"},
    {"map", choice_of<&Condition::tuning, &control::Tuning::map>(control::kMotionMapNames),
     "motion map: (18) or (23)"},
    {"alpha_mode",
     choice_of<&Condition::tuning, &control::Tuning::alpha_mode>(control::kAlphaModeNames),
     "source of α in (23)"},
});

/// The parameters that are no gains.
inline constexpr auto kConditionParameters = std::to_array<Field<Condition>>({
    {"servo_hz", &Condition::servo_hz, "rate of the servo", 250.0, 10'000.0, "Hz"},
    {"delay_periods", &Condition::delay_periods,
     "from reading θ to applying e_W, in servo periods: what the device has at this rate", 0.0, 8.0,
     "–"},
    {"turn_deg", &Condition::turn_deg, "by which the force is turned out of the surface's normal",
     -90.0, 90.0, "°"},
    {"turn_axis_deg", &Condition::turn_axis_deg,
     "direction, in the contact plane, of the axis of that turn: 0 is the device's x axis, laid "
     "into the plane; on a level surface the force then leans towards the user, at 90 to the "
     "right",
     -180.0, 180.0, "°"},
    {"press_N", &Condition::press_N, "force with which the hand presses", 0.1, 8.0, "N"},
    {"speed_m_per_s", &Condition::speed_m_per_s,
     "of the hand: of a blow where it touches, of a stroke at most", 0.01, 1.0, "m/s"},
    {"pulse_N", &Condition::pulse_N, "height of a pulse, as felt by a hand that does not move",
     0.05, 5.0, "N"},
    {"pulse_hz", &Condition::pulse_hz,
     "frequency of a pulse: one period of 1 − cos, so it lasts 1/pulse_hz", 1.0, 250.0, "Hz"},
});

/// Any parameter of a condition: a gain or one of the above.
struct ParameterFacts {
    std::string_view name;
    std::string_view unit; ///< UTF-8; "–" where it has none
    double minimum = 0.0;  ///< inclusive
    double maximum = 0.0;  ///< inclusive
    double default_value = 0.0;
    std::string_view help;
    double control::Tuning::*gain = nullptr; ///< one of these two is set
    double Condition::*of_condition = nullptr;

    [[nodiscard]] double get(const Condition &condition) const {
        return gain != nullptr ? condition.tuning.*gain : condition.*of_condition;
    }
    void set(Condition &condition, double value) const {
        (gain != nullptr ? condition.tuning.*gain : condition.*of_condition) = value;
    }
};

/// All of them, gains first.
[[nodiscard]] std::span<const ParameterFacts> condition_parameters();

/// Null for an unknown name.
[[nodiscard]] const ParameterFacts *condition_parameter_named(std::string_view name);

/// The axis of `turn_deg`: unit, in the plane with that unit normal. At 0° it is the device's x
/// axis laid into the plane, or, where the normal is within 1° of the x axis, the z axis; from
/// there right-handed about the normal.
[[nodiscard]] Vector3 turn_axis(const Vector3 &normal, double turn_axis_deg);

/// A force along the unit normal, turned as the condition says: right-handed about `turn_axis`.
[[nodiscard]] Vector3 turned(const Condition &condition, const Vector3 &normal);

} // namespace springdrive::study
