#include "app/commands/command.h"
#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/figures/gnuplot.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/print.h"
#include "base/table.h"
#include "base/text.h"
#include "device/core/device_file.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/tuning.h"
#include "engine/lab/limits/method_limits/experiment.h"
#include "engine/lab/limits/stability_limits.h"
#include "engine/lab/loops/passivity.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive::app {

namespace {

/// The option of a parameter: `--delay` and `--servo-hz` set d and T.
std::string option_of(const loops::StabilityParameter &parameter) {
    return parameter.name == "d"   ? "--delay"
           : parameter.name == "T" ? "--servo-hz"
                                   : "--" + std::string(parameter.name);
}

bool is_of_hand(const loops::StabilityParameter &parameter) {
    return parameter.name.starts_with("hand");
}

void check(const std::string &option, const loops::StabilityParameter &parameter, double value) {
    if (const std::string wrong = validate(parameter, value); !wrong.empty()) {
        throw InputError(option + ": " + wrong);
    }
}

/// @throw InputError if the parameter does not affect the case, such as gains of a current drive.
void check_that_it_counts(const std::string &option, const loops::StabilityParameter &parameter,
                          const loops::StabilityCase &which) {
    const std::string_view name = parameter.name;
    const bool current = which.drive == device::AmplifierKind::current_drive;
    const bool without_hand = which.hands.size() == 1 && which.hands.front().mass_kg == 0.0 &&
                              which.hands.front().stiffness_N_per_m == 0.0;
    const auto refuse = [&](const std::string &why) {
        const bool own = option == option_of(parameter);
        throw InputError(option + (own ? "" : " " + std::string(name)) + ": " + why);
    };
    if (current && (name == "kp" || name == "kd" || name == "dR" || name == "alpha")) {
        refuse("applies to a spring drive; omit --drive current");
    }
    if (!current && name.starts_with("wall")) {
        refuse("applies to a current drive; add --drive current");
    }
    if (name == "alpha" && which.tuning.map == control::MotionMap::inverse) {
        refuse("applies to the transpose map (23); omit --kinematics inverse");
    }
    const bool own_load = name == "inertia" || name == "damping";
    if (own_load && which.freedom == loops::Freedom::three_motors) {
        refuse("applies to one motor by itself; omit --motors 3");
    }
    if (own_load && !which.is_rigid()) {
        refuse("applies to rigid links; omit --structure");
    }
    if (without_hand && is_of_hand(parameter)) {
        refuse("there is no hand; omit --no-hand");
    }
}

/// A parameter by its name. @throw InputError that lists all names.
const loops::StabilityParameter &typed_parameter(const std::string &option,
                                                 const std::string &name) {
    const loops::StabilityParameter *parameter = loops::stability_parameter_named(name);
    if (parameter == nullptr) {
        throw InputError(option + ": there is no \"" + name + "\"; it must be one of " +
                         loops::names_of_stability_parameters());
    }
    return *parameter;
}

/// A range of it. @throw InputError if it is outside the parameter's range, or empty.
void check_parameter_range(const std::string &option, const loops::StabilityParameter &parameter,
                           double from, double to) {
    for (const double value : {from, to}) {
        check(option + ", from or to", parameter, value);
    }
    if (!(from < to)) {
        throw InputError(
            fmt::format("{}: {} from {:g} to {:g}: the first must be below the second, "
                        "both from {:g} to {:g}",
                        option, parameter.name, from, to, parameter.minimum, parameter.maximum));
    }
}

/// @throw InputError for a text that `--structure` does not know
std::vector<loops::Structure> structures_of(const std::string &text) {
    if (text == "all") {
        return loops::all_structures();
    }
    if (text == "rigid") {
        return {loops::Structure{}};
    }
    const std::optional<double> cable_share = text == "tip"     ? 0.0
                                              : text == "cable" ? 1.0
                                              : text == "split" ? 0.5
                                                                : number_in<double>(text);
    if (!cable_share || !(*cable_share >= 0.0 && *cable_share <= 1.0)) {
        throw InputError("--structure " + text +
                         ": must be rigid, cable, tip, split, all, or the cable's share, 0 to 1");
    }
    return {{cable_share}};
}

/// Options that define a loop.
struct StabilityOptions {
    std::filesystem::path device_file;
    std::filesystem::path tuning_file;         ///< empty: the default tuning
    std::vector<std::optional<double>> values; ///< of `stability_parameters()`
    std::optional<double> servo_hz;
    std::string kinematics; ///< empty: as in the tuning
    std::string drive = "spring";
    int motors = 1;
    std::vector<double> q_deg = default_joint_angles_deg();
    bool no_hand = false;
    std::string structure = "rigid";

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(Command &command);

    /// All except those of the device, its configuration and its hands.
    [[nodiscard]] static std::vector<std::string> options_of_drive_and_servo();

    /// @throw InputError for a value out of its range, with the range.
    [[nodiscard]] loops::StabilityCase stability_case() const;
};

void StabilityOptions::add_to(Command &command) {
    add_device_file_option(command, device_file);
    add_tuning_file_option(command, tuning_file);
    values.resize(loops::stability_parameters().size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        const loops::StabilityParameter &parameter = loops::stability_parameters()[i];
        if (parameter.name == "T") {
            command.add_option("--servo-hz", servo_hz, "servo rate, 1 to 100000 [1000]")
                .type_name("HZ");
            continue;
        }
        command.add_option(option_of(parameter), values[i], std::string(parameter.help))
            .type_name(parameter.unit == "–" ? "VALUE" : std::string(parameter.unit));
    }
    add_motion_map_option(command, "--kinematics", kinematics, " [as tuned]");
    command
        .add_option("--drive", drive,
                    "spring: the paper's; current: a conventional virtual wall [spring]")
        .one_of({"spring", "current"});
    command
        .add_option("--motors", motors,
                    "1: each motor by itself; 3: the whole linkage, its tip held at a point [1]")
        .one_of_numbers({1, 3});
    add_joint_angles_option(command, q_deg);
    command.add_flag("--no-hand", no_hand,
                     "without a hand [all must be stable: no hand, and five from light to "
                     "firm]");
    command
        .add_option("--structure", structure,
                    "where the device's compliance is: rigid, cable, tip, split, the cable's "
                    "share of it, or all: every one must be stable [rigid]")
        .type_name("PLACE");
}

std::vector<std::string> StabilityOptions::options_of_drive_and_servo() {
    std::vector<std::string> options{"--tuning-file", "--kinematics", "--drive", "--motors",
                                     "--structure"};
    for (const loops::StabilityParameter &parameter : loops::stability_parameters()) {
        if (!is_of_hand(parameter)) {
            options.push_back(option_of(parameter));
        }
    }
    return options;
}

loops::StabilityCase StabilityOptions::stability_case() const {
    loops::StabilityCase which;
    which.device = device::read_device_file(device_file);
    which.tuning = tuning_of(tuning_file);
    which.drive = drive == "spring" ? device::AmplifierKind::spring_drive
                                    : device::AmplifierKind::current_drive;
    which.freedom = motors == 1 ? loops::Freedom::one_motor : loops::Freedom::three_motors;
    which.wall = {300.0, 2.0}; // firm enough to be felt, stable on both devices at 1 kHz
    if (!kinematics.empty()) {
        which.tuning.map = *control::motion_map_named(kinematics);
    }
    which.q_rad = joint_angles_rad(q_deg);
    rig::check_configuration(which.device, which.q_rad);
    if (servo_hz) {
        check_range("--servo-hz", *servo_hz, 1.0, 1e5);
        which.period_s = 1.0 / *servo_hz;
    }
    if (no_hand) {
        which.hands = {loops::no_hand()};
    }
    which.structures = structures_of(structure);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const loops::StabilityParameter &parameter = loops::stability_parameters()[i];
        if (!values[i]) {
            continue;
        }
        check(option_of(parameter), parameter, *values[i]);
        check_that_it_counts(option_of(parameter), parameter, which);
        parameter.set(which, *values[i]);
    }
    warn_about_margins(tuning_file, 1.0 / which.period_s, which.delay_periods);
    return which;
}

struct StabilityReport {
    loops::StabilityCase which;
    loops::WorstMember worst;
    bool stable_simulated = true; ///< with counts and supply
    /// Of a spring drive, at any η; nothing of a current drive.
    std::optional<loops::LeastAtPort> passive;
    loops::LeastAtPort linear_hands; ///< the same
    const loops::StabilityParameter *varied = nullptr;
    limits::ParameterRange range;
    std::vector<limits::StabilityLimit> limits;
    /// By the prediction; nothing if there are limits, or no parameter varies.
    std::optional<bool> stable_throughout;

    /// By both.
    [[nodiscard]] bool is_stable() const { return worst.is_stable() && stable_simulated; }
};

using Json = nlohmann::ordered_json;

/// Whether trials have none of the structures asked for.
bool tries_rigid_links(const loops::StabilityCase &which) {
    return !which.is_rigid() && limits::as_tried(which).is_rigid();
}

std::string who(const loops::StabilityCase &which, const loops::LoopMember &member) {
    if (which.rotor) {
        return "the motor given, " + loops::hand_text(member.hand.name);
    }
    return (which.freedom == loops::Freedom::three_motors
                ? "all motors, "
                : "motor " + std::to_string(member.motor + 1) + ", ") +
           loops::hand_text(member.hand.name) +
           (which.is_rigid() ? "" : ", " + loops::structure_text(member.structure));
}

void write_setting(std::ostream &out, const StabilityReport &report) {
    const loops::StabilityCase &which = report.which;
    const control::Tuning &tuning = which.tuning;
    print(out, "{}, servo {:.6g} Hz, delay {:g}, ", which.device.name, 1.0 / which.period_s,
          which.delay_periods);
    if (which.drive == device::AmplifierKind::current_drive) {
        print(out, "current drive: wall K {:.4g} N/m, B {:.4g} N·s/m, λ {:.4g} rad/s\n",
              which.wall.stiffness_N_per_m, which.wall.damping_Ns_per_m, tuning.lambda_rad_per_s);
    } else {
        print(out, "spring drive: dR {:.4g} Ω, K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, ",
              which.dR_Ohm(which.device.motor[0]), tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad);
        print(out, "λ {:.4g} rad/s, η {:.3g}, {}\n", tuning.lambda_rad_per_s, tuning.eta,
              control::label_of(tuning.map));
    }
    print(out, "hands: {}, ", which.hands.size());
    out << (which.rotor ? "one motor with a given inertia"
            : which.freedom == loops::Freedom::three_motors
                ? "the whole linkage, its tip held at a point"
                : "each motor by itself")
        << "\n\n";
}

/// Colgate and Schenkel's limit K = 2b/T, for a delay of d periods and an amplifier of bandwidth ω:
/// 2b/(T(1 + 2d) + 2/ω), for a motor of a current drive without a hand and without B; the minimum
/// over all motors [N/m at the tip].
double passive_wall_N_per_m(const loops::StabilityCase &which) {
    loops::StabilityCase each = which;
    each.freedom = loops::Freedom::one_motor;
    each.hands = {loops::no_hand()};
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const double late_s =
        which.period_s * (1.0 + 2.0 * which.delay_periods) +
        2.0 / (2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz);
    double minimum = HUGE_VAL;
    for (const loops::LoopMember &member : loops::members(each)) {
        const double b = loops::driven_load(each, member).damping_Nms_per_rad(0, 0);
        minimum = std::min(minimum, 2.0 * b / late_s / J.col(member.motor).squaredNorm());
    }
    return minimum;
}

void write_verdict(std::ostream &out, const StabilityReport &report) {
    print(out, "predicted  {:<8}  largest eigenvalue {:.6f} ({})\n",
          report.worst.is_stable() ? "stable" : "UNSTABLE", report.worst.eigenvalue,
          who(report.which, report.worst.member));
    print(out, "simulated  {:<8}  released 1 mm aside, with encoder counts and supply limits{}\n",
          report.stable_simulated ? "stable" : "UNSTABLE",
          tries_rigid_links(report.which) ? ", rigid links" : "");
    if (report.passive) {
        print(out, "coupling   {}\n", loops::port_text(*report.passive, report.linear_hands));
    }
    if (report.which.drive == device::AmplifierKind::current_drive) {
        print(out,
              "2b/(T(1 + 2d) + 2/ω)  {:.4g} N/m at the tip: Colgate and Schenkel's limit for a "
              "heavy device without hand and B,\n",
              passive_wall_N_per_m(report.which));
        out << "           with a delay of d periods and this amplifier's bandwidth ω; minimum of "
               "all motors\n";
    }
    if (report.worst.is_stable() && !report.stable_simulated) {
        out << "           they differ because encoder counts sustain a slowly decaying motion\n";
    }
}

/// To the prediction.
Cell ratio(const std::optional<double> &found, const limits::StabilityLimit &limit) {
    return found && limit.predicted != 0.0 ? Cell(*found / limit.predicted) : Cell();
}

void write_limits(std::ostream &out, const StabilityReport &report) {
    const loops::StabilityParameter &varied = *report.varied;
    print(out, "\n{} from {:.5g} to {:.5g} {}: ", varied.symbol, report.range.from, report.range.to,
          varied.unit);
    if (report.stable_throughout) {
        out << "no limit within it, predicted "
            << (*report.stable_throughout ? "stable" : "unstable") << " throughout\n";
        return;
    }
    out << (report.limits.size() == 1 ? "one limit\n\n" : "more than one limit\n\n");
    Table table = Table::with_columns(
        "stable,predicted:.6g,no effects:.5g,ratio:.3f,counts and supply:.5g,ratio:.3f,"
        "+ friction:.5g,ratio:.3f,limited by");
    for (const limits::StabilityLimit &limit : report.limits) {
        std::vector<Cell> row{limit.stable_below ? "up to" : "from", limit.predicted};
        for (const std::optional<double> &found :
             {limit.simulated_linear, limit.simulated, limit.simulated_all}) {
            row.emplace_back(found);
            row.push_back(ratio(found, limit));
        }
        loops::StabilityCase there = report.which;
        varied.set(there, limit.predicted);
        row.emplace_back(who(there, limit.worst));
        table.rows.push_back(std::move(row));
    }
    write_text(out, table);
    if (tries_rigid_links(report.which)) {
        out << "\nSimulations of one motor have rigid links: limits with structure are predicted "
               "only.\n";
        return;
    }
    out << "\nEach simulated limit is followed by its ratio to the prediction. Counts can sustain\n"
           "a slowly decaying motion, and cease to do so farther on: the limit given is the first\n"
           "from the stable side. Friction stops small motions. Slow motions are simulated for\n"
           "up to 30 s; one that grows by less than some 0.05/s can be mistaken for a decaying\n"
           "one.\n";
}

/// At rest, along the vertical.
struct FeltStiffness {
    loops::Structure structure;
    double vertical_N_per_m = 0.0;
};

/// Rendered, that is on rigid links, and felt behind the structures of the case, or where these are
/// rigid, behind either end of what is not known of the device's.
std::vector<FeltStiffness> felt_stiffness(const loops::StabilityCase &which) {
    std::vector<loops::Structure> structures{{}};
    const auto &asked =
        which.is_rigid() ? std::vector<loops::Structure>{{1.0}, {0.0}} : which.structures;
    std::ranges::copy_if(asked, std::back_inserter(structures),
                         [](const auto &structure) { return structure.cable_share.has_value(); });
    std::vector<FeltStiffness> felt;
    for (const loops::Structure &structure : structures) {
        felt.push_back({structure, loops::felt_at_rest_N_per_m(which, structure)(1, 1)});
    }
    return felt;
}

void write_felt_stiffness(std::ostream &out, const loops::StabilityCase &which) {
    const std::vector<FeltStiffness> felt = felt_stiffness(which);
    print(out, "stiffness  {:.3g} N/mm rendered at rest, vertically at the tip; felt",
          1e-3 * felt.front().vertical_N_per_m);
    for (std::size_t i = 1; i < felt.size(); ++i) {
        print(out, "{} {:.3g} ({})", i == 1 ? "" : ",", 1e-3 * felt[i].vertical_N_per_m,
              loops::structure_text(felt[i].structure));
    }
    out << '\n';
}

Json felt_json(const loops::StabilityCase &which) {
    Json json;
    for (const FeltStiffness &felt : felt_stiffness(which)) {
        json.push_back({{"structure", loops::structure_text(felt.structure)},
                        {"vertical_N_per_m", felt.vertical_N_per_m}});
    }
    return json;
}

Json found_json(const std::optional<double> &found) { return found ? Json(*found) : Json(nullptr); }

Json finite_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json throughout_json(const std::optional<bool> &stable) {
    return stable ? Json(*stable ? "stable" : "unstable") : Json(nullptr);
}

Json member_json(const loops::StabilityCase &which, const loops::LoopMember &member) {
    const bool one = which.freedom == loops::Freedom::one_motor && !which.rotor;
    return {{"motor", one ? Json(member.motor + 1) : Json(nullptr)},
            {"hand", member.hand.name},
            {"hand_mass_kg", member.hand.mass_kg},
            {"hand_damping_Ns_per_m", member.hand.damping_Ns_per_m},
            {"hand_stiffness_N_per_m", member.hand.stiffness_N_per_m},
            {"structure", loops::structure_text(member.structure)}};
}

void write_stability_table(std::ostream &out, const StabilityReport &report) {
    write_setting(out, report);
    write_verdict(out, report);
    if (!report.which.rotor) {
        write_felt_stiffness(out, report.which);
    }
    if (report.varied != nullptr) {
        write_limits(out, report);
    }
}

/// One object; missing values are null.
void write_stability_json(std::ostream &out, const StabilityReport &report) {
    Json json;
    json["stable"] = report.is_stable();
    json["predicted"] = {{"stable", report.worst.is_stable()},
                         {"largest_eigenvalue", report.worst.eigenvalue},
                         {"worst", member_json(report.which, report.worst.member)}};
    json["simulated"] = {{"stable", report.stable_simulated}};
    json["stiffness"] = report.which.rotor ? Json(nullptr) : felt_json(report.which);
    json["coupling"] = report.passive
                           ? Json{{"passive", report.passive->holds()},
                                  {"stable_with_every_linear_hand", report.linear_hands.holds()},
                                  {"least_absorbed", finite_json(report.passive->value)},
                                  {"at_rad_per_s", report.passive->omega_rad_per_s},
                                  {"at_eta", 1.0 - report.passive->held}}
                           : Json(nullptr);
    if (report.varied != nullptr) {
        json["vary"] = report.varied->name;
        json["unit"] = report.varied->unit;
        json["from"] = report.range.from;
        json["to"] = report.range.to;
        json["throughout"] = throughout_json(report.stable_throughout);
        json["limits"] = Json::array();
        for (const limits::StabilityLimit &limit : report.limits) {
            json["limits"].push_back(
                {{"stable", limit.stable_below ? "below" : "above"},
                 {"predicted", limit.predicted},
                 {"simulated_without_effects", found_json(limit.simulated_linear)},
                 {"simulated", found_json(limit.simulated)},
                 {"simulated_with_friction", found_json(limit.simulated_all)},
                 {"ratio", limit.simulated && limit.predicted != 0.0
                               ? Json(*limit.simulated / limit.predicted)
                               : Json(nullptr)},
                 {"limited_by", member_json(report.which, limit.worst)}});
        }
    }
    out << json_text(json) << '\n';
}

constexpr int kUnstable = 3; ///< exit status: completed, and the loop is unstable
constexpr int kMaxStepsPerAxis = 400;

struct TypedStability {
    StabilityOptions loop;
    std::string vary; ///< empty: nothing is varied
    std::optional<double> from;
    std::optional<double> to;
    std::vector<std::string> map; ///< empty, or two names
    int steps = 40;
    std::filesystem::path out; ///< of a map
    bool table = false;
    std::string csv;  ///< of the table; empty: Markdown for people
    std::string json; ///< empty: text for people
    Existing existing = Existing::keep;

    [[nodiscard]] RunFiles files(std::vector<std::filesystem::path> written) const {
        return {{loop.device_file, loop.tuning_file}, {}, std::move(written)};
    }
};

StabilityReport report_of(const TypedStability &typed) {
    StabilityReport report;
    report.which = typed.loop.stability_case();
    report.worst = loops::worst_member(report.which);
    report.stable_simulated = limits::is_stable_simulated(
        report.which, limits::TrialOptions::with(limits::SimulationEffects::electronics()));
    if (report.which.drive == device::AmplifierKind::spring_drive) {
        report.passive = loops::passivity(report.which);
        report.linear_hands = loops::stability_with_linear_hands(report.which);
    }
    if (!typed.vary.empty()) {
        report.varied = &typed_parameter("--vary", typed.vary);
        check_that_it_counts("--vary", *report.varied, report.which);
        report.range = {typed.from.value_or(report.varied->from),
                        typed.to.value_or(report.varied->to)};
        check_parameter_range("--vary", *report.varied, report.range.from, report.range.to);
        report.limits = limits::stability_limits(report.which, *report.varied, report.range);
        if (report.limits.empty()) { // then all values of the range are alike
            loops::StabilityCase first = report.which;
            report.varied->set(first, report.range.from);
            report.stable_throughout = loops::is_stable(first);
        }
    }
    return report;
}

void write_stability(const TypedStability &typed) {
    check_outputs(typed.files({typed.json}), typed.existing);
    const StabilityReport report = report_of(typed);
    write_report([&](std::ostream &out) { write_stability_table(out, report); },
                 {{typed.json, [&](std::ostream &out) { write_stability_json(out, report); }}},
                 typed.existing);
    if (!report.is_stable()) {
        end_with_status(kUnstable);
    }
}

/// `kp`, or `kp=0.5:50`.
limits::MapAxis axis_of(const std::string &text, int steps) {
    const std::size_t equals = text.find('=');
    limits::MapAxis axis;
    axis.parameter = &typed_parameter("--map", text.substr(0, equals));
    axis.range = {axis.parameter->from, axis.parameter->to};
    axis.steps = steps;
    if (equals != std::string::npos) {
        std::istringstream numbers(text.substr(equals + 1));
        char colon = '\0';
        if (!(numbers >> axis.range.from >> colon >> axis.range.to) || colon != ':' ||
            numbers.peek() != std::char_traits<char>::eof()) {
            throw InputError("--map " + text + ": a range is written as NAME=FROM:TO");
        }
    }
    check_parameter_range("--map", *axis.parameter, axis.range.from, axis.range.to);
    return axis;
}

/// The hands: those of the family, or a single one if a property of the hand varies.
std::string hands_text(const loops::StabilityCase &which, bool is_one) {
    const std::size_t without_hand = which.hands.front().mass_kg == 0.0 ? 1 : 0;
    const std::size_t hands = which.hands.size() - without_hand;
    if (is_one || hands == 1) {
        return "one hand";
    }
    return hands == 0 ? "no hand" : "no hand and " + std::to_string(hands) + " hands";
}

std::string loop_text(const loops::StabilityCase &which, bool alpha_varies, bool is_one_hand) {
    const control::MotionMap map = alpha_varies ? control::MotionMap::transpose : which.tuning.map;
    std::string text = which.drive == device::AmplifierKind::current_drive
                           ? "current drive"
                           : "spring drive, " + std::string(control::label_of(map));
    text += which.freedom == loops::Freedom::one_motor ? ", each motor by itself"
                                                       : ", all motors together";
    return text + ", " + hands_text(which, is_one_hand) +
           (which.is_rigid()           ? ""
            : tries_rigid_links(which) ? ", compliant structure (trials: rigid links)"
                                       : ", compliant structure");
}

/// The settings of a map, for the lines below its title.
struct MapSetting {
    std::string values; ///< the device, and fixed parameters
    std::string loop;   ///< its drive and hands
};

/// For gnuplot, in which an underscore begins an index.
std::string symbol_of(const loops::StabilityParameter &parameter) {
    const std::string symbol(parameter.symbol);
    const std::size_t line = symbol.find('_');
    return line == std::string::npos
               ? symbol
               : symbol.substr(0, line) + "_{" + symbol.substr(line + 1) + "}";
}

std::string axis_label(const loops::StabilityParameter &parameter) {
    return symbol_of(parameter) +
           (parameter.unit == "–" ? "" : "  (" + std::string(parameter.unit) + ")");
}

/// Half a cell, by which a picture extends beyond the outermost values.
void add_axis(ChartMarks &marks, const std::string &name, const limits::MapAxis &axis) {
    const std::vector<double> values = axis.values();
    const bool by_ratio = axis.is_logarithmic();
    const double first = by_ratio ? std::log10(values.front()) : values.front();
    const double last = by_ratio ? std::log10(values.back()) : values.back();
    const double half = 0.5 * (last - first) / static_cast<double>(values.size() - 1);
    marks.add(name + "_label", axis_label(*axis.parameter));
    marks.add(name + "_by_ratio", by_ratio ? 1.0 : 0.0);
    marks.add(name + "_first", first - half);
    marks.add(name + "_last", last + half);
}

/// The legend if a line is missing because all cells are on one side of it.
std::string instead_of_a_line(const std::string &line, std::size_t stable, std::size_t all) {
    return stable == all ? line + ": stable everywhere"
           : stable == 0 ? line + ": stable nowhere"
                         : "";
}

/// A header and a row for each cell.
std::string csv_of(const limits::MapAxis &x, const limits::MapAxis &y,
                   const std::vector<limits::MapCell> &cells) {
    std::string csv = fmt::format("{},{},largest_eigenvalue,stable_simulated,remaining_m_per_s\n",
                                  x.parameter->name, y.parameter->name);
    const std::size_t columns = x.values().size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const limits::MapCell &cell = cells[i];
        fmt::format_to(std::back_inserter(csv), "{:.9g},{:.9g},{:.9g},{:d},{:.9g}\n", cell.x,
                       cell.y, cell.eigenvalue, cell.stable, cell.remaining_m_per_s);
        if ((i + 1) % columns == 0) {
            csv += '\n'; // gnuplot's separator between rows of a grid
        }
    }
    return csv;
}

/// The map as a picture, and its numbers beside it, these first.
/// @throw InputError for what cannot be written or drawn
void draw_stability_map(const std::filesystem::path &svg, const MapSetting &setting,
                        const limits::MapAxis &x, const limits::MapAxis &y,
                        const std::vector<limits::MapCell> &cells, Existing existing) {
    write_output(
        numbers_of(svg).string(), [&](std::ostream &out) { out << csv_of(x, y, cells); }, existing);
    ChartMarks marks;
    marks.add("heading", "Stability over " + std::string(x.parameter->symbol) + " and " +
                             std::string(y.parameter->symbol));
    marks.add("setting", setting.values);
    marks.add("loop", setting.loop);
    add_axis(marks, "x", x);
    add_axis(marks, "y", y);
    const auto predicted = static_cast<std::size_t>(std::ranges::count_if(
        cells, [](const limits::MapCell &cell) { return cell.eigenvalue < 1.0; }));
    const auto by_trial =
        static_cast<std::size_t>(std::ranges::count_if(cells, &limits::MapCell::stable));
    marks.add("no_predicted_line", instead_of_a_line("predicted", predicted, cells.size()));
    marks.add("no_trial_line", instead_of_a_line("by trial", by_trial, cells.size()));
    draw_numbers(svg, "stability_map", marks, existing);
}

/// The parameters that are constant over the map.
MapSetting setting_of(const loops::StabilityCase &which, const limits::MapAxis &x,
                      const limits::MapAxis &y) {
    const auto varies = [&](std::string_view start) {
        return x.parameter->name.starts_with(start) || y.parameter->name.starts_with(start);
    };
    std::string text = which.device.name;
    const bool spring = which.drive == device::AmplifierKind::spring_drive;
    std::vector<std::string_view> shown =
        spring ? std::vector<std::string_view>{"T", "d", "dR", "kp", "kd", "lambda", "eta"}
               : std::vector<std::string_view>{"T",      "d",  "wall-stiffness", "wall-damping",
                                               "lambda", "eta"};
    if (varies("hand")) {
        for (const std::string_view name : {"hand-mass", "hand-damping", "hand-stiffness"}) {
            shown.push_back(name);
        }
    }
    for (const std::string_view name : shown) {
        const loops::StabilityParameter &parameter = *loops::stability_parameter_named(name);
        if (&parameter != x.parameter && &parameter != y.parameter) {
            fmt::format_to(std::back_inserter(text), ", {} {:g}", parameter.symbol,
                           parameter.get(which));
            text += parameter.unit == "–" ? "" : " " + std::string(parameter.unit);
        }
    }
    return {text, loop_text(which, varies("alpha"), varies("hand"))};
}

void draw_map(const TypedStability &typed) {
    const loops::StabilityCase which = typed.loop.stability_case();
    const limits::MapAxis x = axis_of(typed.map[0], typed.steps);
    const limits::MapAxis y = axis_of(typed.map[1], typed.steps);
    for (const limits::MapAxis *axis : {&x, &y}) {
        check_that_it_counts("--map", *axis->parameter, which);
    }
    if (x.parameter == y.parameter) {
        throw InputError("--map: names the same parameter twice; it takes two");
    }
    check_range("--steps", typed.steps, 2, kMaxStepsPerAxis);
    if (typed.out.extension() != ".svg") {
        throw InputError("--out " + typed.out.string() + ": must be a file that ends in .svg");
    }
    check_outputs(typed.files({typed.out, numbers_of(typed.out)}), typed.existing);
    std::vector<limits::MapCell> cells;
    {
        ProgressLine line;
        cells = limits::stability_map(which, x, y, [&](double share) { line.show("map", share); });
    }
    draw_stability_map(typed.out, setting_of(which, x, y), x, y, cells, typed.existing);
}

void write_table(const TypedStability &typed) {
    check_outputs(typed.files({typed.csv}), typed.existing);
    const loops::StabilityCase which = typed.loop.stability_case();
    std::vector<limits::MethodLimit> lines;
    {
        ProgressLine line;
        lines = limits::method_limits(which, [&](double share) { line.show("limits", share); });
    }
    write_report(
        [&](std::ostream &out) { write_markdown(out, limits::method_limits_document(lines)); },
        {{typed.csv,
          [&](std::ostream &out) { write_csv(out, limits::method_limits_table(lines)); }}},
        typed.existing);
}

void run(const TypedStability &typed) {
    if (typed.table) {
        write_table(typed);
    } else if (typed.map.empty()) {
        write_stability(typed);
    } else {
        draw_map(typed);
    }
}

} // namespace

void add_stability_command(Command &app) {
    Command stability = app.add_subcommand(
        "stability", "whether a loop is stable, and its limits, predicted and simulated");
    const auto typed = std::make_shared<TypedStability>();
    typed->loop.add_to(stability);
    Option vary = stability
                      .add_option("--vary", typed->vary,
                                  "find limits of: " + loops::names_of_stability_parameters())
                      .type_name("NAME");
    stability.add_option("--from", typed->from, "lowest value of the range")
        .type_name("VALUE")
        .needs(vary);
    stability.add_option("--to", typed->to, "highest value of the range")
        .type_name("VALUE")
        .needs(vary);
    Option out =
        stability
            .add_option("--out", typed->out, "the map's picture; its numbers are written beside it")
            .type_name("FILE.svg");
    Option map = stability
                     .add_option("--map", typed->map,
                                 "a map over two parameters of --vary, each NAME or NAME=FROM:TO")
                     .type_name("A,B")
                     .delimiter(',')
                     .expected(2)
                     .needs(out)
                     .excludes(vary);
    out.needs(map);
    stability.add_option("--steps", typed->steps, "values of each parameter in a map [40]")
        .type_name("N")
        .needs(map);
    Option table =
        stability
            .add_flag("--table", typed->table,
                      "where every method fails, predicted and measured, as a Markdown table")
            .excludes(vary)
            .excludes(map);
    for (const std::string &option : StabilityOptions::options_of_drive_and_servo()) {
        table.excludes(stability.get_option(option)); // each row has its own
    }
    add_output_option(stability, "--csv", typed->csv, "the table as CSV, with all digits,")
        .needs(table);
    add_output_option(stability, "--json", typed->json, "JSON").excludes(map).excludes(table);
    add_force_option(stability, typed->existing);
    stability.footer(
        "Whether it is stable:  springdrive stability --kp 20 --dR 0.2\n"
        "Its limits:            springdrive stability --vary kp\n"
        "A map of it:           springdrive stability --map kp=1:100,dR --out map.svg\n"
        "Exit status: 0 stable, 3 unstable, 1 or 2 for invalid input.");
    stability.callback([typed] { run(*typed); });
}

} // namespace springdrive::app
