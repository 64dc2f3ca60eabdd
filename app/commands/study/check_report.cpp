#include "app/commands/study/check_report.h"

#include "base/print.h"
#include "base/table.h"

#include <cstddef>

namespace springdrive::app {

namespace {

Cell range(int fewest, int most) { return Cell::like_number(fmt::format("{}-{}", fewest, most)); }

Cell minutes(double fewest_s, double most_s) {
    return Cell::like_number(fmt::format("{:.1f}-{:.1f}", fewest_s / 60.0, most_s / 60.0));
}

void write_length(std::ostream &out, const study::Protocol &protocol,
                  const study::SessionLength &length) {
    Table table = Table::with_columns("block,trials,min");
    for (std::size_t i = 0; i < length.blocks.size(); ++i) {
        const study::BlockLength &block = length.blocks[i];
        table.rows.push_back({protocol.blocks[i].name,
                              range(block.fewest_trials, block.most_trials),
                              minutes(block.fewest_s, block.most_s)});
    }
    if (!protocol.questionnaire.empty()) {
        table.rows.push_back(
            {"questions", "", minutes(length.fewest_questions_s, length.most_questions_s)});
    }
    table.rows.push_back({"session, with breaks", range(length.fewest_trials, length.most_trials),
                          minutes(length.fewest_s, length.most_s)});
    out << '\n';
    write_text(out, table);
}

void write_trials(std::ostream &out, const std::vector<study::StimulusTrial> &trials) {
    if (trials.empty()) {
        return;
    }
    Table table = Table::with_columns("simulated:,force N,slid mm,deep mm,given mJ", ".2f");
    for (const study::StimulusTrial &trial : trials) {
        const study::DeliveredStimulus &delivered = trial.delivered;
        table.rows.push_back({trial.name, delivered.peak_force_N, 1e3 * delivered.aside_m,
                              1e3 * delivered.deepest_m, 1e3 * delivered.generated_J});
    }
    out << '\n';
    write_text(out, table);
}

} // namespace

void write_study_check(std::ostream &out, const study::Protocol &protocol,
                       const study::CheckedProtocol &checked) {
    for (const study::ProtocolFinding &finding : checked.findings) {
        print(out, "{}\n", study::text_of(finding));
    }
    write_length(out, protocol, checked.length);
    print(out, "\nhottest winding of a session: {:.0f} °C\n", checked.hottest_winding_C);
    write_trials(out, checked.trials);
}

} // namespace springdrive::app
