#include "engine/study/export/answer_table.h"

#include "base/print.h"

#include <algorithm>
#include <iterator>
#include <ostream>

namespace springdrive::study {

void write_answers_csv(const StudyContents &contents, const std::vector<QuestionnaireItem> &items,
                       const std::vector<DeviceKind> &devices, std::ostream &out) {
    out << "participant,participant_number,session,device_kind,when,item,kind,question,answer,"
           "at_utc\n";
    for (const QuestionnaireAnswer &answer : contents.answers) {
        const Session &session = session_of(contents, answer.session);
        if (std::ranges::count(devices, session.device) == 0) {
            continue;
        }
        const auto item = std::ranges::find(items, answer.item, &QuestionnaireItem::name);
        const bool is_known = item != items.end();
        using Place = std::size_t;
        print(out, "{},{},{},{},{},{},{},{},{},{}\n", answer.participant,
              participant_of(contents, answer.participant).number, session.id,
              name_of(session.device),
              is_known ? kQuestionnaireTimeNames[static_cast<Place>(item->when)] : "",
              csv_cell(answer.item),
              is_known ? kQuestionnaireKindNames[static_cast<Place>(item->kind)] : "",
              csv_cell(answer.question), csv_cell(answer.answer), utc_text(answer.at));
    }
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
