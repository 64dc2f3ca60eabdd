#include "app/assistant/steps.h"
#include "app/assistant/stop_words.h"

#include "base/complaint.h"
#include "base/one_line.h"
#include "device/core/board_faults.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::assistant {

namespace {

/// Of all that a board says of itself, what a person compares with the board in front of them.
constexpr std::array<std::string_view, 9> kShown{
    "board",         "serial number",       "firmware",
    "supply",        "counts per turn",     "largest voltage",
    "current limit", "largest cancelled R", "stop switch pressed"};

class IdentityStep final : public Step {
public:
    void begin(session::Session &session) override {
        facts_.clear();
        complaint_.clear();
        is_asked_ = false;
        ask(session);
    }

    void update(session::Session &session) override {
        if (!is_asked_) {
            ask(session);
        }
    }

    [[nodiscard]] StepReport report(const session::Session &session) const override {
        StepReport report;
        report.to_do = "Compare with the board and the machine in front of you.";
        for (const device::Fact &fact : facts_) {
            if (std::ranges::find(kShown, fact.name) != kShown.end()) {
                report.seen.push_back(fact.name + ": " + one_line(fact.value));
            }
        }
        const device::DeviceDescription &device = session.description();
        report.seen.push_back(fmt::format("device file: {}, {}", device.name,
                                          session.device_choice().file.filename().string()));
        report.seen.push_back(fmt::format("in use, by the lower of both: {:.4g} V, {:.4g} A, "
                                          "{:.4g} Ω",
                                          device.motor[0].supply_V, device.motor[0].peak_current_A,
                                          device.amplifier.max_cancelled_Ohm));
        if (!complaint_.empty()) {
            report.troubles.push_back({complaint_, "plug the board in again, then press Again"});
            report.verdict = Verdict::bad;
            return report;
        }
        if (!is_asked_) {
            return report;
        }
        const device::BoardFaults faults{session.latest().board_faults};
        if (faults.any()) {
            report.troubles.push_back({"the board reports " + device::names_of(faults),
                                       remedy_of(faults) + "; then press Again"});
            report.verdict = Verdict::bad;
            return report;
        }
        report.verdict = Verdict::good; // counts a turn were compared when it was opened
        return report;
    }

private:
    /// The servo pauses meanwhile; no motor is driven.
    void ask(session::Session &session) {
        device::Bench *const bench = session.device().device().bench();
        if (bench == nullptr || servo::lets_pass(session.latest().safety.state) ||
            session.latest().health == device::DeviceHealth::lost) {
            return;
        }
        complaint_ =
            complaint_of([&] { session.servo().paused([&] { facts_ = bench->facts(); }); });
        is_asked_ = true;
    }

    std::vector<device::Fact> facts_;
    std::string complaint_;
    bool is_asked_ = false;
};

} // namespace

std::unique_ptr<Step> make_identity_step() { return std::make_unique<IdentityStep>(); }

} // namespace springdrive::app::assistant
