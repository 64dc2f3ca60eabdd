#include "engine/study/conduct/conduct.h"

#include "base/input_error.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>
#include <variant>

namespace springdrive::study {

namespace {

constexpr std::string_view kLateness = "lateness_s";

/// "3.1 % off, more than 2 %"; empty within the band.
std::string off_by_more(double off, double most, std::string_view unit) {
    return off <= most ? std::string()
                       : fmt::format("{:.3g}{} off, more than {:g}{}", off, unit, most, unit);
}

std::string share_off_by_more(double delivered, double intended, double max_percent) {
    return off_by_more(100.0 * std::abs(delivered - intended) / std::abs(intended), max_percent,
                       " %");
}

/// Empty within its band, and of a value that has none.
std::string error_text_of(const Marking &marking, const StimulusValue &value) {
    const auto measure = std::ranges::find(kStimulusMeasures, value.name, &StimulusMeasure::name);
    const bool is_lateness = value.name == kLateness;
    if (!value.intended || (measure == kStimulusMeasures.end() && !is_lateness)) {
        return {};
    }
    if (!value.delivered) {
        return "was not measured";
    }
    if (is_lateness) {
        return off_by_more(*value.delivered, marking.lateness_s, " s");
    }
    switch (measure->band) {
    case Band::direction:
        return off_by_more(std::abs(*value.delivered - *value.intended), marking.direction_deg,
                           "°");
    case Band::stiffness:
        return share_off_by_more(*value.delivered, *value.intended, marking.stiffness_percent);
    case Band::force:
        break;
    }
    return share_off_by_more(*value.delivered, *value.intended, marking.force_percent);
}

Presented presented_of(const Protocol &protocol, std::size_t condition, std::optional<double> level,
                       Condition parameters, int target) {
    control::Tuning free_space =
        free_space_tuning(protocol, parameters).value_or(parameters.tuning);
    return {condition, level, std::move(parameters), free_space, target};
}

constexpr int kNobody = 0; ///< whose key draws what is the same for all participants

/// What is drawn from the key of a block.
enum class DrawnInBlock : std::uint64_t { sequence, trials };

RandomKey block_key(RandomKey participant, std::size_t place, DrawnInBlock what) {
    return child(child(participant, place), static_cast<std::uint64_t>(what));
}

bool presents_the_same(const PlannedTrial &one, const PlannedTrial &other) {
    return one.is_practice == other.is_practice && one.is_catch == other.is_catch &&
           one.condition == other.condition && one.track == other.track && one.level == other.level;
}

/// Names of tracks, from 1; empty where there is one only.
std::string track_name(const Method &method, int track) {
    const auto *staircases = std::get_if<Staircases>(&method);
    const bool has_several = staircases != nullptr && staircases->start_levels.size() > 1;
    return has_several ? std::to_string(track + 1) : std::string();
}

/// What is stored with it besides what came of it, and why it does not count.
void complete(Trial &trial, const Protocol &protocol, const Session &session, UtcTime at) {
    const bool was_broken_off = !trial.marks.empty() || !trial.safety_events.empty();
    trial.participant = session.participant;
    trial.session = session.id;
    trial.software = session.software;
    trial.at = at;
    trial.is_correct = is_correct(protocol.task, trial);
    for (std::string &mark : marks_of(protocol.marking, trial.presentations)) {
        trial.marks.push_back(std::move(mark));
    }
    for (const SafetyEvent &event : trial.safety_events) {
        trial.marks.push_back("the safety monitor tripped: " + event.text);
    }
    if (std::holds_alternative<NoResponse>(trial.response) && !was_broken_off) {
        trial.marks.push_back(
            fmt::format("no response in {:g} s", protocol.task.kind == TaskKind::adjustment
                                                     ? protocol.timing.presentation_s
                                                     : protocol.timing.response_s));
    }
    trial.is_presented_again =
        trial.is_presented_again || comes_again(protocol.marking, trial.marks, trial.response);
}

SessionEnding run_trials(StudyStore &store, const Protocol &protocol, const Session &session,
                         const Conduct &how) {
    RunningSession running(store, protocol, session);
    while (const std::optional<PlannedTrial> planned = running.next()) {
        if (const std::optional<SessionEnding> ending = how.ends()) {
            return *ending;
        }
        std::optional<Trial> trial = how.present(*planned);
        if (!trial) {
            return how.ends().value_or(SessionEnding::device_lost);
        }
        if (const auto ending = running.add(*std::move(trial), how.now())) {
            return *ending;
        }
    }
    return SessionEnding::completed;
}

} // namespace

std::vector<std::string> marks_of(const Marking &marking,
                                  std::span<const Presentation> presentations) {
    std::vector<std::string> marks;
    for (std::size_t i = 0; i < presentations.size(); ++i) {
        for (const StimulusValue &value : presentations[i].values) {
            const std::string error = error_text_of(marking, value);
            if (!error.empty()) {
                marks.push_back(fmt::format("{} of presentation {}: {}", value.name, i + 1, error));
            }
        }
    }
    return marks;
}

bool comes_again(const Marking &marking, const std::vector<std::string> &marks,
                 const Response &response) {
    return !marks.empty() && (marking.repeats || std::holds_alternative<NoResponse>(response));
}

std::size_t condition_of(const Protocol &protocol, const PlannedTrial &planned) {
    const auto found = std::ranges::find(protocol.conditions, planned.condition, &Condition::name);
    return static_cast<std::size_t>(found - protocol.conditions.begin());
}

Presented comparison_at(const Protocol &protocol, const PlannedTrial &planned, double level) {
    const std::size_t condition = condition_of(protocol, planned);
    const bool by_place = protocol.task.kind == TaskKind::forced_choice_by_place;
    const int target = by_place ? planned.target.value() - 1 : 0;
    return presented_of(protocol, condition, level, comparison(protocol, condition, level, target),
                        target);
}

std::vector<Presented> intervals_of(const Protocol &protocol, const PlannedTrial &planned) {
    const std::size_t condition = condition_of(protocol, planned);
    const int count = presentations_per_trial(protocol);
    const bool by_interval = protocol.task.kind == TaskKind::forced_choice_by_interval;
    const int at = by_interval ? planned.target.value() : count;
    std::vector<Presented> intervals(
        static_cast<std::size_t>(count),
        presented_of(protocol, standard_condition_of(protocol).value_or(condition), std::nullopt,
                     standard(protocol, condition), 0));
    intervals[static_cast<std::size_t>(at - 1)] =
        comparison_at(protocol, planned, planned.level.value());
    return intervals;
}

Presentation presentation_of(const StimulusMeasures &intended, const DeliveredStimulus &delivered) {
    Presentation presentation;
    presentation.start_s = delivered.start_s;
    presentation.end_s = delivered.end_s;
    for (const StimulusMeasure &measure : kStimulusMeasures) {
        const std::optional<double> planned = intended.*measure.value;
        const std::optional<double> came = delivered.measures.*measure.value;
        if (planned || came) {
            presentation.values.push_back({std::string(measure.name), planned, came});
        }
    }
    presentation.values.push_back({std::string(kLateness), 0.0, delivered.lateness_s});
    presentation.values.push_back({"peak_force_N", std::nullopt, delivered.peak_force_N});
    presentation.values.push_back({"aside_m", std::nullopt, delivered.aside_m});
    return presentation;
}

std::vector<Setting> settings_of(const Condition &condition) {
    std::vector<Setting> settings;
    settings.reserve(control::kParameters.size() + 4);
    for (const control::Parameter &gain : control::kParameters) {
        settings.push_back({std::string(gain.name), condition.tuning.*gain.value});
    }
    settings.push_back({"map", std::string(control::name_of(condition.tuning.map))});
    settings.push_back({"alpha_mode", std::string(control::name_of(condition.tuning.alpha_mode))});
    settings.push_back({"servo_hz", condition.servo_hz});
    settings.push_back({"delay_periods", condition.delay_periods});
    return settings;
}

Sequence::Sequence(const Protocol &protocol, int participant)
    : protocol_(protocol), key_(key_of(static_cast<std::uint64_t>(protocol.seed), participant)),
      order_(order_of(protocol.counterbalancing, static_cast<int>(protocol.blocks.size()),
                      participant, key_of(static_cast<std::uint64_t>(protocol.seed), kNobody))) {
    begin_block();
}

void Sequence::begin_block() {
    const std::size_t place = ended_.size();
    position_ = 1;
    marked_.clear();
    run_.reset();
    if (place < order_.size()) {
        run_.emplace(block_of(protocol_, static_cast<std::size_t>(order_[place]), place == 0),
                     block_key(key_, place, DrawnInBlock::sequence));
    }
}

std::optional<PlannedTrial> Sequence::next() const {
    const std::optional<BlockTrial> presented = run_ ? run_->next() : std::nullopt;
    return presented ? std::optional(planned_of(*presented)) : std::nullopt;
}

PlannedTrial Sequence::planned_of(const BlockTrial &presented) const {
    const std::size_t place = ended_.size();
    PlannedTrial trial;
    trial.place = {static_cast<int>(place) + 1, position_, 1};
    const ProtocolBlock &block = protocol_.blocks[static_cast<std::size_t>(order_[place])];
    const auto series = static_cast<std::size_t>(presented.series);
    trial.condition = protocol_.conditions[block.conditions[series]].name;
    trial.track = track_name(protocol_.method, presented.track);
    trial.is_practice = presented.kind == TrialKind::practice;
    trial.is_catch = presented.kind == TrialKind::catch_trial;
    trial.seed =
        child(block_key(key_, place, DrawnInBlock::trials), static_cast<std::uint64_t>(position_))
            .bits;
    trial.level_name = level_name_of(protocol_);
    trial.level = presented.level;
    if (is_forced_choice(protocol_.task.kind)) {
        trial.target = presented.target + 1;
    }
    const auto again = std::ranges::find_if(
        marked_, [&trial](const PlannedTrial &before) { return presents_the_same(before, trial); });
    if (again != marked_.end()) {
        trial.repetition_of = again->place;
    }
    return trial;
}

void Sequence::add(const Trial &trial) {
    const std::optional<BlockTrial> presented = run_ ? run_->next() : std::nullopt;
    const std::optional<PlannedTrial> planned =
        presented ? std::optional(planned_of(*presented)) : std::nullopt;
    if (!planned || *planned != trial) {
        throw InputError(fmt::format(
            "{} of participant {} is not what the study's protocol presents there: it was run with "
            "another protocol or version; keep this study as it is, and go on in a new one",
            text_of(trial.place), trial.participant));
    }
    if (planned->repetition_of) {
        std::erase_if(marked_, [&planned](const PlannedTrial &before) {
            return before.place == *planned->repetition_of;
        });
    }
    const Outcome outcome = outcome_of(protocol_, trial);
    if (outcome.marked) {
        marked_.push_back(*planned);
    }
    run_->add({*presented, outcome});
    ++position_;
    if (const BlockState state = run_->state(); state != BlockState::running) {
        ended_.push_back({static_cast<std::size_t>(order_[ended_.size()]), state});
        begin_block();
    }
}

std::string level_name_of(const Protocol &protocol) {
    switch (protocol.variable.level) {
    case LevelMeaning::added:
        return protocol.variable.parameter + "_added";
    case LevelMeaning::taken_off:
        return protocol.variable.parameter + "_taken_off";
    case LevelMeaning::value:
        break;
    }
    return protocol.variable.parameter;
}

std::string level_label(const Protocol &protocol) {
    const std::string unit(variable_of(protocol).unit);
    return level_name_of(protocol) + (unit == "–" ? std::string() : " [" + unit + "]");
}

std::optional<bool> is_correct(const Task &task, const Trial &trial) {
    const auto *chosen = std::get_if<Chosen>(&trial.response);
    if (!is_forced_choice(task.kind) || chosen == nullptr || !trial.target) {
        return std::nullopt;
    }
    return chosen->alternative == *trial.target;
}

Outcome outcome_of(const Protocol &protocol, const Trial &trial) {
    Outcome outcome;
    outcome.marked = trial.is_presented_again;
    if (const auto *answer = std::get_if<YesNo>(&trial.response)) {
        outcome.positive = answer->yes;
    } else if (const auto *adjusted = std::get_if<Adjusted>(&trial.response)) {
        outcome.setting = adjusted->level;
    } else {
        outcome.positive = is_correct(protocol.task, trial).value_or(false);
    }
    return outcome;
}

Sequence sequence_after(const Protocol &protocol, int participant, std::span<const Trial> trials) {
    Sequence sequence(protocol, participant);
    for (const Trial &trial : trials) {
        sequence.add(trial);
    }
    return sequence;
}

RunningSession::RunningSession(StudyStore &store, const Protocol &protocol, const Session &session)
    : store_(store), protocol_(protocol), session_(session),
      sequence_(sequence_after(protocol,
                               participant_of(store.contents(), session.participant).number,
                               trials_of(store.contents(), session.participant))) {}

std::optional<SessionEnding> RunningSession::add(Trial trial, UtcTime at) {
    const std::chrono::duration<double, std::ratio<60>> longest(
        protocol_.stopping.longest_session_min);
    trips_ += trial.safety_events.empty() ? 0 : 1;
    complete(trial, protocol_, session_, at);
    store_.append(trial);
    sequence_.add(trial);
    if (trips_ > protocol_.stopping.max_trips && sequence_.next()) {
        return SessionEnding::safety_trip;
    }
    if (at - session_.started > longest && sequence_.next()) {
        return SessionEnding::stopped;
    }
    return std::nullopt;
}

void end_as_failed(StudyStore &store, SessionId session, UtcTime at) {
    try {
        store.end(session, SessionEnding::failed, at);
    } catch (const InputError &) { // the store says at the next opening that it was interrupted
    }
}

SessionEnding conduct(StudyStore &store, const Protocol &protocol, const Session &session,
                      const Conduct &how) {
    try {
        const SessionEnding ending = run_trials(store, protocol, session, how);
        store.end(session.id, ending, how.now());
        return ending;
    } catch (const InputError &) {
        end_as_failed(store, session.id, how.now());
        throw;
    }
}

std::vector<QuestionnaireItem> open_questions(const Protocol &protocol,
                                              const StudyContents &contents,
                                              std::string_view participant,
                                              QuestionnaireTime when) {
    std::vector<QuestionnaireItem> open;
    std::ranges::copy_if(
        protocol.questionnaire, std::back_inserter(open), [&](const QuestionnaireItem &item) {
            return item.when == when &&
                   std::ranges::none_of(contents.answers, [&](const QuestionnaireAnswer &answer) {
                       return answer.participant == participant && answer.item == item.name;
                   });
        });
    return open;
}

std::vector<Progress> progress_of(const Protocol &protocol, const StudyContents &contents) {
    std::vector<Progress> all;
    for (const Participant &participant : contents.participants) {
        Progress progress;
        progress.participant = participant.code;
        progress.number = participant.number;
        for (const Session &session : contents.sessions) {
            if (session.participant != participant.code) {
                continue;
            }
            ++progress.sessions;
            progress.last_ending = session.ending;
            if (std::ranges::count(progress.devices, session.device) == 0) {
                progress.devices.push_back(session.device);
            }
        }
        const std::vector<Trial> trials = trials_of(contents, participant.code);
        progress.trials = static_cast<int>(trials.size());
        for (const Trial &trial : trials) {
            progress.practice += trial.is_practice ? 1 : 0;
            progress.marked += trial.marks.empty() ? 0 : 1;
        }
        const Sequence sequence = sequence_after(protocol, participant.number, trials);
        progress.next = sequence.next();
        if (progress.next) {
            progress.next_block =
                static_cast<std::size_t>(sequence.order()[sequence.ended().size()]);
        }
        progress.has_open_questions =
            !progress.next && progress.sessions > 0 &&
            progress.last_ending != SessionEnding::completed &&
            !open_questions(protocol, contents, participant.code, QuestionnaireTime::after).empty();
        progress.blocks_unfinished = static_cast<int>(
            std::ranges::count(sequence.ended(), BlockState::too_many_marked, &EndedBlock::state));
        all.push_back(std::move(progress));
    }
    return all;
}

} // namespace springdrive::study
