#include "app/assistant/rehearsal.h"
#include "app/assistant/step.h"
#include "app/host/asset_folder.h"
#include "base/error_text.h"
#include "engine/control/tuning_file.h"

#include <algorithm>
#include <system_error>

namespace springdrive::app::assistant {

namespace {

using simulated::HandPath;

/// Of the tip, while a person touches for the first time.
constexpr double kGentleForce_N = 1.0;
/// What counts as a touch.
constexpr double kFelt_N = 0.15;
constexpr double kFelt_s = 0.5;
// Of the simulated hand:
constexpr double kAbove_m = 0.02; ///< the scene, before and after a press
constexpr double kDepth_m = 0.004;

class TouchStep final : public Step {
public:
    explicit TouchStep(session::Session &session)
        : Step(session), last_s_(session.latest().time_s) {
        error_ = error_text_of([&] {
            const control::Tuning soft =
                control::read_tuning_file(asset_folder() / "tunings" / "soft.toml");
            const std::filesystem::path plate = asset_folder() / "scenes" / "plate.gltf";
            std::error_code ignored;
            if (!std::filesystem::equivalent(plate, session.scenes().now().scene.file, ignored)) {
                session.request_scene(plate);
            }
            before_ = Before{session.tuning().now(), session.servo().inputs().limits};
            servo::SafetyLimits gentle = before_->limits;
            gentle.tip_force_N = std::min(gentle.tip_force_N, kGentleForce_N);
            session.tuning().replace(soft, session.plot_time_s(), "for the first touch");
            session.servo().lower_limits(gentle);
        });
        session.keep_released(!error_.empty());
    }

    void update() override {
        const servo::ServoSample &now = session().latest();
        if (presses_next_ && now.safety.state == servo::SafetyState::running &&
            !session().hand().follows_path()) {
            presses_next_ = false; // before, it would press on a device that only brakes
            error_ = error_text_of([&] { press_and_lift(); });
        }
        const double passed_s = std::max(0.0, now.time_s - last_s_);
        last_s_ = now.time_s;
        if (now.safety.state != servo::SafetyState::running || session().scenes().is_loading()) {
            return;
        }
        const double force_N = now.contact.touching ? now.tip_force_N.norm() : 0.0;
        peak_N_ = std::max(peak_N_, force_N);
        felt_s_ += force_N >= kFelt_N ? passed_s : 0.0;
    }

    void end() override {
        session().keep_released(true);
        if (before_) {
            session().tuning().replace(before_->tuning, session().plot_time_s(),
                                       "after the first touch");
            session().servo().lower_limits(before_->limits);
        }
    }

    [[nodiscard]] StepReport report() const override {
        const servo::ServoSample &now = session().latest();
        StepReport report;
        report.to_do = to_do();
        const bool touches =
            now.contact.touching && now.safety.state == servo::SafetyState::running;
        const double force_N = touches ? now.tip_force_N.norm() : 0.0;
        report.bars.push_back(
            {"force", force_N, 0.0, kGentleForce_N, fmt::format("{:.2f} N", force_N)});
        report.see("depth {:.1f} mm, felt for {:.1f} of {:.1f} s, at most {:.2f} N",
                   touches ? 1e3 * (now.contact.x0_m - now.tip_m).norm() : 0.0,
                   std::min(felt_s_, kFelt_s), kFelt_s, peak_N_);
        report.see("tuning soft, force limited to {:.0f} N; both return to what they were "
                   "afterwards",
                   kGentleForce_N);
        if (!error_.empty()) {
            report.troubles.push_back({error_, "reinstall springdrive, then press Again"});
            report.verdict = Verdict::bad;
        } else if (felt_s_ >= kFelt_s) {
            report.verdict = Verdict::good;
        }
        return report;
    }

    [[nodiscard]] std::vector<Offer> offers() override {
        std::vector<Offer> offers;
        const auto act = [this] {
            presses_next_ = true;
            const Vector3 there_m = above_the_middle(kAbove_m);
            session().follow_path(HandPath({{0.0, there_m}, {0.5, there_m}}));
        };
        offer_hand(session(), "its hand presses and lifts", act, error_, offers);
        for (Offer &offer : offers) {
            offer.is_enabled =
                offer.is_enabled && !presses_next_ && !session().scenes().is_loading();
        }
        return offers;
    }

private:
    struct Before {
        control::Tuning tuning;
        servo::SafetyLimits limits;
    };

    [[nodiscard]] Vector3 above_the_middle(double above_m) const {
        const scene::Scene &scene = session().scenes().now().scene;
        const Vector3 middle_m = 0.5 * (scene.lower_m + scene.upper_m);
        return {middle_m.x(), scene.upper_m.y() + above_m, middle_m.z()};
    }
    void press_and_lift() {
        const Vector3 above_m = above_the_middle(kAbove_m);
        const Vector3 within_m = above_the_middle(-kDepth_m);
        session().follow_path(
            HandPath({{0.0, above_m}, {1.0, within_m}, {2.5, within_m}, {3.5, above_m}}));
    }

    [[nodiscard]] std::string to_do() const {
        if (felt_s_ >= kFelt_s) {
            return "That was it: the plate gave way softly and pushed back. Press Finish.";
        }
        if (session().scenes().is_loading()) {
            return "The plate is being loaded.";
        }
        switch (session().latest().safety.state) {
        case servo::SafetyState::waiting:
            return session().latest().contact.touching
                       ? "Lift the tip off the plate, and hold it still: the motors start then."
                       : "Hold the tip still above the plate: the motors start then.";
        case servo::SafetyState::starting:
            return "The motors start.";
        default:
            return "Move down onto the plate and press gently. It should feel like a soft cushion, "
                   "without a buzz, and push straight up. If it pulls or grows by itself: F12.";
        }
    }

    std::optional<Before> before_;
    bool presses_next_ = false; ///< the simulated hand, once the motors run
    double felt_s_ = 0.0;
    double peak_N_ = 0.0;
    double last_s_ = 0.0;
    std::string error_;
};

} // namespace

std::unique_ptr<Step> make_touch_step(session::Session &session) {
    return std::make_unique<TouchStep>(session);
}

} // namespace springdrive::app::assistant
