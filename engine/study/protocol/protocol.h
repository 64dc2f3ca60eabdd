// A protocol of a study: its conditions, and all else that is decided before it begins.
#pragma once

#include "base/field.h"
#include "base/vector.h"
#include "engine/control/tuning.h"
#include "engine/scene/scene.h"
#include "engine/study/methods/block.h"
#include "engine/study/protocol/texts.h"
#include "engine/study/stimuli/stimulus.h"
#include "engine/study/stimuli/warm_up.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

// A condition of a study: a full set of parameters, and the list of those that are no gains. The
// gains are those of engine/control/tuning.h.

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

// A protocol: everything about a study that is decided before the first participant sits down, as
// plain values. Files are read by protocol_file.cpp; docs/study_protocol.md is the manual.
//
// Free space. In free space (η = 1, ẋ_Sd = ẋ) the law (10) is e_W = k_T θ̇_f whatever K_P, K_D, α, η
// and map are: a device is felt by its own mass and friction and by k_T² τ/dR at each motor, with τ
// the loop's whole lag. So of a condition's parameters only dR, λ, the servo's rate and the delay
// matter there. Conditions that are compared are therefore in free space with one dR and one τ, and
// glide to their own dR and λ in contact only. Where servo rate or delay differ, λ in free space is
// the one with the same τ. A study whose stimulus is free space itself says so, and is then in free
// space with each condition's own dR and λ.

/// What a level of the method is, of the parameter under test.
enum class LevelMeaning : std::uint8_t {
    value,    ///< the parameter itself
    added,    ///< the standard's value plus the level
    taken_off ///< the standard's value minus the level: where less is felt more
};

/// By their number, as in protocol files.
inline constexpr std::array<std::string_view, 3> kLevelMeaningNames{"value", "added", "taken_off"};

/// The parameter that the method varies; beside it, a comparison has its condition's parameters.
struct Variable {
    std::string parameter = "eta"; ///< one of `condition_parameters()`
    LevelMeaning level = LevelMeaning::value;
    double standard = 0.0; ///< its value in the stimulus that is compared with
    /// The condition that all are compared with; empty: each with itself, at `standard`.
    std::string standard_condition;
    /// The standard is presented before the comparison: of yes/no and adjustment. In a forced
    /// choice by interval it is what all other intervals present.
    bool shows_standard = false;

    friend bool operator==(const Variable &, const Variable &) = default;
};

/// The tuning in free space, see above.
struct FreeSpaceTuning {
    double dR_Ohm = 0.5;
    double lambda_rad_per_s = 1000.0;

    friend bool operator==(const FreeSpaceTuning &, const FreeSpaceTuning &) = default;
};

/// Times of a trial [s]. An interval is an approach, a presentation and a way back.
struct TrialTiming {
    double rest_s = 0.5;         ///< the hand must be at rest in free space at the spot for so long
    double approach_s = 2.0;     ///< at most, until the hand is in contact
    double presentation_s = 1.0; ///< of the stimulus
    double pause_s = 0.5;        ///< between the intervals of a trial
    double response_s = 5.0;     ///< at most, after the last interval; then the trial is marked
    double between_trials_s = 1.0;
    double expected_response_s = 1.0; ///< for the session's length, as `approach_s`

    friend bool operator==(const TrialTiming &, const TrialTiming &) = default;
};

struct Breaks {
    int every_trials = 40; ///< within a block; 0: none
    double break_s = 60.0; ///< the shortest; the participant may rest longer
    double between_blocks_s = 120.0;

    friend bool operator==(const Breaks &, const Breaks &) = default;
};

/// The band of what was delivered, around what was intended. Outside it a trial is marked.
struct Marking {
    double stiffness_percent = 2.0;
    double direction_deg = 1.0;
    double force_percent = 20.0; ///< of the hand's press, or a blow's speed: it is the hand's own
    double lateness_s = 0.005;   ///< missed deadlines in a row
    bool repeats = true;         ///< marked trials are presented again, see block.h
    int max_marked = 20;         ///< in a block, see block.h

    friend bool operator==(const Marking &, const Marking &) = default;
};

struct StoppingRules {
    double longest_session_min = 60.0; ///< the present trial is the last
    int max_trips = 3;                 ///< of the safety monitor in a session

    friend bool operator==(const StoppingRules &, const StoppingRules &) = default;
};

/// What is expected of participants, to place levels and to plan. Never shown as a result.
struct Expectation {
    double threshold = 1.0; ///< a level, of the psychometric function's family below
    double slope = 3.5;
    double lapse = 0.02;
    FunctionFamily family;
    std::string source; ///< where that is from

    friend bool operator==(const Expectation &, const Expectation &) = default;
};

/// How a participant answers.
enum class ResponseDevice : std::uint8_t { keyboard, mouse, gesture };
inline constexpr std::array<std::string_view, 3> kResponseDeviceNames{"keyboard", "mouse",
                                                                      "gesture"};

struct ResponseWays {
    ResponseDevice device = ResponseDevice::keyboard;
    /// One per alternative, "no" and "yes", or "less", "more" and "done" of an adjustment: names of
    /// keys, of mouse buttons, or of gestures.
    std::vector<std::string> keys{"1", "2"};

    friend bool operator==(const ResponseWays &, const ResponseWays &) = default;
};

/// Pink noise from the system's sound output, which masks the device's own;
/// app/study/sound/masking_noise.h.
struct MaskingNoise {
    double level_dBFS = -30.0; ///< RMS, of full scale; what that is at the ear is for the volume

    friend bool operator==(const MaskingNoise &, const MaskingNoise &) = default;
};

/// Trials without a break between conditions, which are interleaved.
struct ProtocolBlock {
    std::string name;
    std::vector<std::size_t> conditions; ///< indices into `Protocol::conditions`

    friend bool operator==(const ProtocolBlock &, const ProtocolBlock &) = default;
};

struct Protocol {
    std::string title;
    std::string language = "en"; ///< of the texts
    Texts texts;
    int seed = 1;
    std::string device_file = "phantom_1_0"; ///< included, by its name; or a file
    std::vector<Condition> conditions;
    bool free_space_is_stimulus = false;
    std::optional<FreeSpaceTuning> free_space; ///< nothing: the conditions' own is one
    StimulusForm stimulus = StimulusForm::press;
    Variable variable;
    Task task;
    Method method;
    ResponseWays responses;
    TrialTiming timing;
    Practice practice;
    CatchTrials catch_trials;
    std::vector<ProtocolBlock> blocks;
    Counterbalancing counterbalancing = Counterbalancing::balanced_latin_square; ///< of the blocks
    int participants = 12;
    Breaks breaks;
    Marking marking;
    WindingBand windings;
    StoppingRules stopping;
    std::vector<QuestionnaireItem> questionnaire; ///< in the order in which it is asked
    std::optional<MaskingNoise> noise;            ///< nothing: none
    std::optional<Expectation> expected;

    friend bool operator==(const Protocol &, const Protocol &) = default;
};

/// The first that makes the values, each as its field allows it, no protocol: "KEY is VALUE; it
/// must be …". Empty if there is none. Whether it is a good one is for protocol_check.h.
[[nodiscard]] std::string validate(const Protocol &protocol);

/// The index of the condition of that name.
[[nodiscard]] std::optional<std::size_t> condition_named(const Protocol &protocol,
                                                         std::string_view name);

/// "a, b"; of anything with names.
template <typename Named> [[nodiscard]] std::string names_of(const Named &all) {
    std::string names;
    for (const auto &one : all) {
        names += (names.empty() ? "" : ", ") + std::string(one.name);
    }
    return names;
}

// @pre of all below: validate(protocol) is empty

[[nodiscard]] const ParameterFacts &variable_of(const Protocol &protocol);

/// The variable's value at a level.
[[nodiscard]] double value_at(const Protocol &protocol, double level);

/// A condition at a level: what is presented as the comparison. In a forced choice by place, where
/// the places are m directions, the axis of the turn is turned by 360°/m for each `target`.
[[nodiscard]] Condition comparison(const Protocol &protocol, std::size_t condition, double level,
                                   int target = 0);

/// What a condition is compared with: itself at the standard value, or the standard condition.
[[nodiscard]] Condition standard(const Protocol &protocol, std::size_t condition);

/// Index of `Variable::standard_condition`; nothing if each is compared with itself.
[[nodiscard]] std::optional<std::size_t> standard_condition_of(const Protocol &protocol);

/// A condition's tuning in free space: dR and λ as said above, all else as in contact. λ may exceed
/// the range of its parameter; nothing where no λ gives the shared lag.
[[nodiscard]] std::optional<control::Tuning> free_space_tuning(const Protocol &protocol,
                                                               const Condition &condition);

/// The block as the methods see it; series are in the order of its conditions.
/// @param is_first  in the participant's order: only that one has the practice
[[nodiscard]] Block block_of(const Protocol &protocol, std::size_t block, bool is_first);

/// Levels that can be presented, rising: all of them where they are finite in number, else from
/// the lowest to the highest in `steps` equal steps on the method's scale.
[[nodiscard]] std::vector<double> presentable_levels(const Protocol &protocol, int steps = 16);

/// Stimuli that a trial presents, one after the other.
[[nodiscard]] int presentations_per_trial(const Protocol &protocol);

// Protocols in files: assets/protocols/*.toml, and those of researchers. docs/study_protocol.md has
// every key.

/// @throw InputError naming the file, the line, the key, its value and what is allowed, for a file
///        that cannot be read, is no TOML, has an unknown key (with the nearest one that is known),
///        lacks one, or has a value of the wrong type or out of its range.
[[nodiscard]] Protocol read_protocol_file(const std::filesystem::path &file);

/// The same from a text, such as the one that a study keeps; messages refer to it as `file`.
[[nodiscard]] Protocol read_protocol_text(const std::string &text,
                                          const std::filesystem::path &file);

/// Every key that a protocol file may have, as Markdown tables in the order of the manual.
void write_protocol_keys(std::ostream &out);

} // namespace springdrive::study
