#include "engine/study/results/progress.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace springdrive::study {

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
