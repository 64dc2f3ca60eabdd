// A step whose work is done on the thread of a loan, once a person starts it. Window and loan do
// not wait for each other:
//
//   window ── frames, wants_end ──► LoanTalk ──► loan: self-test, calibration
//   window ◄── view, outcome    ◄── LoanTalk ◄──┘
#pragma once

#include "app/assistant/step.h"
#include "base/error_text.h"
#include "base/latest_value.h"

#include <atomic>
#include <cctype>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace springdrive::app::assistant {

/// @tparam View     what is seen of it meanwhile, with `theta_rad` and whether that `has_theta`
/// @tparam Outcome  what came of it
template <typename View, typename Outcome> struct LoanTalk {
    // The window's:
    std::atomic<std::uint32_t> frames{1};
    std::atomic<bool> wants_end{false}; ///< of the motion, with what is known by then
    // The loan's:
    LatestValue<View> view;
    std::optional<Outcome> outcome; ///< written last; none if it was ended before its end
};

template <typename View, typename Outcome> class LoanStep : public Step {
public:
    using Step::Step;
    using Talk = LoanTalk<View, Outcome>;

    void update() override {
        if (!talk_) {
            return;
        }
        talk_->frames.fetch_add(1, std::memory_order_relaxed);
        view_ = talk_->view.latest();
        if (session().is_lent()) {
            return;
        }
        error_ = session().loan_error();
        outcome_ = std::move(talk_->outcome);
        was_stopped_ = error_.empty() && !outcome_;
        talk_.reset();
    }

    void end() override { stop(); }

    [[nodiscard]] std::optional<Vector3> theta_rad() const override {
        return talk_ && view_.has_theta ? std::optional(view_.theta_rad) : std::nullopt;
    }

protected:
    [[nodiscard]] bool is_running() const { return talk_ != nullptr; }
    [[nodiscard]] const View &view() const { return view_; }
    [[nodiscard]] const std::optional<Outcome> &outcome() const { return outcome_; }
    /// Why it could not begin or did not come to its end; else empty.
    [[nodiscard]] const std::string &error() const { return error_; }
    [[nodiscard]] bool was_stopped() const { return was_stopped_; } ///< by a person

    /// @param make_tick  of the talk: makes what `Session::lend_device` takes; may throw InputError
    template <typename MakeTick> void start(const MakeTick &make_tick) {
        auto talk = std::make_shared<Talk>();
        outcome_.reset();
        was_stopped_ = false;
        view_ = {};
        error_ = session().device().device().bench() == nullptr
                     ? "this device has no board"
                     : error_text_of([&] { session().lend_device(make_tick(talk)); });
        if (error_.empty()) {
            talk_ = std::move(talk);
        }
    }

    void stop() {
        if (talk_) {
            session().take_device_back();
            update();
        }
    }

    /// While it runs.
    [[nodiscard]] std::vector<Offer> offers_to_end(const char *stop_means, bool may_finish,
                                                   const char *finish, const char *finish_means) {
        std::vector<Offer> offers{{"stop", stop_means, [this] { stop(); }}};
        if (may_finish) {
            offers.push_back({finish, finish_means, [this] { talk_->wants_end = true; }});
        }
        return offers;
    }

    /// @param instruction  in lower case; empty: none
    [[nodiscard]] static std::string as_to_do(std::string instruction, const char *otherwise) {
        if (instruction.empty()) {
            return otherwise;
        }
        instruction[0] = static_cast<char>(std::toupper(instruction[0]));
        return instruction + ".";
    }

private:
    std::shared_ptr<Talk> talk_; ///< while it runs
    View view_;
    std::optional<Outcome> outcome_;
    std::string error_;
    bool was_stopped_ = false;
};

} // namespace springdrive::app::assistant
