#include "app/commands/study/status_report.h"

#include "app/commands/study/observer_options.h"
#include "base/print.h"
#include "base/table.h"
#include "base/text.h"
#include "engine/study/protocol/session_plan.h"

#include <algorithm>

namespace springdrive::app {

namespace {

std::string devices_text(const std::vector<study::DeviceKind> &devices) {
    std::string text;
    for (const study::DeviceKind device : devices) {
        text += (text.empty() ? "" : ", ") + std::string(study::name_of(device));
    }
    return text.empty() ? "-" : text;
}

/// "block 1 of 2 (\"right and left\"), trial 61; stopped"
std::string stand_of(const study::Protocol &protocol, const study::StudyContents &contents,
                     const study::Progress &progress) {
    std::string text;
    if (!progress.next) {
        const bool is_asked = is_person(contents, progress.participant).value_or(false);
        text = progress.has_open_questions && is_asked ? "through, but for questions" : "through";
    } else {
        const study::PlannedTrial &next = *progress.next;
        text = fmt::format("block {} of {} (\"{}\"), trial {}", next.place.block,
                           protocol.blocks.size(), protocol.blocks[progress.next_block].name,
                           next.place.position);
        if (progress.sessions == 0) {
            text = "not begun";
        } else if (!progress.last_ending) {
            text += "; running, or interrupted";
        } else if (*progress.last_ending != study::SessionEnding::completed) {
            text += "; " + std::string(study::name_of(*progress.last_ending));
        }
    }
    if (progress.blocks_unfinished > 0) {
        text += fmt::format("; {} block{} ended by too many marked trials",
                            progress.blocks_unfinished, progress.blocks_unfinished == 1 ? "" : "s");
    }
    return text;
}

/// "questions: 7 answers: hand 4, tiring 3; 4 sessions", of a protocol that asks some.
void write_answers(std::ostream &out, const OpenedStudy &study) {
    const std::vector<study::QuestionnaireItem> &items = study.protocol.questionnaire;
    if (items.empty() && study.contents.answers.empty()) {
        return;
    }
    print(out, "questions: {} answers", study.contents.answers.size());
    for (const study::QuestionnaireItem &item : items) {
        print(out, "{}{} {}", &item == &items.front() ? ": " : ", ", item.name,
              std::ranges::count(study.contents.answers, item.name,
                                 &study::QuestionnaireAnswer::item));
    }
    print(out, "; {} sessions\n", study.contents.sessions.size());
}

void write_records(std::ostream &out, const study::StudyContents &contents,
                   const std::vector<std::string> &wrong) {
    const auto linked = std::ranges::count_if(
        contents.trials, [](const study::Trial &trial) { return trial.record.has_value(); });
    if (linked == 0) {
        out << "servo records: none\n";
        return;
    }
    print(out, "servo records: {}, {}\n", linked,
          wrong.empty() ? std::string("all as they were linked")
                        : fmt::format("{} with a problem:", wrong.size()));
    for (const std::string &line : wrong) {
        out << "  " << line << '\n';
    }
}

} // namespace

void write_study_status(std::ostream &out, const std::filesystem::path &file,
                        const OpenedStudy &study, const std::vector<study::Progress> &participants,
                        const std::vector<std::string> &wrong_records) {
    const study::StudyFacts &facts = study.contents.facts;
    print(out, "{}: {}\n", file.string(), one_line(facts.title));
    print(out, "begun {} with springdrive {}\n\n", study::utc_text(facts.created),
          one_line(facts.software));
    Table table = Table::with_columns("participant,device,sessions,trials,practice,marked,at");
    int trials = 0;
    int marked = 0;
    for (const study::Progress &one : participants) {
        table.rows.push_back({one.participant, devices_text(one.devices), one.sessions, one.trials,
                              one.practice, one.marked,
                              stand_of(study.protocol, study.contents, one)});
        trials += one.trials;
        marked += one.marked;
    }
    write_text(out, table);
    const auto through = std::ranges::count_if(
        participants, [](const study::Progress &one) { return !one.next.has_value(); });
    const study::SessionLength length = study::session_length(study.protocol);
    print(out, "\nthrough: {} of {} participants of the protocol{}\n", through,
          study.protocol.participants,
          facts.removed_participants > 0
              ? fmt::format("; {} removed on request", facts.removed_participants)
              : std::string());
    print(out, "trials: {}, {} marked; each participant has {} to {} without the marked ones\n",
          trials, marked, length.min_trials, length.max_trials);
    write_answers(out, study);
    write_records(out, study.contents, wrong_records);
    for (const study::Note &note : study.contents.notes) {
        print(out, "{}: {}{}: {}\n", one_line(note.kind), study::utc_text(note.at),
              note.participant ? " " + *note.participant : std::string(), one_line(note.text));
    }
}

} // namespace springdrive::app
