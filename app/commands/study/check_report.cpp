#include "app/commands/study/check_report.h"

#include "base/print.h"

#include <algorithm>
#include <cstddef>

namespace springdrive::app {

namespace {

void write_length(std::ostream &out, const study::Protocol &protocol,
                  const study::SessionLength &length) {
    print(out, "\n{:<24} {:>13} {:>13}\n", "block", "trials", "min");
    for (std::size_t i = 0; i < length.blocks.size(); ++i) {
        const study::BlockLength &block = length.blocks[i];
        print(out, "{:<24} {:>6}-{:<6} {:>6.1f}-{:<6.1f}\n", protocol.blocks[i].name,
              block.fewest_trials, block.most_trials, block.fewest_s / 60.0, block.most_s / 60.0);
    }
    if (!protocol.questionnaire.empty()) {
        print(out, "{:<24} {:>13} {:>6.1f}-{:<6.1f}\n", "questions", "",
              length.fewest_questions_s / 60.0, length.most_questions_s / 60.0);
    }
    print(out, "{:<24} {:>6}-{:<6} {:>6.1f}-{:<6.1f}\n", "session, with breaks",
          length.fewest_trials, length.most_trials, length.fewest_s / 60.0, length.most_s / 60.0);
}

void write_trials(std::ostream &out, const std::vector<study::ConditionTrial> &trials) {
    if (trials.empty()) {
        return;
    }
    print(out, "\n{:<64} {:>7} {:>8} {:>8} {:>8}\n", "simulated", "force N", "slid mm", "deep mm",
          "given mJ");
    for (const study::ConditionTrial &trial : trials) {
        print(out, "{:<64} {:>7.2f} {:>8.2f} {:>8.2f} {:>8.2f}\n", trial.name,
              trial.largest_force_N, 1e3 * trial.slid_m, 1e3 * trial.deepest_m,
              1e3 * trial.generated_J);
    }
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
