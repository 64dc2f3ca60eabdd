#include "app/commands/study/check_report.h"

#include "base/print.h"
#include "base/table.h"

#include <cstddef>

namespace springdrive::app {

namespace {

Cell range(int fewest, int most) { return Cell::like_number(fmt::format("{}-{}", fewest, most)); }

Cell minutes(double min_s, double max_s) {
    return Cell::like_number(fmt::format("{:.1f}-{:.1f}", min_s / 60.0, max_s / 60.0));
}

void write_length(std::ostream &out, const study::Protocol &protocol,
                  const study::SessionLength &length) {
    Table table = Table::with_columns("block,trials,min");
    for (std::size_t i = 0; i < length.blocks.size(); ++i) {
        const study::BlockLength &block = length.blocks[i];
        table.rows.push_back({protocol.blocks[i].name, range(block.min_trials, block.max_trials),
                              minutes(block.min_s, block.max_s)});
    }
    if (!protocol.questionnaire.empty()) {
        table.rows.push_back(
            {"questions", "", minutes(length.min_questions_s, length.max_questions_s)});
    }
    table.rows.push_back({"session, with breaks", range(length.min_trials, length.max_trials),
                          minutes(length.min_s, length.max_s)});
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
