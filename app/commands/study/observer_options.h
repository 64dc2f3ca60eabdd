// Simulated observers, as they are typed and as a study's sessions remember them.
#pragma once

#include "app/commands/command.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/observers/simulated_study_session.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/store/study_contents.h"

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace springdrive::app {

/// What is not typed is as the protocol expects.
struct TypedObserver {
    std::optional<double> threshold;
    std::optional<double> slope;
    std::optional<double> lapse;

    [[nodiscard]] bool is_typed() const { return threshold || slope || lapse; }
};

/// `--threshold`, `--slope` and `--lapse`.
void add_observer_options(Command &command, TypedObserver &typed);

/// The psychometric function that was typed.
/// @throw InputError where neither the options nor the protocol's [expected] say it, and for values
///        that make no function
[[nodiscard]] study::PsychometricFunction observer_of(const TypedObserver &typed,
                                                      const study::Protocol &protocol);

/// Somebody whose answers are drawn.
struct SimulatedObserver {
    study::PsychometricFunction function;
    std::uint64_t seed = 0;
    study::FeltStimuli felt = study::FeltStimuli::each_simulated;
};

/// One of a group: the threshold is drawn for the participant's number.
/// @param spread  standard deviation between participants on the function's scale: of ln threshold
///                on a logarithmic one, in the level's unit on a linear one
[[nodiscard]] SimulatedObserver participant_of_group(const study::PsychometricFunction &typical,
                                                     double spread, std::uint64_t seed, int number);

/// For the facts of a session, so that the next one has the same observer.
[[nodiscard]] std::vector<study::Setting> facts_of(const SimulatedObserver &observer);

/// Nothing if the session had no simulated observer.
[[nodiscard]] std::optional<SimulatedObserver> observer_in(const study::Session &session);

/// Whether a person sat in the participant's sessions, which are all a person's or all a simulated
/// observer's. Nothing before the first.
[[nodiscard]] std::optional<bool> is_person(const study::StudyContents &contents,
                                            std::string_view participant);

} // namespace springdrive::app
