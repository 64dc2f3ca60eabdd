#include "engine/study/export/answer_table.h"

#include <algorithm>
#include <iterator>

namespace springdrive::study {

Table answer_table(const StudyContents &contents, const std::vector<QuestionnaireItem> &items,
                   const std::vector<DeviceKind> &devices) {
    Table table = Table::with_columns("participant,participant_number,session,device_kind,when,"
                                      "item,kind,question,answer,at_utc");
    for (const QuestionnaireAnswer &answer : contents.answers) {
        const Session &session = session_of(contents, answer.session);
        if (std::ranges::count(devices, session.device) == 0) {
            continue;
        }
        const auto item = std::ranges::find(items, answer.item, &QuestionnaireItem::name);
        const bool is_known = item != items.end();
        using Place = std::size_t;
        table.rows.push_back(
            {answer.participant, participant_of(contents, answer.participant).number, session.id,
             name_of(session.device),
             is_known ? kQuestionnaireTimeNames[static_cast<Place>(item->when)] : "", answer.item,
             is_known ? kQuestionnaireKindNames[static_cast<Place>(item->kind)] : "",
             answer.question, answer.answer, utc_text(answer.at)});
    }
    return table;
}

std::vector<std::string> answers_of(const StudyContents &contents,
                                    const std::vector<QuestionnaireItem> &items,
                                    SessionId session) {
    std::vector<std::string> answers(items.size());
    for (const QuestionnaireAnswer &answer : contents.answers) {
        const auto item = std::ranges::find(items, answer.item, &QuestionnaireItem::name);
        if (answer.session == session && item != items.end()) {
            answers[static_cast<std::size_t>(item - items.begin())] = answer.answer;
        }
    }
    return answers;
}

std::vector<QuestionnaireAnswer> answers_on(const StudyContents &contents, DeviceKind device) {
    std::vector<QuestionnaireAnswer> answers;
    std::ranges::copy_if(contents.answers, std::back_inserter(answers),
                         [&](const QuestionnaireAnswer &answer) {
                             return session_of(contents, answer.session).device == device;
                         });
    return answers;
}

} // namespace springdrive::study
