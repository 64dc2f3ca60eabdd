#include "app/assistant/findings.h"
#include "base/error_text.h"
#include "base/one_line.h"
#include "device/core/board_faults.h"

#include <algorithm>

namespace springdrive::app::assistant {

namespace {

/// Of all that a board says of itself, what a person compares with the board in front of them.
constexpr std::array<std::string_view, 9> kShown{
    "board",         "serial number",       "firmware",
    "supply",        "counts per turn",     "largest voltage",
    "current limit", "largest cancelled R", "stop switch pressed"};

class IdentityStep final : public Step {
public:
    using Step::Step;

    /// The servo pauses once for it; no motor is driven.
    void update() override {
        device::Bench *const bench = session().device().device().bench();
        if (is_asked_ || bench == nullptr || servo::lets_pass(session().latest().safety.state) ||
            session().latest().health == device::DeviceHealth::lost) {
            return;
        }
        error_ = error_text_of([&] { session().servo().paused([&] { facts_ = bench->facts(); }); });
        is_asked_ = true;
    }

    [[nodiscard]] StepReport report() const override {
        StepReport report;
        report.to_do = "Compare with the board and the machine in front of you.";
        for (const device::Fact &fact : facts_) {
            if (std::ranges::find(kShown, fact.name) != kShown.end()) {
                report.see("{}: {}", fact.name, one_line(fact.value));
            }
        }
        const device::DeviceDescription &device = session().description();
        report.see("device file: {}, {}", device.name,
                   session().device_choice().file.filename().string());
        report.see("in use, by the lower of both: {:.4g} V, {:.4g} A, {:.4g} Ω",
                   device.motor[0].supply_V, device.motor[0].peak_current_A,
                   device.amplifier.max_cancelled_Ohm);
        const device::BoardFaults faults{session().latest().board_faults};
        if (!error_.empty()) {
            report.troubles.push_back({error_, "plug the board in again, then press Again"});
        } else if (is_asked_ && faults.any()) {
            report.troubles.push_back({"the board reports " + device::names_of(faults),
                                       remedy_of(faults) + "; then press Again"});
        }
        if (is_asked_) { // counts a turn were compared when it was opened
            report.verdict = report.troubles.empty() ? Verdict::good : Verdict::bad;
        }
        return report;
    }

private:
    std::vector<device::Fact> facts_;
    std::string error_;
    bool is_asked_ = false;
};

} // namespace

std::unique_ptr<Step> make_identity_step(session::Session &session) {
    return std::make_unique<IdentityStep>(session);
}

} // namespace springdrive::app::assistant
