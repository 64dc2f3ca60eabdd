#include "app/commands/study/observer_options.h"

#include "base/input_error.h"
#include "engine/study/methods/random_key.h"
#include "engine/study/protocol/session_plan.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>

namespace springdrive::app {

namespace {

// Names of facts. Thresholds are levels, in the unit of the variable under test.
constexpr std::string_view kThreshold = "observer_threshold";
constexpr std::string_view kSlope = "observer_slope";
constexpr std::string_view kGuess = "observer_guess";
constexpr std::string_view kLapse = "observer_lapse";
constexpr std::string_view kShape = "observer_shape";
constexpr std::string_view kScale = "observer_scale";
constexpr std::string_view kSeed = "observer_seed";
constexpr std::string_view kFelt = "observer_felt";
constexpr std::string_view kFeltOnce = "measured_once";
constexpr std::string_view kLogarithmic = "logarithmic";

template <typename Value>
std::optional<Value> fact(const study::Session &session, std::string_view name) {
    const auto found = std::ranges::find(session.facts, name, &study::Setting::name);
    if (found == session.facts.end() || !std::holds_alternative<Value>(found->value)) {
        return std::nullopt;
    }
    return std::get<Value>(found->value);
}

} // namespace

void add_observer_options(Command &command, TypedObserver &typed) {
    command
        .add_option("--threshold", typed.threshold,
                    "of the simulated observer: a level, in its unit [as the protocol expects]")
        .type_name("LEVEL");
    command
        .add_option("--slope", typed.slope,
                    "of the observer's psychometric function, see docs/study_methods.md "
                    "[as the protocol expects]")
        .type_name("NUMBER");
    command
        .add_option("--lapse", typed.lapse,
                    "share of the observer's answers that are blind [as the protocol expects]")
        .type_name("SHARE");
}

study::PsychometricFunction observer_of(const TypedObserver &typed,
                                        const study::Protocol &protocol) {
    if (!protocol.expected && !(typed.threshold && typed.slope)) {
        throw InputError("the protocol has no [expected], which would describe a simulated "
                         "observer; type --threshold and --slope");
    }
    study::PsychometricFunction function;
    if (protocol.expected) {
        function = study::expected_observer(protocol);
    } else {
        function.family = study::analysis_family(protocol);
        function.guess = study::guess_range(protocol.task).minimum;
    }
    function.threshold = typed.threshold.value_or(function.threshold);
    function.slope = typed.slope.value_or(function.slope);
    function.lapse = typed.lapse.value_or(function.lapse);
    if (const std::string wrong = study::validate(function); !wrong.empty()) {
        throw InputError("simulated observer: " + wrong);
    }
    return function;
}

SimulatedObserver participant_of_group(const study::PsychometricFunction &typical, double spread,
                                       std::uint64_t seed, int number) {
    enum class Drawn : std::uint64_t { threshold, answers };
    const study::RandomKey key = study::key_of(seed, number);
    const auto drawn = [key](Drawn what) {
        return study::child(key, static_cast<std::uint64_t>(what));
    };
    const double z = study::standard_normal(drawn(Drawn::threshold));
    const study::Scale scale = typical.family.scale;
    SimulatedObserver observer{typical, drawn(Drawn::answers).bits, {}};
    if (spread > 0.0) {
        observer.function.threshold =
            study::level_from(scale, study::on_scale(scale, typical.threshold) + spread * z);
    }
    return observer;
}

std::vector<study::Setting> facts_of(const SimulatedObserver &observer) {
    const study::PsychometricFunction &function = observer.function;
    const auto shape = static_cast<std::size_t>(function.family.shape);
    const bool is_linear = function.family.scale == study::Scale::linear;
    return {{std::string(kThreshold), function.threshold},
            {std::string(kSlope), function.slope},
            {std::string(kGuess), function.guess},
            {std::string(kLapse), function.lapse},
            {std::string(kShape), std::string(study::kShapeNames[shape])},
            {std::string(kScale), std::string(is_linear ? "linear" : kLogarithmic)},
            {std::string(kSeed), std::to_string(observer.seed)},
            {std::string(kFelt),
             std::string(observer.felt == study::FeltStimuli::measured_once ? kFeltOnce
                                                                            : "each_simulated")}};
}

std::optional<SimulatedObserver> observer_in(const study::Session &session) {
    const auto threshold = fact<double>(session, kThreshold);
    const auto slope = fact<double>(session, kSlope);
    const auto guess = fact<double>(session, kGuess);
    const auto lapse = fact<double>(session, kLapse);
    const auto shape = fact<std::string>(session, kShape);
    const auto scale = fact<std::string>(session, kScale);
    const auto seed = fact<std::string>(session, kSeed);
    const auto felt = fact<std::string>(session, kFelt);
    if (!threshold || !slope || !guess || !lapse || !shape || !scale || !seed || !felt) {
        return std::nullopt;
    }
    const auto named = std::ranges::find(study::kShapeNames, *shape);
    SimulatedObserver observer;
    if (named == study::kShapeNames.end() ||
        std::from_chars(seed->data(), seed->data() + seed->size(), observer.seed).ec !=
            std::errc{}) {
        return std::nullopt;
    }
    observer.function = {
        {static_cast<study::Shape>(named - study::kShapeNames.begin()),
         *scale == kLogarithmic ? study::Scale::logarithmic : study::Scale::linear},
        *threshold,
        *slope,
        *guess,
        *lapse};
    observer.felt =
        *felt == kFeltOnce ? study::FeltStimuli::measured_once : study::FeltStimuli::each_simulated;
    return observer;
}

std::optional<bool> is_person(const study::StudyContents &contents, std::string_view participant) {
    const auto first =
        std::ranges::find(contents.sessions, participant, &study::Session::participant);
    return first == contents.sessions.end() ? std::nullopt
                                            : std::optional(!observer_in(*first).has_value());
}

} // namespace springdrive::app
