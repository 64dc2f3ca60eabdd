#include "app/assistant/step.h"

#include "app/panels/doctor_popup.h"
#include "base/error_text.h"

#include <algorithm>

namespace springdrive::app::assistant {

namespace {

using factory::DeviceKind;

/// A link is judged by so many ticks.
constexpr std::uint64_t kJudgedReports = 1500;
/// Of reports that were lost, late or damaged. The servo bears single ones; a hundred a second is
/// no good cable.
constexpr double kBearableShare = 1e-3;

/// Ticks without their report, and commands that did not arrive. A report that is lost is one that
/// a tick misses, too.
std::uint64_t faulty_of(const device::LinkStatus &link) {
    return std::max(link.lost, link.absent) + link.late + link.rejected + link.unsent;
}

class LinkStep final : public Step {
public:
    explicit LinkStep(session::Session &session) : Step(session) {
        if (const auto link = session.device().device().link()) {
            reports_before_ = link->reports;
            faulty_before_ = faulty_of(*link);
        }
    }

    void update() override {
        const auto link = session().device().device().link();
        if (link && link->reports < reports_before_) { // connected again
            reports_before_ = 0;
            faulty_before_ = 0;
        }
    }

    [[nodiscard]] StepReport report() const override {
        StepReport report;
        if (session().device_choice().kind == DeviceKind::simulated) {
            report_choice(report);
        } else {
            report_link(report);
        }
        if (!error_.empty()) {
            report.troubles.push_back({error_, "ask the doctor, then try again"});
        }
        return report;
    }

    [[nodiscard]] std::vector<Offer> offers() override {
        std::vector<Offer> offers;
        if (session().device_choice().kind != DeviceKind::simulated || session().is_exchanging()) {
            return offers;
        }
        for (const factory::PresentDevice &device : present_) {
            if (device.kind != DeviceKind::simulated) {
                offers.push_back(
                    {device.kind == DeviceKind::usb ? "use the board " + device.serial
                                                    : "use an emulated board, to rehearse",
                     device.problem, [this, device] { use(device); }, device.problem.empty()});
            }
        }
        return offers;
    }

private:
    void use(const factory::PresentDevice &device) {
        session::DeviceChoice choice = session().device_choice();
        choice.kind = device.kind;
        choice.serial = device.serial;
        error_ = error_text_of([&] { session().exchange_device(choice); });
    }

    void report_choice(StepReport &report) const {
        report.to_do =
            "The plain simulation needs no commissioning. Plug in the board, press Again, "
            "and choose it; or rehearse with an emulated one.";
        bool has_board = false;
        for (const factory::PresentDevice &device : present_) {
            if (device.kind != DeviceKind::usb) {
                continue;
            }
            has_board = true;
            report.see("USB board {}", device.serial);
            if (!device.problem.empty()) {
                report.troubles.push_back({device.serial, device.problem});
            }
        }
        if (!has_board) {
            report.see("no USB board is connected");
        }
        report.asks_doctor = "usb";
    }

    void report_link(StepReport &report) const {
        report.to_do = "Wait while the connection is watched for some seconds.";
        report.asks_doctor = name_of(session().device_choice());
        const auto link = session().device().device().link();
        if (!link || session().latest().health == device::DeviceHealth::lost) {
            return; // said by the assistant
        }
        const std::uint64_t reports = link->reports - std::min(reports_before_, link->reports);
        const std::uint64_t faulty = faulty_of(*link) - std::min(faulty_before_, faulty_of(*link));
        report.see("{} device, serial number {}, {}", session().device().identity().kind,
                   session().device().identity().serial, link->speed);
        const double d = link->delay_s / session().servo().period_s();
        report.see(
            "{:.0f} reports a second; d {}, round trip {:.0f} µs", session().servo().rate_hz(),
            d > 0.0 ? fmt::format("{:.2f} periods", d) : "not measured", // of a board in a fault
            1e6 * link->round_trip_s);
        report.see("{} of {} reports not whole or not in time", faulty, reports);
        const double watched = static_cast<double>(reports) / static_cast<double>(kJudgedReports);
        report.bars.push_back(
            {"watched", std::min(1.0, watched), 0.0, 1.0, fmt::format("{} reports", reports)});
        if (reports < kJudgedReports) {
            return;
        }
        if (static_cast<double>(faulty) <= kBearableShare * static_cast<double>(reports)) {
            report.verdict = Verdict::good;
            report.to_do = "The connection is good. Press Next.";
            return;
        }
        report.verdict = Verdict::doubtful;
        report.troubles.push_back(
            {fmt::format("{:.2f} % of all reports did not arrive whole and in time",
                         100.0 * static_cast<double>(faulty) / static_cast<double>(reports)),
             "plug the board into the computer itself, without a hub, with a short cable; the "
             "doctor looks at speed, hub and autosuspend"});
        report.unchecked =
            "the connection is unreliable: the servo stops the device whenever reports "
            "stay away for too long";
    }

    std::vector<factory::PresentDevice> present_ = factory::devices_present();
    std::string error_;
    std::uint64_t reports_before_ = 0;
    std::uint64_t faulty_before_ = 0;
};

} // namespace

std::unique_ptr<Step> make_link_step(session::Session &session) {
    return std::make_unique<LinkStep>(session);
}

} // namespace springdrive::app::assistant
