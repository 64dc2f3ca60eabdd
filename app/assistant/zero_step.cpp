#include "app/assistant/rehearsal.h"
#include "app/assistant/step.h"
#include "base/error_text.h"

#include <cstdlib>

namespace springdrive::app::assistant {

namespace {

constexpr double kStill_s = 0.5;
/// 0.1 mm at the tip of a PHANTOM 1.0: less than a hand trembles.
constexpr int kStillStep_counts = 8;

class ZeroStep final : public Step {
public:
    explicit ZeroStep(session::Session &session) : Step(session), was_zeroed_(session.is_zeroed()) {
        note_motion();
    }

    void update() override {
        for (std::size_t i = 0; i < 3; ++i) {
            if (std::abs(session().latest().counts[i] - counts_[i]) > kStillStep_counts) {
                note_motion();
                break;
            }
        }
        still_s_ = session().latest().time_s - since_s_;
        was_zeroed_ = was_zeroed_ && session().is_zeroed();
        is_zeroed_here_ = is_zeroed_here_ && session().is_zeroed();
    }

    [[nodiscard]] StepReport report() const override {
        StepReport report;
        report.shows_pose = true;
        report.voids_later = is_zeroed_here_; // the self-test checks the zero
        report.to_do = "Hold the device in its zero pose: the upper arm level and straight towards "
                       "you, the forearm hanging, square to it. Hold it still, then press \"zero "
                       "here\". Three degrees are near enough for a touch.";
        if (!is_zeroed_here_) { // which made all counts jump
            report.see("{}",
                       is_still() ? "the device is held still" : "the device moves: hold it still");
        }
        if (is_zeroed_here_) {
            report.see("zeroed; the tip is {:.1f} mm from the origin of the picture",
                       1e3 * session().latest().tip_m.norm());
        } else if (was_zeroed_) {
            report.see("it is zeroed already; the self-test checks how well");
        }
        if (!error_.empty()) {
            report.troubles.push_back({error_, "hold it still, and try again"});
        }
        report.verdict = is_zeroed_here_ || was_zeroed_ ? Verdict::good : Verdict::open;
        return report;
    }

    [[nodiscard]] std::vector<Offer> offers() override {
        std::vector<Offer> offers{
            {"zero here", "all angles are zero from now on", [this] { zero(); }, is_still()}};
        offer_hand(
            session(), "its hand holds the zero pose", [this] { hold_zero_pose(session()); },
            error_, offers);
        return offers;
    }

private:
    [[nodiscard]] bool is_still() const { return still_s_ >= kStill_s; }
    void note_motion() {
        counts_ = session().latest().counts;
        since_s_ = session().latest().time_s;
        still_s_ = 0.0;
    }
    void zero() {
        error_ = error_text_of([&] { session().zero_device(Vector3::Zero()); });
        is_zeroed_here_ = error_.empty();
    }

    std::array<std::int32_t, 3> counts_{};
    double since_s_ = 0.0;
    double still_s_ = 0.0;
    bool was_zeroed_ = false;
    bool is_zeroed_here_ = false;
    std::string error_;
};

} // namespace

std::unique_ptr<Step> make_zero_step(session::Session &session) {
    return std::make_unique<ZeroStep>(session);
}

} // namespace springdrive::app::assistant
