#include "engine/study/protocol/protocol_check.h"

#include "base/degrees.h"
#include "base/for_persons.h"
#include "base/parallel.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/lab/loops/stability_case.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

namespace springdrive::study {

namespace {

/// Room for the hand below the surface, beside what the press itself needs [m].
constexpr double kBelow_m = 0.005;

/// The smallest distance of a configuration to a stop of the joints; negative beyond it [rad].
double room_rad(const device::JointLimits &limits, const Vector3 &q_rad) {
    const double fold_rad = q_rad[2] - q_rad[1];
    return std::min({(q_rad - limits.min_rad).minCoeff(), (limits.max_rad - q_rad).minCoeff(),
                     fold_rad - limits.min_q3_minus_q2_rad, limits.max_q3_minus_q2_rad - fold_rad});
}

/// The way of a trial: above the spot and below, or to either side of it.
std::string wrong_way(const device::DeviceDescription &device, const scene::TouchSpot &spot,
                      StimulusForm form) {
    constexpr int kSteps = 20;
    const bool is_stroke = form == StimulusForm::stroke;
    const Vector3 from_m = spot.point_m + (is_stroke ? Vector3(kStroke_m * Vector3::UnitX())
                                                     : Vector3(kApproach_m * spot.normal));
    const Vector3 to_m = spot.point_m - (is_stroke ? Vector3(kStroke_m * Vector3::UnitX())
                                                   : Vector3(kBelow_m * spot.normal));
    for (int i = 0; i <= kSteps; ++i) {
        const Vector3 tip_m = from_m + (to_m - from_m) * i / kSteps;
        const std::optional<Vector3> q_rad = device::joint_angles_rad(device.geometry, tip_m);
        const std::string at =
            fmt::format("({:.3f}, {:.3f}, {:.3f}) m, {:.0f} mm from the spot,", tip_m.x(),
                        tip_m.y(), tip_m.z(), 1e3 * (tip_m - spot.point_m).norm());
        if (!q_rad || !device.joint_limits.allow(*q_rad)) {
            return at + " is out of the device's reach";
        }
        if (const double room = room_rad(device.joint_limits, *q_rad);
            room < device.edge.margin_rad) {
            return fmt::format("{} is {:.1f}° before a stop, where the soft edge of the workspace "
                               "pushes from {:.1f}° on",
                               at, room * kDegreesPerRadian,
                               device.edge.margin_rad * kDegreesPerRadian);
        }
    }
    return {};
}

double lag_s(const Condition &condition, const control::Tuning &tuning) {
    return control::loop_lag_s(tuning.lambda_rad_per_s, 1.0 / condition.servo_hz,
                               condition.delay_periods);
}

/// With [free_space]: λ of each condition must exist, and be one that the servo takes.
void check_shared(ProtocolFindings &findings, const Protocol &protocol) {
    const control::Parameter &lambda = control::parameter_of(&control::Tuning::lambda_rad_per_s);
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        if (!is_used(protocol, i)) {
            continue;
        }
        const Condition &condition = protocol.conditions[i];
        const std::optional<control::Tuning> tuning = free_space_tuning(protocol, condition);
        const std::string where = fmt::format("condition \"{}\"", condition.name);
        const std::string remedy =
            "lower free_space.lambda_rad_per_s, so that the lag is longer, or choose servo_hz and "
            "delay_periods nearer to the first condition's";
        if (!tuning) {
            findings.push_back({Severity::error, where,
                                fmt::format("at {:g} Hz with a delay of {:g} periods no filter has "
                                            "the lag of the shared free-space tuning",
                                            condition.servo_hz, condition.delay_periods),
                                remedy});
        } else if (!control::lies_in_range(lambda, *tuning)) {
            findings.push_back({Severity::error, where,
                                fmt::format("the lag of the shared free-space tuning needs lambda "
                                            "{:.0f} rad/s at {:g} Hz; it must be from {:g} to {:g}",
                                            tuning->lambda_rad_per_s, condition.servo_hz,
                                            lambda.minimum, lambda.maximum),
                                remedy});
        }
    }
}

/// Without it: all must be alike.
void check_alike(ProtocolFindings &findings, const Protocol &protocol,
                 const device::DeviceDescription &device) {
    const std::vector<Presented> all = all_presented(protocol);
    for (const Presented &one : all) {
        const Condition &first = all.front().parameters;
        const double before_s = lag_s(first, first.tuning);
        const double now_s = lag_s(one.parameters, one.parameters.tuning);
        const bool same_dR = one.parameters.tuning.dR_Ohm == first.tuning.dR_Ohm;
        if (same_dR && std::abs(now_s - before_s) <= kSameLag * before_s) {
            continue;
        }
        const auto added_g = [&](const Condition &condition) {
            const control::Coupling c =
                control::coupling(device.motor[1], condition.tuning, 1.0 / condition.servo_hz,
                                  condition.delay_periods);
            const double lever_m = device.geometry.upper_arm_m;
            const double N = device.geometry.transmission_ratio[1];
            return 1e3 * c.added_inertia_kg_m2 * N * N / (lever_m * lever_m);
        };
        findings.push_back(
            {Severity::error, name_of(protocol, one),
             fmt::format("can be told from {} in free space: dR {:g} against {:g} Ω and lag {:.2f} "
                         "against {:.2f} ms, some {:.1f} g against {:.1f} g",
                         name_of(protocol, all.front()), one.parameters.tuning.dR_Ohm,
                         first.tuning.dR_Ohm, 1e3 * now_s, 1e3 * before_s, added_g(one.parameters),
                         added_g(first)),
             "add [free_space] with the dR and lambda that all share there, or declare "
             "free_space_is_stimulus = true"});
        return;
    }
}

/// A blow is over within some hundredths of a second.
void check_blows(ProtocolFindings &findings, const Protocol &protocol) {
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        const Condition &condition = protocol.conditions[i];
        const std::optional<control::Tuning> free = free_space_tuning(protocol, condition);
        if (!is_used(protocol, i) || !free ||
            (free->dR_Ohm == condition.tuning.dR_Ohm &&
             free->lambda_rad_per_s == condition.tuning.lambda_rad_per_s)) {
            continue;
        }
        findings.push_back(
            {Severity::warning, fmt::format("condition \"{}\"", condition.name),
             fmt::format("has dR {:g} Ω and lambda {:g} rad/s, but a blow is felt with those of "
                         "free space, {:g} Ω and {:g} rad/s, before it could glide",
                         condition.tuning.dR_Ohm, condition.tuning.lambda_rad_per_s, free->dR_Ohm,
                         free->lambda_rad_per_s),
             "give it the tuning of [free_space], or declare free_space_is_stimulus = true"});
    }
}

/// As many hands between as `tune` tries: one motor at a time, and all three.
constexpr int kGripsOneMotor = 41;
constexpr int kGripsThreeMotors = 9;

/// The shares of the way from the tuning in free space to that in contact.
constexpr std::array kWay{0.25, 0.5, 0.75, 1.0};

/// A loop that is unstable.
struct Unstable {
    double eigenvalue = 0.0;
    std::string hand;
    std::string where; ///< "in contact"
};

/// In free space a mass without friction coasts: its eigenvalue is 1.
bool is_unstable(const loops::WorstMember &worst, double eta) {
    const double round_off = eta < 1.0 ? -loops::kEigenvalueRoundOff : loops::kEigenvalueRoundOff;
    return worst.eigenvalue >= 1.0 + round_off;
}

std::optional<Unstable> first_unstable(loops::StabilityCase which, const std::string &where) {
    for (const loops::Freedom freedom : {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
        which.freedom = freedom;
        which.hands = loops::hand_family(freedom == loops::Freedom::one_motor ? kGripsOneMotor
                                                                              : kGripsThreeMotors);
        const loops::WorstMember worst = loops::worst_member(which);
        if (is_unstable(worst, which.tuning.eta)) {
            return Unstable{worst.eigenvalue, loops::hand_text(worst.member.hand.name), where};
        }
    }
    return std::nullopt;
}

loops::StabilityCase case_of(const StudySetting &setting, const Presented &one) {
    loops::StabilityCase which;
    which.device = setting.device;
    which.tuning = one.parameters.tuning;
    if (which.tuning.alpha_mode == control::AlphaMode::global) {
        which.tuning.alpha_mode = control::AlphaMode::by_hand; // the loops would search for it anew
        which.tuning.alpha_rad2_per_m2 = setting.global_alpha_rad2_per_m2;
    }
    which.period_s = 1.0 / one.parameters.servo_hz;
    which.delay_periods = one.parameters.delay_periods;
    const Vector3 &point_m = setting.conditions[one.condition].spot.point_m;
    which.q_rad = device::joint_angles_rad(setting.device.geometry, point_m)
                      .value_or(device::default_pose_rad());
    return which;
}

/// All loops of one stimulus, with K_P and K_D larger by a factor.
std::optional<Unstable> unstable_loop(const StudySetting &setting, const Presented &one,
                                      double gain) {
    const PlacedCondition &place = setting.conditions[one.condition];
    loops::StabilityCase which = case_of(setting, one);
    which.tuning.K_P_V_per_rad *= gain;
    which.tuning.K_D_Vs_per_rad *= gain;
    const control::Tuning contact = which.tuning;
    const double surface_eta = one.parameters.hold == Hold::cup ? 0.0 : place.surface_eta;
    const double eta = 1.0 - (1.0 - surface_eta) * (1.0 - contact.eta);
    const bool glides = one.free_space.dR_Ohm != contact.dR_Ohm ||
                        one.free_space.lambda_rad_per_s != contact.lambda_rad_per_s;
    which.tuning.dR_Ohm = one.free_space.dR_Ohm;
    which.tuning.lambda_rad_per_s = one.free_space.lambda_rad_per_s;
    which.tuning.eta = 1.0;
    if (gain == 1.0) { // no gain acts in free space
        if (std::optional<Unstable> bad = first_unstable(which, "in free space"); bad) {
            return bad;
        }
    }
    which.tuning.eta = eta;
    if (place.surface == nullptr) {
        return std::nullopt;
    }
    if (glides) {
        if (std::optional<Unstable> bad =
                first_unstable(which, "in contact, before it glides to its own tuning");
            bad) {
            return bad;
        }
    }
    for (const double share : kWay) {
        if (share < 1.0 && !glides) {
            continue;
        }
        const auto between = [share](double from, double to) { return from + share * (to - from); };
        which.tuning.dR_Ohm = between(one.free_space.dR_Ohm, contact.dR_Ohm);
        which.tuning.lambda_rad_per_s =
            between(one.free_space.lambda_rad_per_s, contact.lambda_rad_per_s);
        if (std::optional<Unstable> bad = first_unstable(
                which, share < 1.0 ? "on the glide to its own tuning" : "in contact");
            bad) {
            return bad;
        }
    }
    return std::nullopt;
}

ProtocolFinding finding_of(const Protocol &protocol, const Presented &one, const Unstable &bad,
                           double gain) {
    const control::Tuning &tuning = one.parameters.tuning;
    const std::string of = fmt::format(
        "K_P {:g} V/rad, K_D {:g} V·s/rad, λ {:g} rad/s, dR {:g} Ω, {:g} Hz, delay {:g}",
        tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad, tuning.lambda_rad_per_s, tuning.dR_Ohm,
        one.parameters.servo_hz, one.parameters.delay_periods);
    if (gain > 1.0) {
        return {Severity::warning, name_of(protocol, one),
                fmt::format("is within a factor {:g} on its gains of being unstable {} with {} "
                            "({})",
                            gain, bad.where, bad.hand, of),
                "lower K_P_V_per_rad or K_D_Vs_per_rad; `springdrive tune` keeps a margin of 1.3"};
    }
    return {Severity::error, name_of(protocol, one),
            fmt::format("is unstable {} with {}: the largest eigenvalue is {:.4f} ({})", bad.where,
                        bad.hand, bad.eigenvalue, of),
            "lower K_P_V_per_rad or K_D_Vs_per_rad, or raise servo_hz; `springdrive tune` finds "
            "the stiffest that is stable"};
}

constexpr double kLongWithoutBreak_s = 900.0;

void check_length(ProtocolFindings &findings, const Protocol &protocol,
                  const SessionLength &length) {
    const double longest_s = 60.0 * protocol.stopping.longest_session_min;
    if (length.min_s > longest_s) {
        findings.push_back(
            {Severity::error, "session",
             fmt::format("takes {:.0f} min at the least, with {} trials and all breaks; it ends "
                         "after {:g} min",
                         length.min_s / 60.0, length.min_trials,
                         protocol.stopping.longest_session_min),
             "ask for fewer trials, shorten timing or breaks, or raise "
             "stopping.longest_session_min"});
    } else if (length.max_s > longest_s) {
        findings.push_back(
            {Severity::warning, "session",
             fmt::format("may take up to {:.0f} min, with {} trials; it ends after {:g} min",
                         length.max_s / 60.0, length.max_trials,
                         protocol.stopping.longest_session_min),
             "lower the most trials of the method, or raise stopping.longest_session_min"});
    }
    if (length.longest_without_break_s > kLongWithoutBreak_s) {
        findings.push_back({Severity::warning, "breaks",
                            fmt::format("leave the hand up to {:.0f} min without a rest",
                                        length.longest_without_break_s / 60.0),
                            fmt::format("lower breaks.every_trials; {:g} min are long",
                                        kLongWithoutBreak_s / 60.0)});
    }
}

void check_order(ProtocolFindings &findings, const Protocol &protocol) {
    const auto blocks = static_cast<int>(protocol.blocks.size());
    if (blocks < 2) {
        return;
    }
    const std::string_view kind =
        kCounterbalancingNames[static_cast<std::size_t>(protocol.counterbalancing)];
    const int balanced = participants_to_balance(protocol.counterbalancing, blocks);
    if (balanced == 1) {
        findings.push_back({Severity::warning, "counterbalancing",
                            fmt::format("is {}: blocks that come late may differ by practice or "
                                        "fatigue alone",
                                        kind),
                            "choose balanced_latin_square or full"});
    } else if (const int over = protocol.participants % balanced; over != 0) {
        findings.push_back(
            {Severity::warning, "participants",
             fmt::format("are {}; orders of {} blocks by {} are balanced with a multiple of {}",
                         protocol.participants, blocks, kind, balanced),
             fmt::format("plan for {}", protocol.participants + balanced - over)});
    }
}

void check_expectation(ProtocolFindings &findings, const Protocol &protocol) {
    if (!protocol.expected) {
        return;
    }
    const std::vector<double> levels = presentable_levels(protocol);
    const double threshold = protocol.expected->threshold;
    if (threshold < levels.front() || threshold > levels.back()) {
        findings.push_back({Severity::warning, "method",
                            fmt::format("presents levels from {:g} to {:g}; the threshold that is "
                                        "expected, {:g}, lies outside",
                                        levels.front(), levels.back(), threshold),
                            "move the levels about it"});
    }
}

/// A restart of the servo takes the pause between two intervals.
void check_pause(ProtocolFindings &findings, const Protocol &protocol) {
    if (restarts_within_trial(protocol) && protocol.timing.pause_s < kRestart_s) {
        findings.push_back(
            {Severity::error, "timing",
             fmt::format("has a pause of {:g} s; between intervals of different servo rate, delay "
                         "or scene the servo starts anew, in {:g} s",
                         protocol.timing.pause_s, kRestart_s),
             fmt::format("raise timing.pause_s to {:g} or more", kRestart_s)});
    }
}

/// Of rows that have names: conditions, blocks, questions.
template <typename Rows>
void check_names_of(ProtocolFindings &findings, std::string_view what, const Rows &rows) {
    for (auto row = rows.begin(); row != rows.end(); ++row) {
        const auto before = std::find_if(rows.begin(), row, [row](const auto &other) {
            return look_alike(other.name, row->name);
        });
        if (before != row) {
            findings.push_back({Severity::error, fmt::format("{} \"{}\"", what, row->name),
                                fmt::format("has a name like \"{}\": they differ only by blanks, "
                                            "case or the form of their letters",
                                            before->name),
                                "give it one that nobody takes for the other"});
        }
    }
}

/// Of a table's cell, to be made: two powers and logarithms. 40 to 75 ns on the machines that were
/// tried, up to 230 on a busy one.
constexpr double kTableCell_s = 100e-9;

/// Each as `try_stimulus` does, on all processors.
std::vector<StimulusTrial> try_conditions(const Protocol &protocol, const StudySetting &setting,
                                          const std::vector<Presented> &presented) {
    std::vector<StimulusTrial> trials(presented.size());
    for_each_in_parallel(presented.size(), all_processors(), [&](std::size_t i) {
        trials[i] = try_stimulus(protocol, setting, presented[i]);
    });
    return trials;
}

bool has_errors(const ProtocolFindings &findings) {
    return std::ranges::any_of(findings, [](const ProtocolFinding &finding) {
        return finding.severity == Severity::error;
    });
}

void add(ProtocolFindings &all, ProtocolFindings more) {
    std::ranges::move(more, std::back_inserter(all));
}

/// Only of conditions whose spot can be used.
std::vector<Presented> usable(const std::vector<Presented> &all, const StudySetting &setting) {
    std::vector<Presented> some;
    std::ranges::copy_if(all, std::back_inserter(some), [&setting](const Presented &one) {
        const PlacedCondition &place = setting.conditions[one.condition];
        return place.problem.empty() &&
               device::can_reach(setting.device,
                                 place.spot.point_m + kApproach_m * place.spot.normal);
    });
    return some;
}

} // namespace

ProtocolFindings check_names(const Protocol &protocol) {
    ProtocolFindings findings;
    check_names_of(findings, "condition", protocol.conditions);
    check_names_of(findings, "block", protocol.blocks);
    check_names_of(findings, "question", protocol.questionnaire);
    for (const QuestionnaireItem &item : protocol.questionnaire) {
        for (const char *const own : {"participant_id", "session_id", "MeasurementToolMetadata"}) {
            if (look_alike(item.name, own)) { // beside which no column of BIDS may have its name
                findings.push_back({Severity::error, fmt::format("question \"{}\"", item.name),
                                    "has the name of something that exported answers have anyway",
                                    "give it another"});
            }
        }
    }
    return findings;
}

ProtocolFindings check_choices(const Protocol &protocol) {
    const auto *const method = std::get_if<QuestPlus>(&protocol.method);
    if (method == nullptr) {
        return {};
    }
    const auto size = [](const ProtocolBlock &block) { return block.conditions.size(); };
    const std::size_t conditions = size(std::ranges::max(protocol.blocks, {}, size));
    const double cells = table_cells(*method);
    const double takes_s = kTableCell_s * cells * static_cast<double>(conditions);
    if (takes_s <= kMaxChoice_s) {
        return {};
    }
    return {
        {Severity::error, "method",
         fmt::format("has {} levels and {:.0f} points of its grid: some {:.0f} ms for the first "
                     "level of a block of {} condition{}, while its window stands still; at "
                     "most {:.0f} ms",
                     method->levels.size(), cells / static_cast<double>(method->levels.size()),
                     1e3 * takes_s, conditions, conditions == 1 ? "" : "s", 1e3 * kMaxChoice_s),
         "lower points of threshold, slope or lapse: 41, 15 and 3 are enough"}};
}

ProtocolFindings check_spots(const Protocol &protocol, const StudySetting &setting) {
    ProtocolFindings findings;
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        const Condition &condition = protocol.conditions[i];
        const std::string where = fmt::format("condition \"{}\"", condition.name);
        if (!is_used(protocol, i)) {
            findings.push_back(
                {Severity::warning, where, "is in no block", "add it to a block, or leave it out"});
            continue;
        }
        const PlacedCondition &place = setting.conditions[i];
        if (!place.problem.empty()) {
            findings.push_back({Severity::error, where, place.problem, ""});
            continue;
        }
        if (std::string wrong = wrong_way(setting.device, place.spot, protocol.stimulus);
            !wrong.empty()) {
            findings.push_back(
                {Severity::error, where, std::move(wrong),
                 fmt::format("move the spot: a trial needs {:g} mm above it and {:g} mm below",
                             1e3 * kApproach_m, 1e3 * kBelow_m)});
        }
    }
    return findings;
}

ProtocolFindings check_free_space(const Protocol &protocol,
                                  const device::DeviceDescription &device) {
    ProtocolFindings findings;
    if (protocol.free_space_is_stimulus) {
        findings.push_back({Severity::note, "free space",
                            "is the stimulus: each condition is there with its own dR and lambda",
                            ""});
    } else if (protocol.free_space) {
        check_shared(findings, protocol);
    } else {
        check_alike(findings, protocol, device);
    }
    if (protocol.stimulus == StimulusForm::blow) {
        check_blows(findings, protocol);
    }
    return findings;
}

ProtocolFindings check_stability(const Protocol &protocol, const StudySetting &setting,
                                 const std::vector<Presented> &presented) {
    std::vector<std::optional<ProtocolFinding>> found(presented.size());
    for_each_in_parallel(presented.size(), all_processors(), [&](std::size_t i) {
        for (const double gain : {1.0, kGainMargin}) {
            if (const std::optional<Unstable> bad = unstable_loop(setting, presented[i], gain)) {
                found[i] = finding_of(protocol, presented[i], *bad, gain);
                return;
            }
        }
    });
    std::vector<StimulusFinding> findings;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (found[i]) {
            findings.push_back({presented[i].condition, std::move(*found[i])});
        }
    }
    return once_per_condition(findings);
}

ProtocolFindings check_session(const Protocol &protocol, const SessionLength &length) {
    ProtocolFindings findings;
    check_length(findings, protocol, length);
    check_order(findings, protocol);
    check_expectation(findings, protocol);
    check_pause(findings, protocol);
    return findings;
}

ProtocolFindings check_precision(const Protocol &protocol) {
    if (!protocol.expected) {
        return {
            {Severity::note, "precision", "to be expected is not known without [expected]", ""}};
    }
    const PsychometricFunction observer = expected_observer(protocol);
    PrecisionQuestion question = precision_question(protocol, observer);
    question.studies = 60; // a median width to within some 5 %
    question.trials = {usual_trials(protocol, observer)};
    if (const std::string wrong = validate(question, protocol.task); !wrong.empty()) {
        return {{Severity::warning, "precision", "cannot be reckoned: " + wrong,
                 "give [expected] a function that fits the method"}};
    }
    const Precision precision = precision_by_trials(question).front();
    const bool ratios = question.analysis.family.scale == Scale::logarithmic;
    const double width = ratios ? std::exp(precision.median_width) : precision.median_width;
    return {{Severity::note, "precision",
             fmt::format("a participant's threshold in a condition is known to within {} {:.3g} "
                         "(95 % interval, from end to end, in the median), with {} trials and "
                         "observers as expected",
                         ratios ? "a factor of" : "a width of", width, precision.trials),
             ""}};
}

ProtocolFindings findings_of(const Protocol &protocol, const std::vector<StimulusTrial> &trials) {
    ProtocolFindings findings;
    for (const StimulusTrial &trial : trials) {
        if (!trial.trip.empty()) {
            findings.push_back({Severity::error, trial.name,
                                "the safety monitor trips in simulation: " + trial.trip,
                                "make the stimulus weaker, or softer"});
            continue;
        }
        if (protocol.stimulus != StimulusForm::stroke && !trial.has_touched) {
            findings.push_back({Severity::error, trial.name,
                                "the simulated hand never touches the surface",
                                "move the spot, or turn its normal out of the surface"});
        }
        if (trial.has_touched && trial.failure != StimulusFailure::none) {
            findings.push_back({Severity::error, trial.name,
                                fmt::format("with a simulated hand {}", description(trial.failure)),
                                "make the stimulus weaker, or turn it less"});
        }
        if (trial.stimulus.hold != Hold::cup && trial.delivered.aside_m > kMaxSlide_m) {
            findings.push_back({Severity::error, trial.name,
                                fmt::format("a simulated hand slides {:.1f} mm off the spot; at "
                                            "most {:g} mm",
                                            1e3 * trial.delivered.aside_m, 1e3 * kMaxSlide_m),
                                "choose a flatter spot, press less, or set hold = \"cup\""});
        }
        if (trial.shaking_m_per_s > kMaxShaking_m_per_s) {
            findings.push_back({Severity::error, trial.name,
                                fmt::format("the tip shakes with {:.0f} mm/s while a simulated "
                                            "hand holds still; at most {:g} mm/s",
                                            1e3 * trial.shaking_m_per_s, 1e3 * kMaxShaking_m_per_s),
                                "lower K_P_V_per_rad or K_D_Vs_per_rad"});
        }
        if (trial.delivered.is_limited) {
            findings.push_back({Severity::warning, trial.name,
                                fmt::format("the servo holds its force back in simulation; the "
                                            "largest is {:.2f} N",
                                            trial.delivered.peak_force_N),
                                "make the stimulus weaker, or it is not what it says"});
        }
    }
    return findings;
}

CheckedProtocol check_protocol(const Protocol &protocol, const ProtocolFolders &folders,
                               const CheckOptions &options) {
    const StudySetting setting = study_setting(protocol, folders);
    const std::vector<Presented> presented = all_presented(protocol);
    CheckedProtocol checked;
    const double warm_up_s = predicted_warm_up_s(protocol, setting);
    checked.length = session_length(protocol, std::isfinite(warm_up_s) ? warm_up_s : 0.0);
    ProtocolFindings &findings = checked.findings;
    add(findings, check_names(protocol));
    ProtocolFindings choices = check_choices(protocol);
    const bool is_quick = choices.empty();
    add(findings, std::move(choices));
    add(findings, check_spots(protocol, setting));
    add(findings, check_free_space(protocol, setting.device));
    add(findings, check_stability(protocol, setting, presented));
    add(findings, check_limits(protocol, setting, presented));
    SessionWarmth warmth = check_warmth(protocol, setting, presented, checked.length);
    if (!std::isfinite(warm_up_s)) {
        findings.push_back(
            {Severity::error, "windings",
             fmt::format("cannot be warmed to {:g} °C in {:g} min, with air of {:g} °C",
                         protocol.windings.from_C, WarmUp::kMax_s / 60.0, protocol.windings.air_C),
             "lower windings.from_C, or raise windings.to_C"});
    }
    checked.hottest_winding_C = warmth.hottest_C;
    add(findings, std::move(warmth.findings));
    add(findings, check_marking(protocol, setting, presented));
    add(findings, check_session(protocol, checked.length));
    if (options.simulates && !has_errors(findings)) {
        checked.trials = try_conditions(protocol, setting, usable(extremes(presented), setting));
        add(findings, findings_of(protocol, checked.trials));
    } else if (options.simulates) {
        findings.push_back({Severity::note, "simulation",
                            "was left out: it comes when the errors are mended", ""});
    }
    if (is_quick) { // it simulates studies
        add(findings, check_precision(protocol));
    }
    std::ranges::stable_sort(findings, {}, &ProtocolFinding::severity);
    return checked;
}

std::string text_of(const ProtocolFinding &finding) {
    constexpr std::array<std::string_view, 3> kNames{"error", "warning", "note"};
    std::string text(kNames[static_cast<std::size_t>(finding.severity)]);
    text += ": " + finding.where + ": " + finding.what;
    return finding.remedy.empty() ? text : text + "; " + finding.remedy;
}

} // namespace springdrive::study
